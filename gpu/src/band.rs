//! A band of rows: a warp takes some pixels that lie together, and each of its threads some samples of one.

use crate::totals::Totals;
use crate::warp::{self, WARP};
use crate::watch::Watching;
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x};
use eosphor_core::device::BandLaunch;
use eosphor_core::hierarchy::Tracer;
use eosphor_core::integrator::{Follow, RayCounts, Samples, pixel_color, render_samples_by};
use eosphor_core::view::SceneView;

/// The pixel of a thread; it may lie outside.
#[inline(always)]
fn pixel(launch: &BandLaunch, width: u32, warp: u32, lane: u32) -> (u32, u32) {
    // 8 x 4 pixels, 4 x 4, 4 x 2 and so on: rays of a warp stay together.
    let bits = WARP.trailing_zeros() - launch.sharing;
    let (across, down) = (bits.div_ceil(2), bits / 2);
    // Never 0; said here so that there is no panic for the division.
    let tiles_in_row = (width + (1 << across) - 1 >> across).max(1);
    let place = lane >> launch.sharing;
    let x = (warp % tiles_in_row << across) + (place & (1 << across) - 1);
    let y = launch.first_row + (warp / tiles_in_row << down) + (place >> across);
    (x, y)
}

/// Renders the thread's share of its pixel, by an integrator.
///
/// # Safety
///
/// The launch's `sums`, or where they are null its `film`, must have room for the band's pixels, and its `totals` must be there.
#[inline(always)]
pub(crate) unsafe fn render_band<T: Tracer, F: Follow>(
    view: &SceneView,
    tracer: &T,
    launch: &BandLaunch,
    watching: &impl Watching,
) {
    let width = view.settings.width;
    // SAFETY: these read the thread's numbers.
    let thread = unsafe { (_block_idx_x() as u32) * (_block_dim_x() as u32) + _thread_idx_x() as u32 };
    let lane = thread % WARP;
    let (x, y) = pixel(launch, width, thread / WARP, lane);
    let is_inside = x < width && y < launch.end_row;
    let sharers = 1 << launch.sharing;
    let share = lane & (sharers - 1);
    // Threads without a pixel go on, because the others count on them.
    let first = if is_inside { launch.first_sample + share } else { launch.end_sample };
    let mut counts = RayCounts::default();
    let samples = Samples { first, end: launch.end_sample, step: sharers };
    let own = render_samples_by::<T, F>(view, tracer, (x, y), samples, &mut counts);
    let sum = warp::merged(own, sharers);
    // SAFETY: the totals are there.
    let totals = unsafe { Totals::new(launch.totals) };
    totals.add(&counts, lane);
    watching.add_to(&totals, lane);
    if is_inside & (share == 0) {
        let index = (y - launch.first_row) as usize * width as usize + x as usize;
        // SAFETY: x and y are in the band.
        unsafe {
            match launch.sums.is_null() {
                true => *launch.film.add(index) = pixel_color(view, &sum),
                false => *launch.sums.add(index) = sum,
            }
        }
    }
}
