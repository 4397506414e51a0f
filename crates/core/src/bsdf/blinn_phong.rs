//! Blinn's highlight (1977).

use super::{CosinePower, reflect};
use crate::math::elementary::pow;
use crate::math::{Vec3, max};

/// A highlight `max(0, N.H)^exponent`, H being the direction halfway between light and viewer.
#[derive(Clone, Copy, Debug)]
pub struct BlinnPhong {
    /// Unit normal for shading, on the viewer's side.
    pub normal: Vec3,
    /// Unit vector to the viewer.
    pub to_viewer: Vec3,
    /// The larger, the smaller the highlight.
    pub exponent: f32,
}

impl BlinnPhong {
    /// The highlight's factor; light is not weighted by its cosine.
    #[inline(always)]
    pub fn eval(&self, to_light: Vec3) -> f32 {
        pow(max(self.normal.dot(self.halfway(to_light)), 0.0), self.exponent)
    }

    /// The viewer, mirrored at a direction about the normal.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        reflect(-self.to_viewer, self.about_normal().sample(u))
    }

    /// The density of the halfway direction over the `4 (H.V)` by which the reflection spreads it.
    #[inline(always)]
    pub fn pdf(&self, to_light: Vec3) -> f32 {
        let halfway = self.halfway(to_light);
        let spread = 4.0 * halfway.dot(self.to_viewer);
        // The opposite halfway direction is below the surface, where the lobe has none.
        if spread > 0.0 { self.about_normal().pdf(halfway) / spread } else { 0.0 }
    }

    #[inline(always)]
    fn halfway(&self, to_light: Vec3) -> Vec3 {
        (to_light + self.to_viewer).normalize_or(Vec3::ZERO)
    }

    #[inline(always)]
    fn about_normal(&self) -> CosinePower {
        CosinePower { axis: self.normal, exponent: self.exponent }
    }
}
