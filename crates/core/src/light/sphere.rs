//! Spheres that shine: directions to them, evenly spread over the angle that they fill.

use super::sample::LightSample;
use crate::intersect::precise::{dot64, double, minus64};
use crate::math::{Vec3, fma, max, sqrt, sqrt64, vec3};
use crate::sampling::orthonormal_basis;

/// How far out of a sphere a point must be, of coordinates and radius: some offsets of ray origins. Samples are asked for where
/// rays start, densities at the surface; nearer than that, rounding would have them disagree on who is within.
const MARGIN: f32 = 1.0 / (1 << 18) as f32;

/// 1 less the cosine of half the angle that a sphere fills; its solid angle over 2 pi. None from within, and from its surface.
#[inline(always)]
fn cone(from: Vec3, center: Vec3, radius: f32) -> Option<f32> {
    let offset = center - from;
    let (squared, radius_squared) = (offset.length_squared(), radius * radius);
    let (from, to) = (from.abs(), center.abs());
    let least = fma(MARGIN, from.x + from.y + from.z + (to.x + to.y + to.z) + radius, radius);
    if !(squared > least * least) | !(squared < f32::INFINITY) {
        return None;
    }
    let sine_squared = radius_squared / squared;
    // 1 - cos, without the difference.
    let rest = sine_squared / (1.0 + sqrt(max(1.0 - sine_squared, 0.0)));
    if rest > 0.0 { Some(rest) } else { None }
}

/// A direction to the sphere for a point of the unit square; the weight is the solid angle.
#[inline(always)]
pub(super) fn sample(from: Vec3, center: Vec3, radius: f32, u: [f32; 2]) -> LightSample {
    let nothing = LightSample { to_light: vec3(0.0, 0.0, 1.0), distance: 0.0, weight: 0.0 };
    let Some(rest) = cone(from, center, radius) else { return nothing };
    // Concentric, so that neighbours stay neighbours; its radius squared is even over the angle.
    let disk = crate::sampling::disk_point(u);
    let share = fma(disk[0], disk[0], disk[1] * disk[1]);
    let height = share * rest;
    // The sine of the angle from the axis over the radius in the disk.
    let across = sqrt(max(rest * (2.0 - height), 0.0));
    let axis = (center - from).normalize();
    let (x, y) = orthonormal_basis(axis);
    let direction = (axis * (1.0 - height)).plus_scaled(x, across * disk[0]).plus_scaled(y, across * disk[1]);
    let to_light = direction.normalize_or(axis);
    let distance = end(from, to_light, center, radius);
    LightSample { to_light, distance, weight: 2.0 * core::f32::consts::PI * rest }
}

/// How densely [`sample`] gives a direction that meets the sphere, per steradian; 0 from within.
#[inline(always)]
pub(super) fn density(from: Vec3, center: Vec3, radius: f32) -> f32 {
    match cone(from, center, radius) {
        Some(rest) => 1.0 / (2.0 * core::f32::consts::PI * rest),
        None => 0.0,
    }
}

/// Where a ray to the sphere ends: the last number before it meets it, so that it does not hide itself.
#[inline(always)]
fn end(origin: Vec3, direction: Vec3, center: Vec3, radius: f32) -> f32 {
    let (way, d, radius) = (minus64(double(center), double(origin)), double(direction), radius as f64);
    let (along, length) = (dot64(way, d), dot64(d, d));
    // The closest point to the center is as far from the surface as a half chord.
    let closest = along / length;
    let beside = [way[0] - d[0] * closest, way[1] - d[1] * closest, way[2] - d[2] * closest];
    let chord = radius * radius - dot64(beside, beside);
    let half = if chord > 0.0 { sqrt64(chord / length) } else { 0.0 };
    let t = (closest - half) as f32;
    fma(t, -1.0 / 8_388_608.0, t)
}
