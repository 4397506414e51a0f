//! Highlights, and the density of glossy rays.

use crate::math::elementary::pow;
use crate::math::{Vec3, max};
use crate::settings::LightingModel;

/// The highlight's factor for unit vectors `n` (normal), `v` (to the viewer) and `l` (to the light):
/// Phong `max(0, V.R)^Ns`, Blinn-Phong `max(0, N.H)^Ns`, else 0.
#[inline(always)]
pub fn specular_lobe(model: LightingModel, n: Vec3, v: Vec3, l: Vec3, exponent: f32) -> f32 {
    match model {
        LightingModel::Phong => {
            let mirrored = (-l).plus_scaled(n, 2.0 * n.dot(l));
            pow(max(mirrored.dot(v), 0.0), exponent)
        }
        LightingModel::BlinnPhong => {
            let half = (l + v).normalize_or(Vec3::ZERO);
            pow(max(n.dot(half), 0.0), exponent)
        }
        LightingModel::Distance | LightingModel::Diffuse | LightingModel::Lambert => 0.0,
    }
}

/// The density of `cos^exponent` about a unit axis in a unit direction: `(n + 1) / (2 pi) cos^n`, per steradian.
#[inline(always)]
pub fn lobe_density(axis: Vec3, direction: Vec3, exponent: f32) -> f32 {
    const OVER_HEMISPHERE: f32 = 0.5 * core::f32::consts::FRAC_1_PI;
    (exponent + 1.0) * OVER_HEMISPHERE * pow(max(axis.dot(direction), 0.0), exponent)
}
