//! `eosphor bench`: how fast a device is.

mod export;
mod noise;
mod rays;
mod render;

pub(crate) use noise::bench_noise;
pub(crate) use rays::bench_rays;
pub(crate) use render::bench_render;

use crate::failure::Failure;
use eosphor_lab::{MILLISECONDS, Quantity, Times};

/// Times that were measured, for `eosphor lab`.
fn timed(quantity: &str, times: &Times) -> Quantity {
    let Times { wall, cpu } = times.clone();
    // Work that takes less than the clock of cores can tell has no time of cores.
    let cpu = if cpu.iter().all(|&cpu| cpu > 0.0) { cpu } else { Vec::new() };
    Quantity {
        quantity: quantity.into(),
        unit: MILLISECONDS.into(),
        values: wall,
        cpu,
        ..Quantity::default()
    }
}

/// The same of rays with an answer.
fn answered(quantity: &str, times: &Times, rays: u64, answer: blake3::Hash) -> Quantity {
    let answer = Some(answer.to_hex()[..16].to_owned());
    Quantity { work: Some(rays), answer, ..timed(quantity, times) }
}

/// As `eosphor lab` reads them.
fn lines(quantities: &[Quantity]) -> Result<String, Failure> {
    let line = |quantity| Ok(serde_json::to_string(quantity).map_err(Failure::because)? + "\n");
    quantities.iter().map(line).collect()
}

/// The middle one, or the higher of two; 0 if there is none.
fn median(times: &[f64]) -> f64 {
    let mut times = times.to_vec();
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(0.0)
}
