//! A band of rows: a warp takes some pixels that lie together, and each of its threads some samples of one.

use crate::totals::RayTotals;
use crate::warp::{self, WARP};
use crate::watch::Watching;
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x};
use eosphor_core::hierarchy::Tracer;
use eosphor_core::integrator::{RayCounts, Samples, pixel_color, render_samples};
use eosphor_core::math::Vec3;
use eosphor_core::sums::ExactSum;
use eosphor_core::view::SceneView;

/// Rows `first .. end` of a picture, which of its pixels' samples are taken, and how many threads share those of a pixel:
/// 2^`sharing`, at most a warp.
#[derive(Clone, Copy)]
pub(crate) struct Band {
    pub(crate) first: u32,
    pub(crate) end: u32,
    pub(crate) first_sample: u32,
    pub(crate) end_sample: u32,
    pub(crate) sharing: u32,
}

/// Where a band's pixels go to, row after row: as colours, which is for all samples at once, or as sums.
#[derive(Clone, Copy)]
pub(crate) struct Output {
    pub(crate) film: *mut Vec3,
    /// Null where colours are wanted.
    pub(crate) sums: *mut ExactSum,
}

impl Band {
    /// The pixel of a thread; it may lie outside.
    #[inline(always)]
    fn pixel(&self, width: u32, warp: u32, lane: u32) -> (u32, u32) {
        // 8 x 4 pixels, 4 x 4, 4 x 2 and so on: rays of a warp stay together.
        let bits = WARP.trailing_zeros() - self.sharing;
        let (across, down) = (bits.div_ceil(2), bits / 2);
        // Never 0; said here so that there is no panic for the division.
        let tiles_in_row = (width + (1 << across) - 1 >> across).max(1);
        let place = lane >> self.sharing;
        let x = (warp % tiles_in_row << across) + (place & (1 << across) - 1);
        let y = self.first + (warp / tiles_in_row << down) + (place >> across);
        (x, y)
    }
}

/// Renders the thread's share of its pixel.
///
/// # Safety
///
/// `sums`, or where they are null `film`, must have room for the band's pixels.
#[inline(always)]
pub(crate) unsafe fn render_band<T: Tracer>(
    view: &SceneView,
    tracer: &T,
    band: Band,
    output: Output,
    totals: &RayTotals,
    watching: &impl Watching,
) {
    let width = view.settings.width;
    // SAFETY: these read the thread's numbers.
    let thread = unsafe { (_block_idx_x() as u32) * (_block_dim_x() as u32) + _thread_idx_x() as u32 };
    let lane = thread % WARP;
    let (x, y) = band.pixel(width, thread / WARP, lane);
    let is_inside = x < width && y < band.end;
    let sharers = 1 << band.sharing;
    let share = lane & (sharers - 1);
    // Threads without a pixel go on, because the others count on them.
    let first = if is_inside { band.first_sample + share } else { band.end_sample };
    let mut counts = RayCounts::default();
    let samples = Samples { first, end: band.end_sample, step: sharers };
    let own = render_samples::<T, 1>(view, tracer, (x, y), samples, &mut counts);
    let sum = warp::merged(own, sharers);
    totals.add(&counts, lane);
    watching.add_to(totals, lane);
    if is_inside & (share == 0) {
        let index = (y - band.first) as usize * width as usize + x as usize;
        // SAFETY: x and y are in the band.
        unsafe {
            match output.sums.is_null() {
                true => *output.film.add(index) = pixel_color(view, &sum),
                false => *output.sums.add(index) = sum,
            }
        }
    }
}
