//! Glossy mirrors and glossy glass (Lafortune and Willems 1994).

use crate::math::elementary::pow;
use crate::math::{Vec3, max};
use crate::sampling::{cosine_lobe, onto_axis};

/// Light from about an axis, as densely as `cos^exponent` of the angle to it.
#[derive(Clone, Copy, Debug)]
pub struct CosinePower {
    /// Unit vector: the direction of a sharp mirror or of clear glass.
    pub axis: Vec3,
    /// The larger, the sharper.
    pub exponent: f32,
}

impl CosinePower {
    /// The density: the lobe gathers the mean of what comes.
    #[inline(always)]
    pub fn eval(&self, to_light: Vec3) -> f32 {
        self.pdf(to_light)
    }

    /// A unit direction about the axis.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        onto_axis(self.axis, cosine_lobe(self.exponent, u))
    }

    /// `(n + 1) / (2 pi) cos^n` with `n` = `exponent`.
    #[inline(always)]
    pub fn pdf(&self, to_light: Vec3) -> f32 {
        const OVER_HEMISPHERE: f32 = 0.5 * core::f32::consts::FRAC_1_PI;
        (self.exponent + 1.0) * OVER_HEMISPHERE * pow(max(self.axis.dot(to_light), 0.0), self.exponent)
    }
}
