//! Mirror and refracted directions, and what keeps them on their side of a surface whose shading normal is not its own.

use crate::math::{Vec3, clamp, fma, max, min, sqrt};

/// The mirror image of direction `d` at a surface of unit normal `n`: `d - 2 (d.n) n`. Of the length of `d`.
#[inline(always)]
pub fn reflect(d: Vec3, n: Vec3) -> Vec3 {
    d.plus_scaled(n, -2.0 * d.dot(n))
}

/// A direction on the side of a plane that the unit vector `up` points to: mirrored at the plane where it points below.
/// Unlike a direction that is cut to the plane it depends smoothly on `d`, and the opposite of `up` becomes `up`.
#[inline(always)]
pub fn turned_up(d: Vec3, up: Vec3) -> Vec3 {
    d.plus_scaled(up, -2.0 * min(d.dot(up), 0.0))
}

/// Directions that shading normals send to the wrong side leave the surface at a slope of about as much as they came, from
/// what rounding cannot take away to what is still nearly level.
const LOWEST: f32 = 1.0 / 4096.0;
const LOW: f32 = 1.0 / 128.0;

/// The mirror image of a unit direction `d`, which meets a surface of unit normal `above` from the side that it points
/// to, at the unit shading normal `n`; and the normal that it is mirrored at.
///
/// Where `n` would mirror it to below the surface, the image is lifted to just above, the least that will do, and the
/// normal is the one that lies between (Keller et al. 2017, "The Iray light transport simulation and rendering system",
/// A.3): so Fresnel's factor and refraction agree with where the reflected ray goes.
#[inline(always)]
pub fn mirror_above(d: Vec3, n: Vec3, above: Vec3) -> (Vec3, Vec3) {
    let mirrored = reflect(d, n);
    let height = mirrored.dot(above);
    let least = clamp(-0.875 * d.dot(above), LOWEST, LOW);
    if height >= least {
        return (mirrored.normalize_or(-d), n);
    }
    let lifted = mirrored.plus_scaled(above, least - height).normalize_or(above);
    (lifted, (lifted - d).normalize_or(above))
}

/// A unit direction through a surface of unit normal `above`: mirrored at the surface where a shading normal bent it back
/// to the side that it came from.
#[inline(always)]
pub fn through_surface(direction: Vec3, above: Vec3) -> Vec3 {
    let height = direction.dot(above);
    if height < 0.0 {
        return direction;
    }
    direction.plus_scaled(above, -(height + max(height, LOWEST))).normalize_or(-above)
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
    Refracted::Through((d * eta).plus_scaled(n, fma(eta, cos_in, -cos_out)).normalize_or(d))
}
