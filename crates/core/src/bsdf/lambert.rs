//! Matte surfaces.

use crate::math::{Vec3, max};
use crate::sampling::{cosine_lobe, onto_axis};

/// Light that is scattered equally to all sides.
#[derive(Clone, Copy, Debug)]
pub struct Lambert {
    /// Unit normal for shading, on the viewer's side.
    pub normal: Vec3,
}

impl Lambert {
    /// The cosine of the light's incidence; 0 from below.
    #[inline(always)]
    pub fn eval(&self, to_light: Vec3) -> f32 {
        max(self.normal.dot(to_light), 0.0)
    }

    /// A unit direction about the normal.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        onto_axis(self.normal, cosine_lobe(1.0, u))
    }

    /// The cosine over pi.
    #[inline(always)]
    pub fn pdf(&self, to_light: Vec3) -> f32 {
        core::f32::consts::FRAC_1_PI * self.eval(to_light)
    }
}
