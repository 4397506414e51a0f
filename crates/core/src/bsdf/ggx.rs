//! Surfaces of microfacets whose normals follow the distribution of Trowbridge and Reitz (1975), "GGX" (Walter et al. 2007).
//!
//! Directions are unit vectors in the frame of the surface: z is its normal, on the viewer's side. Masking and shadowing are
//! Smith's, correlated by height (Heitz 2014, "Understanding the masking-shadowing function in microfacet-based BRDFs").

use crate::math::{Vec3, elementary, fma, max, sqrt, vec3};

/// An isotropic GGX surface.
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    /// Roughness: the slope of the microfacets, above 0, at most 1.
    pub alpha: f32,
}

/// Microfacets between two directions.
#[derive(Clone, Copy, Debug)]
pub struct Facets {
    /// Cosine between the viewer and their normal; not above 0 where they cannot send light from one direction to the other.
    pub cos: f32,
    /// The scattering function times the cosine to the light, if they reflect (or transmit) all light.
    pub value: f32,
    /// Density of the direction to the light where normals are chosen by [`Ggx::sample_visible_normal`], per steradian.
    pub pdf: f32,
}

impl Facets {
    /// There are none.
    pub const NONE: Facets = Facets { cos: 0.0, value: 0.0, pdf: 0.0 };
}

impl Ggx {
    /// Density of microfacet normals at the unit vector `h` (above the surface), per steradian and area of the surface.
    ///
    /// The sine's square is taken from x and y: `1 - z^2` has no digits left in a narrow lobe.
    #[inline(always)]
    pub fn normals(&self, h: Vec3) -> f32 {
        let a2 = self.alpha * self.alpha;
        let t = fma(a2 * h.z, h.z, fma(h.x, h.x, h.y * h.y));
        core::f32::consts::FRAC_1_PI * (a2 / (t * t))
    }

    /// `sqrt(cos^2 + alpha^2 sin^2)`: the masking function is `G1 = 2 cos / (cos + slant)`.
    #[inline(always)]
    pub fn slant(&self, cos: f32) -> f32 {
        let a2 = self.alpha * self.alpha;
        sqrt(fma((1.0 - a2) * cos, cos, a2))
    }

    /// Reflection between two directions above the surface.
    ///
    /// With `G1 = 2 cos / (cos + slant)` and `G2 = 2 cos cos' / (cos slant' + cos' slant)` the cosines below `D G2 / (4 cos)`
    /// cancel: both numbers are finite at grazing angles.
    #[inline(always)]
    pub fn reflection(&self, to_viewer: Vec3, to_light: Vec3) -> Facets {
        let sum = to_viewer + to_light;
        let h = sum.normalize_or(vec3(0.0, 0.0, 1.0));
        let normals = self.normals(h);
        let cosines = (to_viewer.z, to_light.z);
        Facets {
            // The same both ways. Between grazing directions the product with one of them has the rounding of its length.
            cos: 0.5 * sqrt(sum.length_squared()),
            value: normals * self.masking_over_cosine(cosines) * 0.25,
            pdf: normals * self.visible_over_cosine(to_viewer.z) * 0.25,
        }
    }

    /// Refraction between a direction above the surface and one below it (Walter et al. 2007); `eta` is the index beyond the
    /// surface over that on the viewer's side. A flux: without the factor `1 / eta^2` of radiance.
    #[inline(always)]
    pub fn refraction(&self, to_viewer: Vec3, to_light: Vec3, eta: f32) -> Facets {
        let sum = to_viewer.plus_scaled(to_light, eta);
        let q2 = sum.length_squared();
        let h = sum.normalize_or(Vec3::ZERO);
        let h = if h.z < 0.0 { -h } else { h };
        let (cos, cos_light) = (to_viewer.dot(h), -to_light.dot(h));
        // Microfacets that either direction meets from behind.
        if !(cos > 0.0 && cos_light > 0.0 && q2 > 0.0) {
            return Facets::NONE;
        }
        // The half vector turns by this much with the light, and its length is that of the sum.
        let normals = self.normals(h) * cos * (eta * eta * cos_light / q2);
        Facets {
            cos,
            value: normals * self.masking_over_cosine((to_viewer.z, -to_light.z)),
            pdf: normals * self.visible_over_cosine(to_viewer.z),
        }
    }

    /// `G2 / cos_viewer` of the cosines to viewer and light, both above 0.
    #[inline(always)]
    fn masking_over_cosine(&self, (cos_viewer, cos_light): (f32, f32)) -> f32 {
        2.0 * cos_light / fma(cos_viewer, self.slant(cos_light), cos_light * self.slant(cos_viewer))
    }

    /// `G1 / cos_viewer`.
    #[inline(always)]
    fn visible_over_cosine(&self, cos_viewer: f32) -> f32 {
        2.0 / (cos_viewer + self.slant(cos_viewer))
    }

    /// A microfacet normal among those that the viewer sees, as densely as they are seen; z is not negative.
    ///
    /// Dupuy and Benyoub 2023, "Sampling visible GGX normals with spherical caps": seen from a surface that is stretched to
    /// hemispheres, reflected directions are uniform in a cap of the sphere.
    #[inline(always)]
    pub fn sample_visible_normal(&self, to_viewer: Vec3, u: [f32; 2]) -> Vec3 {
        let up = vec3(0.0, 0.0, 1.0);
        let stretched =
            vec3(self.alpha * to_viewer.x, self.alpha * to_viewer.y, to_viewer.z).normalize_or(up);
        let z = fma(1.0 - u[1], 1.0 + stretched.z, -stretched.z);
        let sine = sqrt(max((1.0 - z) * (1.0 + z), 0.0));
        let (s, c) = elementary::sin_cos(core::f32::consts::TAU * u[0]);
        let h = vec3(fma(sine, c, stretched.x), fma(sine, s, stretched.y), z + stretched.z);
        vec3(self.alpha * h.x, self.alpha * h.y, max(h.z, 0.0)).normalize_or(up)
    }
}
