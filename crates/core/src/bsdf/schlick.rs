//! Schlick's reflectance (1994) with its own value at grazing angles, as glTF's materials have it, and what a rough layer of it
//! reflects in all.

use super::albedo::{Albedo, MeanAlbedo};
use crate::math::{Vec3, max};

/// A reflecting layer that covers a share of a surface. Both reflectances are already multiplied by the share.
#[derive(Clone, Copy, Debug)]
pub struct Schlick {
    /// Reflectance at normal incidence.
    pub f0: Vec3,
    /// Reflectance at grazing incidence.
    pub f90: Vec3,
    /// The share, 0 to 1.
    pub share: f32,
}

/// `(1 - cos)^5`.
#[inline(always)]
pub fn schlick_weight(cos: f32) -> f32 {
    let m = max(1.0 - cos, 0.0);
    let m2 = m * m;
    m2 * m2 * m
}

impl Schlick {
    /// Reflectance at a cosine of incidence.
    #[inline(always)]
    pub fn at(&self, cos: f32) -> Vec3 {
        self.blend(1.0, schlick_weight(cos))
    }

    /// `f0 * (all - grazing) + f90 * grazing`.
    #[inline(always)]
    fn blend(&self, all: f32, grazing: f32) -> Vec3 {
        (self.f0 * (all - grazing)).plus_scaled(self.f90, grazing)
    }

    /// Reflectance of light that leaves after more than one reflection, over that of a white surface.
    ///
    /// Kulla and Conty 2017, "Revisiting physically based shading at Imageworks", with the second factor of the mean that Hill
    /// added ("A multi-faceted exploration", 2018): light that was reflected once is not part of it.
    #[inline(always)]
    pub fn multiple(&self, mean: MeanAlbedo) -> Vec3 {
        // The mean of (1 - cos)^5 over the hemisphere, weighted by the cosine, is 1/21.
        let once = self.blend(1.0, 1.0 / 21.0);
        let part = |once: f32| once * once * (1.0 - mean.lost) / max(self.share - once * mean.lost, LEAST);
        Vec3 { x: part(once.x), y: part(once.y), z: part(once.z) }
    }

    /// What the layer reflects in all of light from one direction; `multiple` is [`Schlick::multiple`].
    #[inline(always)]
    pub fn albedo(&self, albedo: Albedo, multiple: Vec3) -> Vec3 {
        self.blend(1.0 - albedo.lost, albedo.grazing).plus_scaled(multiple, albedo.lost)
    }

    /// What it reflects of light that comes equally from all sides.
    #[inline(always)]
    pub fn mean_albedo(&self, mean: MeanAlbedo, multiple: Vec3) -> Vec3 {
        self.albedo(Albedo { lost: mean.lost, grazing: mean.grazing }, multiple)
    }
}

/// Keeps the share of a layer that is not there out of denominators.
const LEAST: f32 = 1e-6;
