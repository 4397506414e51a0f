//! A band of rows, a pixel a thread.

use crate::totals::RayTotals;
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x};
use eosphor_core::hierarchy::Tracer;
use eosphor_core::math::Vec3;
use eosphor_core::view::SceneView;
use eosphor_core::whitted::{RayCounts, pixel_color, render_pixel};

/// The pixel of this thread in rows `first_row .. end_row`: a warp takes 8 × 4 pixels, whose rays stay together.
#[inline(always)]
fn pixel_of_thread(width: u32, first_row: u32, end_row: u32) -> Option<(u32, u32)> {
    // SAFETY: these read the thread's numbers.
    let thread = unsafe { (_block_idx_x() as u32) * (_block_dim_x() as u32) + _thread_idx_x() as u32 };
    let (tile, lane) = (thread / 32, thread % 32);
    // Never 0; said here so that there is no panic for the division.
    let tiles_in_row = width.div_ceil(8).max(1);
    let x = tile % tiles_in_row * 8 + lane % 8;
    let y = first_row + tile / tiles_in_row * 4 + lane / 8;
    (x < width && y < end_row).then_some((x, y))
}

/// Renders the thread's pixel, all samples of it.
///
/// # Safety
///
/// `film` must have room for the band's pixels.
#[inline(always)]
pub(crate) unsafe fn render_band<T: Tracer>(
    view: &SceneView,
    tracer: &T,
    first_row: u32,
    end_row: u32,
    film: *mut Vec3,
    totals: &RayTotals,
) {
    let width = view.settings.width;
    let Some((x, y)) = pixel_of_thread(width, first_row, end_row) else { return };
    let mut counts = RayCounts::default();
    let sum = render_pixel::<T, 1>(view, tracer, x, y, &mut counts);
    let index = (y - first_row) as usize * width as usize + x as usize;
    // SAFETY: x and y are in the band.
    unsafe { *film.add(index) = pixel_color(view, &sum) };
    totals.add(&counts);
}
