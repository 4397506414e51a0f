//! The one sphere test: a quick look in single precision; `precise.rs` finds the roots in double.

use super::precise::PreciseRay;
use super::{EDGE_SLACK, LocalRay};
use crate::geometry::{Bounds, Sphere};
use crate::math::{Affine, Vec3, fma};
use crate::out_of_line::out_of_line;
use crate::ray::Ray;

/// The sphere's bounds, grown as boxes have to be ([`Bounds::with_slack`]).
#[inline(always)]
pub fn sphere_bounds(sphere: &Sphere) -> Bounds {
    let r = Vec3::splat(sphere.radius);
    Bounds { min: sphere.center - r, max: sphere.center + r }.with_slack()
}

/// Where a ray passes through a sphere's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereHit {
    /// Rounded; NaN where there is no hit.
    pub t: f32,
    /// What rounding took away.
    pub t_rest: f32,
}

impl SphereHit {
    /// No hit.
    pub const NONE: SphereHit = SphereHit { t: f32::NAN, t_rest: 0.0 };

    /// At a root, between the ray's ends.
    #[inline(always)]
    pub fn at(root: f64, ray: &Ray) -> SphereHit {
        let t = root as f32;
        if (t > ray.t_min) & (t <= ray.t_max) & (t < f32::INFINITY) {
            SphereHit { t, t_rest: (root - t as f64) as f32 }
        } else {
            SphereHit::NONE
        }
    }
}

/// Whether a ray may meet a sphere, in single precision.
#[inline(always)]
pub fn may_meet_sphere(ray: &LocalRay, sphere: &Sphere) -> bool {
    let to_center = sphere.center - ray.origin;
    let c = to_center.abs();
    let distance = (c.x + c.y) + (c.z + ray.reach);
    let across = to_center.cross(ray.direction).length();
    let slack = (EDGE_SLACK * ray.length) * distance;
    // NaN says nothing, but for the start: nothing is hit then.
    !(across > fma(sphere.radius, ray.length, slack)) & !ray.t_min.is_nan()
}

out_of_line! {
    /// Where a ray of the world passes through the surface of a sphere of a space into which the map takes it, between its
    /// ends, nearer first. A ray that starts inside has only the second.
    pub fn intersect_sphere(
        sphere: &Sphere,
        ray: &Ray,
        object_from_world: Option<&Affine>,
    ) -> [SphereHit; 2] {
        let mut hits = [SphereHit::NONE; 2];
        if let Some([first, second]) = PreciseRay::of(ray, object_from_world).meet_sphere(sphere) {
            hits = [SphereHit::at(first, ray), SphereHit::at(second, ray)];
        }
        hits
    }
}
