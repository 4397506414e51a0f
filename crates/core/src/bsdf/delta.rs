//! Sharp mirrors and clear glass.

use crate::math::Vec3;

/// A sharp lobe: only light from `direction` counts.
#[derive(Clone, Copy, Debug)]
pub struct Delta {
    /// Unit vector.
    pub direction: Vec3,
}

impl Delta {
    /// Nothing: light that is sampled never comes from just there.
    #[inline(always)]
    pub fn eval(&self, _to_light: Vec3) -> f32 {
        0.0
    }

    /// The direction.
    #[inline(always)]
    pub fn sample(&self, _u: [f32; 2]) -> Vec3 {
        self.direction
    }

    /// Nothing: a single direction has no density.
    #[inline(always)]
    pub fn pdf(&self, _to_light: Vec3) -> f32 {
        0.0
    }
}
