//! Colours of HDR pictures.

use crate::model::MAX_COORDINATE;

/// A channel as scenes can use it: not negative, and finite. What is no number is 0; infinities and what is beyond
/// become 1e12, the largest number of a scene and far above the sun's radiance.
pub(super) fn usable(x: f32) -> f32 {
    // Not `clamp`, which keeps NaN.
    if x > 0.0 { x.min(MAX_COORDINATE) } else { 0.0 }
}
