//! Mirror and refracted directions.

use crate::math::{Vec3, fma, sqrt};

/// The mirror image of direction `d` at a surface of unit normal `n`: `d - 2 (d.n) n`. Of the length of `d`.
#[inline(always)]
pub fn reflect(d: Vec3, n: Vec3) -> Vec3 {
    d.along(n, -2.0 * d.dot(n))
}

/// Where a ray goes on that is bent at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refracted {
    /// Through, along this unit vector.
    Through(Vec3),
    /// Nowhere: the angle is beyond the critical one.
    TotalReflection,
}

/// Snell's law for a unit direction `d` that meets a surface of unit normal `n` from the side that `n` points to;
/// `eta` is the index on that side over the index beyond.
#[inline(always)]
pub fn refract(d: Vec3, n: Vec3, eta: f32) -> Refracted {
    let cos_in = -d.dot(n);
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in);
    if sin2_out >= 1.0 {
        return Refracted::TotalReflection;
    }
    let cos_out = sqrt(1.0 - sin2_out);
    Refracted::Through((d * eta).along(n, fma(eta, cos_in, -cos_out)).normalize_or(d))
}
