//! `eosphor bench`: how fast a device is.

mod rays;
mod render;

pub(crate) use rays::bench_rays;
pub(crate) use render::bench_render;

/// The middle one, or the higher of two; 0 if there is none.
fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(0.0)
}
