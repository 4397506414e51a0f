//! Weights of morph targets by time.

use super::accessors::Accessors;
use super::animations::{check_times, keys_of};
use super::document::{AnimationSampler, Interpolation};
use crate::model::{WeightInterpolation, WeightTrack};

/// The keys of a sampler for a mesh with so many targets.
pub(super) fn track(
    accessors: &Accessors<'_>,
    sampler: &AnimationSampler,
    targets: usize,
) -> Result<WeightTrack, String> {
    let interpolation = match sampler.interpolation {
        Some(Interpolation::Step) => WeightInterpolation::Step,
        Some(Interpolation::Linear) => WeightInterpolation::Linear,
        Some(Interpolation::CubicSpline) => WeightInterpolation::Cubic,
        None => return Err("its interpolation is unknown; it must be LINEAR, STEP or CUBICSPLINE".into()),
    };
    let times = accessors.read(sampler.input.value(), |[seconds]: [f32; 1]| seconds);
    let times = times.map_err(|e| format!("its times: {e}"))?;
    let values = accessors.read(sampler.output.value(), |[weight]: [f32; 1]| weight);
    let values = values.map_err(|e| format!("its values: {e}"))?;
    check_times(&times)?;
    let each = if interpolation == WeightInterpolation::Cubic { 3 * targets } else { targets };
    if Some(values.len()) != times.len().checked_mul(each) {
        let (found, times) = (values.len(), times.len());
        return Err(format!(
            "there are {found} weights for {times} times and {targets} morph targets, not {each} for each time; export \
             it again"
        ));
    }
    if let Some(place) = values.iter().position(|x| !x.is_finite()) {
        return Err(format!("the weights of key {} are not finite; export it again", place / each));
    }
    let mut track = WeightTrack { interpolation, seconds: Vec::new(), values: Vec::new(), count: targets };
    for key in keys_of(&times) {
        track.seconds.push(times[key]);
        track.values.extend_from_slice(&values[key * each..(key + 1) * each]);
    }
    Ok(track)
}
