//! How a surface point scatters light in path tracing: a matte base under a reflecting layer, metal, and glass, mixed by shares.
//!
//! Directions are unit vectors in the frame of the point that point away from it: z is the shading normal on the viewer's side.
//! Nothing is lost but what colours take: white metal, white layers over white bases and clear glass return all light.

use super::fresnel_exact;
use super::mixture::Mixture;
use super::schlick::Schlick;
use crate::math::{Vec3, max};

/// Below this roughness reflecting lobes are single directions.
pub const SMOOTH: f32 = 1e-3;
/// Indices of refraction that differ by less make no surface. Half vectors of refraction lose their digits near there.
const SAME_INDEX: f32 = 1.0 / 1024.0;

/// How a surface point scatters light. The shares of base and layer, metal and glass add up to at most one: base and layer
/// cover what `metal` and `glass` leave.
#[derive(Clone, Copy, Debug)]
pub struct Closure {
    /// Albedo of the matte base, before the layer above it takes its part; already multiplied by the base's share.
    pub diffuse: Vec3,
    /// Roughness of the base, 0 to 1: [`Eon`](super::Eon); with 0 it is Lambert's.
    pub diffuse_roughness: f32,
    /// Reflectance at normal incidence of the layer over the base; already multiplied by the base's share.
    pub f0: Vec3,
    /// The same at grazing incidence; not below `f0`.
    pub f90: Vec3,
    /// Reflectance of metal at normal incidence times its share. At grazing incidence it is the share.
    pub metal_f0: Vec3,
    /// Share of the surface that is metal.
    pub metal: f32,
    /// Share of the surface that is glass: a clear dielectric.
    pub glass: f32,
    /// What transmitted light is multiplied by.
    pub glass_tint: Vec3,
    /// Index of refraction beyond the surface over that on the viewer's side; of thin glass, over that around it.
    pub eta: f32,
    /// The glass is a thin pane: light goes on in the direction it came in, spread by roughness; else it is refracted.
    pub is_thin: bool,
    /// GGX roughness of all reflecting lobes and of glass; below [`SMOOTH`] they are single directions.
    pub alpha: f32,
}

/// Light scattered from one direction into another, by all lobes but those of a single direction.
#[derive(Clone, Copy, Debug)]
pub struct Scattered {
    /// The scattering function times the cosine to the light, per steradian.
    pub value: Vec3,
    /// Density of [`Mixture::sample`] at the direction, per steradian, with its choice of a lobe.
    pub pdf: f32,
}

impl Scattered {
    /// Nothing.
    pub const NOTHING: Scattered = Scattered { value: Vec3::ZERO, pdf: 0.0 };
}

/// A direction in which a path goes on.
#[derive(Clone, Copy, Debug)]
pub struct ScatterSample {
    /// Unit vector; below the surface where it is transmitted.
    pub to_light: Vec3,
    /// What light from there is multiplied by: the value of all lobes over the density of all of them.
    pub weight: Vec3,
    /// The density, per steradian; 0 for a single direction.
    pub pdf: f32,
    /// The direction is a single one, which light sampling cannot find.
    pub is_delta: bool,
    /// It goes through the surface.
    pub is_transmitted: bool,
    /// It goes on exactly as it came: shadow rays see through the surface there ([`Closure::straight`]).
    pub is_straight: bool,
}

impl Closure {
    /// The lobes towards a viewer, whose z is above 0.
    #[inline(always)]
    pub fn towards(&self, to_viewer: Vec3) -> Mixture {
        Mixture::new(self, to_viewer)
    }

    /// Share of light that goes straight on through thin smooth glass at a cosine of incidence.
    #[inline(always)]
    pub fn straight(&self, cos: f32) -> Vec3 {
        if self.is_straight() { self.through(cos) } else { Vec3::ZERO }
    }

    /// Whether the base is all there is.
    #[inline(always)]
    pub(super) fn is_matte(&self) -> bool {
        !((self.f90.max_component() > 0.0) | (self.metal > 0.0) | (self.glass > 0.0))
    }

    /// Whether reflecting lobes are single directions.
    #[inline(always)]
    pub(super) fn is_smooth(&self) -> bool {
        self.alpha < SMOOTH
    }

    /// Whether the glass neither bends nor reflects.
    #[inline(always)]
    pub(super) fn is_clear(&self) -> bool {
        (self.eta - 1.0).abs() < SAME_INDEX
    }

    /// Whether light through the glass goes in a single direction.
    #[inline(always)]
    pub(super) fn is_glass_smooth(&self) -> bool {
        self.is_smooth() || self.is_clear()
    }

    /// Whether that is the direction in which it came, and the other side of the glass is as near: shadow rays see through.
    #[inline(always)]
    pub(super) fn is_straight(&self) -> bool {
        self.is_thin && self.is_glass_smooth()
    }

    /// What smooth glass transmits at a cosine of incidence, its share included.
    #[inline(always)]
    pub(super) fn through(&self, cos: f32) -> Vec3 {
        self.glass_tint * (self.glass * (1.0 - self.glass_reflectance(cos)))
    }

    /// Reflectance of glass at a cosine of incidence: of one surface, or of a pane with the light that goes to and fro in it.
    #[inline(always)]
    pub(super) fn glass_reflectance(&self, cos: f32) -> f32 {
        if self.is_clear() {
            return 0.0;
        }
        if self.is_thin {
            // The denser index is within. R + T R T + T R R R T + ... = 2 R / (1 + R).
            let r = fresnel_exact(cos, if self.eta > 1.0 { 1.0 / self.eta } else { self.eta });
            return 2.0 * r / (1.0 + r);
        }
        fresnel_exact(cos, 1.0 / self.eta)
    }

    /// The layer over the base.
    #[inline(always)]
    pub(super) fn layer(&self) -> Schlick {
        Schlick { f0: self.f0, f90: self.f90, share: max(1.0 - self.metal - self.glass, 0.0) }
    }

    /// The metal.
    #[inline(always)]
    pub(super) fn metal_layer(&self) -> Schlick {
        Schlick { f0: self.metal_f0, f90: Vec3::splat(self.metal), share: self.metal }
    }
}

#[cfg(test)]
mod tests;
