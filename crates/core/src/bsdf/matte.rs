//! A matte surface by itself.

use super::closure::Scattered;
use crate::math::Vec3;
use core::f32::consts::FRAC_1_PI;

/// A matte base (Lambert) with nothing over it, as it scatters light: chosen by `cosine_direction`, to the viewer's side.
#[derive(Clone, Copy, Debug)]
pub struct Matte {
    /// Albedo over pi.
    pub value: Vec3,
    /// The probability that a path goes on: 1, or 0 where the surface is black.
    pub chance: f32,
}

impl Matte {
    /// Of an albedo.
    #[inline(always)]
    pub fn new(albedo: Vec3) -> Matte {
        Matte { value: albedo * FRAC_1_PI, chance: if albedo.max_component() > 0.0 { 1.0 } else { 0.0 } }
    }

    /// Light that arrives at this cosine, which is above 0.
    #[inline(always)]
    pub fn eval(&self, cos: f32) -> Scattered {
        Scattered { value: self.value * cos, pdf: FRAC_1_PI * self.chance * cos }
    }
}
