//! How much a surface reflects.

use crate::math::{clamp, sqrt};
use crate::settings::FresnelMode;

/// Reflectance of unpolarised light at a dielectric (Fresnel). `cos_in` in 0..=1 on the side the light comes from;
/// `eta` is the index on that side over the index beyond. 1 at total internal reflection.
#[inline(always)]
pub fn fresnel_exact(cos_in: f32, eta: f32) -> f32 {
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in);
    if sin2_out >= 1.0 {
        return 1.0;
    }
    let cos_out = sqrt(1.0 - sin2_out);
    let perpendicular = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    let parallel = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    clamp(0.5 * (perpendicular * perpendicular + parallel * parallel), 0.0, 1.0)
}

/// Schlick's approximation (1994). Towards the thinner medium it takes the cosine beyond the surface, so that it
/// reaches 1 at the critical angle.
#[inline(always)]
pub fn fresnel_schlick(cos_in: f32, eta: f32) -> f32 {
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in);
    if sin2_out >= 1.0 {
        return 1.0;
    }
    let cos = if eta > 1.0 { sqrt(1.0 - sin2_out) } else { cos_in };
    let f0 = reflectance_at_normal_incidence(eta);
    let m = 1.0 - cos;
    let m2 = m * m;
    f0 + (1.0 - f0) * (m2 * m2 * m)
}

/// `((eta - 1) / (eta + 1))^2`.
#[inline(always)]
pub fn reflectance_at_normal_incidence(eta: f32) -> f32 {
    let r = (eta - 1.0) / (eta + 1.0);
    r * r
}

/// The factor by the chosen mode; 1 at total internal reflection in every mode.
#[inline(always)]
pub fn fresnel_factor(mode: FresnelMode, cos_in: f32, eta: f32) -> f32 {
    match mode {
        FresnelMode::Exact => fresnel_exact(cos_in, eta),
        FresnelMode::Schlick => fresnel_schlick(cos_in, eta),
        FresnelMode::Constant => {
            if eta * eta * (1.0 - cos_in * cos_in) >= 1.0 {
                1.0
            } else {
                reflectance_at_normal_incidence(eta)
            }
        }
    }
}
