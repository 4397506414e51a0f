//! Points on lights.

use crate::light::Light;
use crate::math::{Vec3, max, sqrt};

/// A sampled point of a light, seen from a surface point.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit vector from the surface point to the light.
    pub to_light: Vec3,
    /// Distance of the light; infinite for directional ones.
    pub distance: f32,
    /// What reaches the point, as a share of [`emitted`].
    pub weight: f32,
}

/// What a light sends: the colour that sample weights multiply.
#[inline(always)]
pub fn emitted(light: &Light) -> Vec3 {
    match *light {
        Light::Point { color, .. }
        | Light::Directional { color, .. }
        | Light::Spot { color, .. }
        | Light::Triangle { color, .. } => color,
    }
}

/// A light without size as `from` sees it. Point and spot lights fall off with `1 / d^2` where `falloff`. (Light
/// triangles have [`triangle_sample`]; here they give nothing.)
#[inline(always)]
pub fn sample_light(light: &Light, from: Vec3, falloff: bool) -> LightSample {
    match *light {
        Light::Point { position, .. } => towards(position - from, 1.0, falloff),
        Light::Directional { to_light, .. } => LightSample { to_light, distance: f32::INFINITY, weight: 1.0 },
        Light::Spot { position, axis, cos_inner, cos_outer, .. } => {
            let sample = towards(position - from, 1.0, falloff);
            let cos = -axis.dot(sample.to_light);
            let cone = if cos >= cos_inner {
                1.0
            } else if cos <= cos_outer {
                0.0
            } else {
                let x = (cos - cos_outer) / (cos_inner - cos_outer);
                x * x * (3.0 - 2.0 * x)
            };
            LightSample { weight: sample.weight * cone, ..sample }
        }
        Light::Triangle { .. } => LightSample { to_light: Vec3::ZERO, distance: 0.0, weight: 0.0 },
    }
}

/// A point of a light triangle, `offset` away from the surface point: the weight of each of N samples is
/// `S max(0, N_l.(-L)) / (N d^2)` with `power` = S / N.
#[inline(always)]
pub fn triangle_sample(offset: Vec3, light_normal: Vec3, power: f32) -> LightSample {
    let sample = towards(offset, power, true);
    LightSample { weight: sample.weight * max(-light_normal.dot(sample.to_light), 0.0), ..sample }
}

#[inline(always)]
fn towards(offset: Vec3, power: f32, falloff: bool) -> LightSample {
    let squared = offset.length_squared();
    let distance = sqrt(squared);
    let inverse = 1.0 / distance;
    // On the light itself there is no direction: it gives nothing.
    let reachable = (squared > f32::MIN_POSITIVE) & (squared < f32::INFINITY);
    let strength = if falloff { power * (inverse * inverse) } else { power };
    LightSample { to_light: offset * inverse, distance, weight: if reachable { strength } else { 0.0 } }
}
