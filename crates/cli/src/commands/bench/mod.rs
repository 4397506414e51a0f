//! `eosphor bench`: how fast a device is.

mod rays;
mod render;

pub(crate) use rays::bench_rays;
pub(crate) use render::bench_render;

use crate::failure::Failure;
use eosphor_lab::Quantity;

/// A time that was measured, as a line for `eosphor lab`.
fn lab_line(quantity: &str, work: u64, answer: blake3::Hash, times: &[f64]) -> Result<String, Failure> {
    let answer = Some(answer.to_hex()[..16].to_owned());
    let (quantity, milliseconds) = (quantity.to_owned(), times.to_vec());
    let quantity = Quantity { quantity, work, answer, hits: None, milliseconds };
    Ok(serde_json::to_string(&quantity).map_err(Failure::because)? + "\n")
}

/// The middle one, or the higher of two; 0 if there is none.
fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(0.0)
}
