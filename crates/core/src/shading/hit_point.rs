//! Where a hit is, to the last bit of single precision, and how far off it new rays start.
//!
//! The `t` of a hit is rounded, and a large triangle's corners are too, so `origin + direction t` lies off the surface by
//! more than its own coordinates' rounding. Double precision takes it there (Wächter and Binder 2019, "A fast and robust
//! method for avoiding self-intersection", have the offset follow from the point's own magnitude, as here). What remains is
//! rounding the point itself, which is known.

use crate::geometry::{Instance, Sphere};
use crate::intersect::T_ERROR;
use crate::intersect::precise::{
    Double3, PreciseRay, along64, cross64, dot64, double, minus64, single, sum64,
};
use crate::math::{Affine, Vec3, fma, sqrt64};
use crate::out_of_line::out_of_line;
use crate::ray::{Hit, Ray};

/// Half a unit in the last place of a number is at most this of it: 2^-24.
const ROUNDING: f32 = 1.0 / 16_777_216.0;

/// New rays start this many times what rounding can bring the hit's point off the surface: the point is rounded, then the
/// ray's origin is, and both errors together must stay below the offset.
const OFFSETS: f32 = 4.0;

/// More than double precision loses: 2^-46 of the magnitudes in it.
const PRECISE: f32 = 1.0 / (1u64 << 46) as f32;

/// Points are kept this many roundings away from the edges of their triangle: otherwise rounding would put some of them
/// beyond a neighbour that stands on the edge, and new rays would leave a closed room.
const FROM_EDGES: f32 = 8.0;

/// A hit's point.
pub(super) struct HitPoint {
    /// World space.
    pub(super) position: Vec3,
    /// What it may be off the surface by, besides the rounding of its coordinates.
    pub(super) error: f32,
}

#[inline(always)]
fn sum(v: Vec3) -> f32 {
    v.x.abs() + v.y.abs() + v.z.abs()
}

/// The instance whose space a hit is in; `None` in the world's.
#[inline(always)]
fn placed<'a>(instance: &'a Instance, hit: &Hit) -> Option<&'a Instance> {
    if hit.id.instance == 0 { None } else { Some(instance) }
}

/// The map into an instance's space; the world has none.
#[inline(always)]
fn map_of(instance: Option<&Instance>) -> Option<&Affine> {
    match instance {
        Some(instance) => Some(&instance.object_from_world),
        None => None,
    }
}

/// What magnitudes in the instance's space are in the world, with those that mapping the ray has.
#[inline(always)]
fn magnitude(ray: &Ray, instance: Option<&Instance>, local: f64) -> f32 {
    let Some(instance) = instance else { return local as f32 };
    let mapped = sum(instance.object_from_world.abs().point(ray.origin.abs()));
    instance.world_from_object.growth() * (local as f32 + mapped)
}

impl HitPoint {
    /// Of a triangle.
    #[inline(always)]
    pub(super) fn on_triangle(ray: &Ray, instance: &Instance, corners: &[Vec3; 3], hit: &Hit) -> HitPoint {
        point_on_triangle(ray, instance, corners, hit)
    }

    /// Of a triangle of the world: the bits of [`HitPoint::on_triangle`], as part of its caller.
    #[inline(always)]
    pub(super) fn on_world_triangle(ray: &Ray, corners: &[Vec3; 3], hit: &Hit) -> HitPoint {
        triangle_point(ray, None, corners, hit)
    }

    /// Of a sphere; also the vector from its centre, in its own space, any length.
    #[inline(always)]
    pub(super) fn on_sphere(ray: &Ray, instance: &Instance, sphere: &Sphere, hit: &Hit) -> (HitPoint, Vec3) {
        point_on_sphere(ray, instance, sphere, hit)
    }

    /// Of a sphere of the world: the bits of [`HitPoint::on_sphere`], as part of its caller.
    #[inline(always)]
    pub(super) fn on_world_sphere(ray: &Ray, sphere: &Sphere, hit: &Hit) -> (HitPoint, Vec3) {
        sphere_point(ray, None, sphere, hit)
    }

    /// How far off the surface, along this unit normal, new rays start.
    #[inline(always)]
    pub(super) fn offset(&self, normal: Vec3) -> f32 {
        let (n, p) = (normal.abs(), self.position.abs());
        fma(OFFSETS * ROUNDING, n.dot(p), self.error)
    }
}

out_of_line! {
    /// [`HitPoint::on_triangle`].
    fn point_on_triangle(ray: &Ray, instance: &Instance, corners: &[Vec3; 3], hit: &Hit) -> HitPoint {
        triangle_point(ray, placed(instance, hit), corners, hit)
    }
}

#[inline(always)]
fn triangle_point(ray: &Ray, instance: Option<&Instance>, corners: &[Vec3; 3], hit: &Hit) -> HitPoint {
    let local = PreciseRay::of(ray, map_of(instance));
    let world = PreciseRay::of(ray, None);
    let [a, b, c] = corners.map(double);
    let t = hit.t64();
    let near = along64(local.origin, local.direction, t);
    let normal = cross64(minus64(b, a), minus64(c, a));
    let rest = dot64(normal, minus64(a, near)) / dot64(normal, local.direction);
    // Where the ray passes an edge at a grazing angle, it may meet the plane elsewhere. NaN is no way either.
    let most = 2.0 * T_ERROR as f64 * (sum64(world.origin) / sum64(world.direction) + t.abs());
    let rest = if rest.abs() <= most { rest } else { 0.0 };
    let position = along64(along64(world.origin, world.direction, t), world.direction, rest);
    let error = PRECISE * magnitude(ray, instance, sum64(a) + sum64(b) + sum64(c));
    let inwards = inwards(instance, [a, b, c], hit, along64(near, local.direction, rest), position);
    let moved = [position[0] + inwards[0], position[1] + inwards[1], position[2] + inwards[2]];
    HitPoint { position: single(moved), error }
}

out_of_line! {
    /// [`HitPoint::on_sphere`].
    fn point_on_sphere(ray: &Ray, instance: &Instance, sphere: &Sphere, hit: &Hit) -> (HitPoint, Vec3) {
        sphere_point(ray, placed(instance, hit), sphere, hit)
    }
}

/// Free of branches where there is no instance.
#[inline(always)]
fn sphere_point(ray: &Ray, instance: Option<&Instance>, sphere: &Sphere, hit: &Hit) -> (HitPoint, Vec3) {
    let local = PreciseRay::of(ray, map_of(instance));
    let world = PreciseRay::of(ray, None);
    let t = hit.t64();
    let [first, second] = local.sphere_roots(sphere);
    let (a, b) = (first - t, second - t);
    let rest = if a.abs() <= b.abs() { a } else { b };
    // NaN is no way.
    let rest = if rest.is_nan() { 0.0 } else { rest };
    let position = along64(along64(world.origin, world.direction, t), world.direction, rest);
    let near = along64(along64(local.origin, local.direction, t), local.direction, rest);
    let center = double(sphere.center);
    let outward = minus64(near, center);
    let scale = 1.0 / sphere.radius as f64;
    let outward = single([outward[0] * scale, outward[1] * scale, outward[2] * scale]);
    let error = PRECISE * magnitude(ray, instance, sum64(center) + sphere.radius as f64);
    (HitPoint { position: single(position), error }, outward)
}

#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// From a point too close to an edge, the way to one that is not: towards the middle of the triangle. In the world.
#[inline(always)]
fn inwards(
    instance: Option<&Instance>,
    [a, b, c]: [Double3; 3],
    hit: &Hit,
    local: Double3,
    world: Double3,
) -> Double3 {
    let stretch = match map_of(instance) {
        Some(map) => map.growth() as f64,
        None => 1.0,
    };
    let distance = (FROM_EDGES * ROUNDING) as f64 * sum64(world) * stretch;
    let (e1, e2, e3) = (minus64(b, a), minus64(c, a), minus64(c, b));
    let longest = sqrt64(larger(larger(dot64(e1, e1), dot64(e2, e2)), dot64(e3, e3)));
    let normal = cross64(e1, e2);
    let height = sqrt64(dot64(normal, normal)) / longest;
    let share = distance / height;
    let (u, v) = (hit.u as f64, hit.v as f64);
    let least = smaller(smaller(1.0 - u - v, u), v);
    if !(least < share) {
        return [0.0; 3];
    }
    // A third of the height is between the middle and the edge.
    let step = if 3.0 * share < 0.25 { 3.0 * share } else { 0.25 };
    let third = 1.0 / 3.0;
    let way = [
        ((a[0] + b[0] + c[0]) * third - local[0]) * step,
        ((a[1] + b[1] + c[1]) * third - local[1]) * step,
        ((a[2] + b[2] + c[2]) * third - local[2]) * step,
    ];
    let Some(instance) = instance else { return way };
    instance.world_from_object.direction64(way)
}
