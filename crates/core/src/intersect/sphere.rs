//! The one sphere test.

use super::{LocalRay, Slab};
use crate::geometry::{Bounds, Sphere};
use crate::math::{Affine, Vec3, sqrt};
use crate::ray::Ray;

/// The sphere's bounds, grown by `padding`.
#[inline(always)]
pub fn sphere_bounds(sphere: &Sphere, padding: f32) -> Bounds {
    let r = Vec3::splat(sphere.radius);
    Bounds { min: sphere.center - r, max: sphere.center + r }.padded(padding)
}

/// The `t`s, nearer first, at which the ray passes through the sphere's surface; NaN where it does not or where a
/// crossing is not a hit. The nearer one comes first; a ray that starts inside has only the second.
///
/// The discriminant is taken from the point of the ray closest to the centre, where it does not cancel (Haines et al.,
/// "Precision improvements for ray/sphere intersection", Ray Tracing Gems 2019).
#[inline(always)]
pub fn intersect_sphere(ray: &LocalRay, sphere: &Sphere) -> [f32; 2] {
    let d = ray.direction;
    let from_center = ray.origin - sphere.center;
    let t_closest = -(from_center.dot(d) * ray.inverse_direction_squared);
    let closest = from_center.along(d, t_closest);
    let discriminant = sphere.radius * sphere.radius - closest.length_squared();
    if (discriminant < 0.0) | discriminant.is_nan() {
        return [f32::NAN; 2];
    }
    let half = sqrt(discriminant * ray.inverse_direction_squared);
    let (near, far) = ray.slab.interval(&sphere_bounds(sphere, ray.padding), ray.t_min);
    let checked = |t: f32, step: f32| {
        let off = closest.along(d, step).length() - sphere.radius;
        let counts = (t > ray.t_min)
            & (t < f32::INFINITY)
            & (off.abs() <= ray.hit_tolerance)
            & Slab::passes(near, far, t);
        if counts { t } else { f32::NAN }
    };
    [checked(t_closest - half, -half), checked(t_closest + half, half)]
}

/// The same by a ray that is this one in the world; like [`super::decide_triangle`], a function of its own on GPUs.
#[cfg_attr(target_arch = "nvptx64", inline(never), unsafe(no_mangle))]
#[cfg_attr(not(target_arch = "nvptx64"), inline(always))]
pub(crate) fn decide_sphere(
    sphere: &Sphere,
    ray: &Ray,
    object_from_world: Option<&Affine>,
    extent: f32,
) -> [f32; 2] {
    intersect_sphere(&LocalRay::of(ray, object_from_world, extent), sphere)
}
