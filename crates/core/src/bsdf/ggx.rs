//! Microfacets distributed by GGX (Trowbridge and Reitz 1975; Walter et al. 2007, "Microfacet models for refraction through rough
//! surfaces").
//!
//! Directions are in a frame whose z is the surface's normal.

use crate::math::{Vec3, elementary, max, sqrt, vec3};

/// Facets of an isotropic surface.
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    /// Roughness: the slope of which half the facets are less steep. Over 0.
    pub alpha: f32,
}

impl Ggx {
    /// Density of facets of this unit normal, per steradian, of the surface's area.
    #[inline(always)]
    pub fn density(&self, normal: Vec3) -> f32 {
        // By the sine, which is exact where the cosine is 1.
        let slope = (normal.x * normal.x + normal.y * normal.y) / (self.alpha * self.alpha);
        let stretched = slope + normal.z * normal.z;
        let below = core::f32::consts::PI * self.alpha * self.alpha * stretched * stretched;
        if below > 0.0 { 1.0 / below } else { 0.0 }
    }

    /// Smith's auxiliary function, of a direction's cosine.
    #[inline(always)]
    fn lambda(&self, cos: f32) -> f32 {
        let cos2 = max(cos * cos, f32::MIN_POSITIVE);
        let tan2 = max(1.0 - cos2, 0.0) / cos2;
        0.5 * (sqrt(1.0 + self.alpha * self.alpha * tan2) - 1.0)
    }

    /// The share of facets that a direction sees.
    #[inline(always)]
    pub fn masking(&self, cos: f32) -> f32 {
        1.0 / (1.0 + self.lambda(cos))
    }

    /// The share that two directions see, on one side or on both: correlated by height (Heitz 2014, "Understanding the
    /// masking-shadowing function in microfacet-based BRDFs").
    #[inline(always)]
    pub fn masking_shadowing(&self, cos_in: f32, cos_out: f32) -> f32 {
        1.0 / (1.0 + self.lambda(cos_in) + self.lambda(cos_out))
    }

    /// Density of the normals of [`Ggx::visible_normal`], per steradian; the viewer's z is over 0.
    #[inline(always)]
    pub fn visible_density(&self, to_viewer: Vec3, normal: Vec3) -> f32 {
        let cos = max(to_viewer.dot(normal), 0.0);
        self.masking(to_viewer.z) * cos * self.density(normal) / to_viewer.z
    }

    /// The normal of a facet that the viewer sees, by spherical caps (Dupuy and Benyoub 2023, "Sampling visible GGX normals with
    /// spherical caps").
    #[inline(always)]
    pub fn visible_normal(&self, to_viewer: Vec3, u: [f32; 2]) -> Vec3 {
        let alpha = self.alpha;
        let up = vec3(0.0, 0.0, 1.0);
        let viewer = vec3(to_viewer.x * alpha, to_viewer.y * alpha, to_viewer.z).normalize_or(up);
        let z = (1.0 - u[1]) * (1.0 + viewer.z) - viewer.z;
        let radius = sqrt(max((1.0 - z) * (1.0 + z), 0.0));
        let (s, c) = elementary::sin_cos(core::f32::consts::TAU * u[0]);
        let half = vec3(radius * c, radius * s, z) + viewer;
        vec3(half.x * alpha, half.y * alpha, max(half.z, 0.0)).normalize_or(up)
    }
}
