//! Bounds of a ray's `t` as seen from another point of the ray, where a walk measures from.

use crate::intersect::T_ROUNDING;

/// More than sums of `t` in double precision lose, over what is added up.
pub const LOST: f64 = 1.0 / (1u64 << 50) as f64;

/// Bounds of a `t` that may be wrong by this, as seen from a point of the ray.
#[inline(always)]
pub(super) fn around(t: f64, from: f64, error: f64) -> (f32, f32) {
    let (moved, error) = (t - from, error + (t.abs() + from.abs()) * LOST);
    // Infinity stays what it is.
    if !moved.is_finite() {
        return (moved as f32, moved as f32);
    }
    let (low, high) = ((moved - error) as f32, (moved + error) as f32);
    (low - low.abs() * T_ROUNDING, high + high.abs() * T_ROUNDING)
}

/// Bounds of what counts as no later than this: hits whose `t` is rounded to it do.
#[inline(always)]
pub(super) fn around_end(t_max: f32, from: f64) -> (f32, f32) {
    let error = if t_max.is_finite() { t_max.abs() * T_ROUNDING } else { 0.0 };
    around(t_max as f64, from, error as f64)
}

/// Where a search ends, as seen from a point that a walk has moved the origin to.
#[inline(always)]
pub fn moved_end(end: f64, from: f64) -> f32 {
    around(end, from, 0.0).1
}

/// And what lies before this `t` for certain ends before this.
#[inline(always)]
pub fn moved_start(start: f64, from: f64) -> f32 {
    around(start, from, 0.0).0
}

/// What a `t` from a moved origin has to be widened by, so that bounds that do not overlap are in the order of double precision:
/// its own `t`, by which hits are ordered, has been rounded where it is large. `lost` is [`LOST`] of the way to that origin.
#[inline(always)]
pub fn widening(t: f32, lost: f32) -> f32 {
    // The rounding of this sum is less than that of `t`.
    lost + t.abs() * T_ROUNDING
}
