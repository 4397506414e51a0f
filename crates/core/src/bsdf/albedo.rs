//! How much rough surfaces reflect in all, from tables: single scattering on microfacets loses light that would be reflected again.

use super::schlick::schlick_weight;

/// What a white GGX mirror does with light from one direction.
#[derive(Clone, Copy, Debug)]
pub struct Albedo {
    /// The part that a single reflection does not return: one minus the albedo.
    pub lost: f32,
    /// The part of the albedo that Schlick's `(1 - cos)^5` weighs: reflectances F0 and F90 give
    /// `F0 (1 - lost - grazing) + F90 grazing`.
    pub grazing: f32,
}

/// The same for light that comes equally from all sides: means of [`Albedo`] weighted by the cosine.
#[derive(Clone, Copy, Debug)]
pub struct MeanAlbedo {
    /// Mean of [`Albedo::lost`].
    pub lost: f32,
    /// Mean of [`Albedo::grazing`].
    pub grazing: f32,
}

/// Of a white mirror of roughness `alpha`, for light at a cosine of incidence.
#[inline(always)]
pub fn white_albedo(cos: f32, _alpha: f32) -> Albedo {
    Albedo { lost: 0.0, grazing: schlick_weight(cos) }
}

/// The same for light from all sides.
#[inline(always)]
pub fn white_mean_albedo(_alpha: f32) -> MeanAlbedo {
    // The mean of (1 - cos)^5 over the hemisphere, weighted by the cosine.
    MeanAlbedo { lost: 0.0, grazing: 1.0 / 21.0 }
}

/// What rough glass reflects and transmits in all by single scattering.
#[inline(always)]
pub fn white_glass_albedo(_cos: f32, _alpha: f32, _eta: f32) -> f32 {
    1.0
}
