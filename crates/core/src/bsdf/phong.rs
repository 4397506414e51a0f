//! Phong's highlight (1975).

use super::{CosinePower, reflect};
use crate::math::elementary::pow;
use crate::math::{Vec3, max};

/// A highlight `max(0, V.R)^exponent`, R being the light's mirrored direction.
#[derive(Clone, Copy, Debug)]
pub struct Phong {
    /// Unit normal for shading, on the viewer's side.
    pub normal: Vec3,
    /// Unit vector to the viewer.
    pub to_viewer: Vec3,
    /// The larger, the smaller the highlight.
    pub exponent: f32,
}

impl Phong {
    /// The highlight's factor; light is not weighted by its cosine.
    #[inline(always)]
    pub fn eval(&self, to_light: Vec3) -> f32 {
        let mirrored = (-to_light).plus_scaled(self.normal, 2.0 * self.normal.dot(to_light));
        pow(max(mirrored.dot(self.to_viewer), 0.0), self.exponent)
    }

    /// A unit direction about the mirrored viewer.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        self.about_mirror().sample(u)
    }

    /// That of the cosine's power.
    #[inline(always)]
    pub fn pdf(&self, to_light: Vec3) -> f32 {
        self.about_mirror().pdf(to_light)
    }

    #[inline(always)]
    fn about_mirror(&self) -> CosinePower {
        CosinePower { axis: reflect(-self.to_viewer, self.normal), exponent: self.exponent }
    }
}
