//! Hits in double precision, computed close to the primitive: where single precision cannot tell, and where its `t` cannot
//! order hits.

use super::PackedTriangle;
use crate::geometry::Sphere;
use crate::math::{Affine, Vec3, fma64, sqrt64, vec3};
use crate::ray::Ray;

/// A vector in double precision.
pub type Double3 = [f64; 3];

#[inline(always)]
pub(crate) fn double(v: Vec3) -> Double3 {
    [v.x as f64, v.y as f64, v.z as f64]
}

#[inline(always)]
pub(crate) fn single(v: Double3) -> Vec3 {
    vec3(v[0] as f32, v[1] as f32, v[2] as f32)
}

#[inline(always)]
pub(crate) fn dot64(a: Double3, b: Double3) -> f64 {
    fma64(a[2], b[2], fma64(a[1], b[1], a[0] * b[0]))
}

#[inline(always)]
pub(crate) fn cross64(a: Double3, b: Double3) -> Double3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
pub(crate) fn minus64(a: Double3, b: Double3) -> Double3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `o + d t`, rounded once.
#[inline(always)]
pub(crate) fn along64(o: Double3, d: Double3, t: f64) -> Double3 {
    [fma64(d[0], t, o[0]), fma64(d[1], t, o[1]), fma64(d[2], t, o[2])]
}

#[inline(always)]
pub(crate) fn sum64(v: Double3) -> f64 {
    v[0].abs() + v[1].abs() + v[2].abs()
}

/// On which side of the edge from one corner to the next a point of their plane lies: the weight of the third corner there, but
/// for a factor that all three have in common. (No closure, which may stay a function without the instructions of its caller.)
#[inline(always)]
fn weight64(from: Double3, to: Double3, point: Double3, normal: Double3) -> f64 {
    dot64(cross64(minus64(to, from), minus64(point, from)), normal)
}

/// A ray in double precision: exact in the world, mapped in double precision into other spaces.
#[derive(Clone, Copy, Debug)]
pub struct PreciseRay {
    /// Where it starts.
    pub origin: Double3,
    /// Any length but 0.
    pub direction: Double3,
}

/// A hit in double precision. `t` is where the origin was moved to and the rest of the way, added up.
#[derive(Clone, Copy, Debug)]
pub struct PreciseHit {
    /// Distance in units of the direction's length.
    pub t: f64,
    /// Weight of the second vertex.
    pub u: f64,
    /// Weight of the third vertex.
    pub v: f64,
}

/// What of a vector lies across a direction of this squared length.
#[inline(always)]
fn across(x: Double3, d: Double3, squared: f64) -> Double3 {
    along64(x, d, -(dot64(x, d) / squared))
}

/// Rays that pass an edge within this (2^-48) times the magnitudes of the test meet it: over the rounding errors, so that no
/// ray slips between neighbours.
const EDGE_TOLERANCE: f64 = 1.0 / (1u64 << 48) as f64;

/// With a determinant of at least this (2^-8) times the lengths of two edges and the direction, rounding moves `t` by less than
/// what the slab test leaves room for ([`super::EXTENT_SLACK`]).
const STEEP: f64 = 1.0 / 256.0;

/// And with at least this (2^-14) times the square of the lengths of both edges, it moves points across edges by less than that.
/// (Beside the long edges of a needle its area may be less than their rounding errors.)
const WIDE: f64 = 1.0 / 16_384.0;

/// How a ray's line passes a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Passage {
    /// The ray's own number for the point of it that is closest to the first corner, and that point.
    t_near: f64,
    near: Double3,
    /// As seen from there.
    corners: [Double3; 3],
    /// Edge functions: of the edges opposite to the corners.
    edges: [f64; 3],
    normal: Double3,
    determinant: f64,
    /// The determinant without its sign.
    size: f64,
    /// The smallest edge function.
    least: f64,
    /// Whether rounding cannot make up edge functions that say that it meets the triangle, nor move the hit.
    is_steep: bool,
}

impl Passage {
    /// Whether it meets the triangle for certain.
    #[inline(always)]
    pub fn is_within(&self) -> bool {
        self.is_steep & (self.size > 0.0) & (self.least >= 0.0)
    }

    /// Whether it passes by for certain: farther outside than the tolerance of edges, by the one on whose wrong side it passes.
    #[inline(always)]
    pub fn is_beside(&self, ray: &PreciseRay) -> bool {
        let magnitude = self.magnitude();
        self.least < -2.0 * (EDGE_TOLERANCE * magnitude) * (2.0 * magnitude) * sum64(ray.direction)
    }

    /// Of the numbers that the test adds up.
    #[inline(always)]
    fn magnitude(&self) -> f64 {
        let [a, b, c] = self.corners;
        sum64(self.near) + sum64(a) + sum64(b) + sum64(c)
    }

    /// From the closest point to where it meets the plane.
    #[inline(always)]
    fn rest(&self, inverse: f64) -> f64 {
        dot64(self.normal, self.corners[0]) * inverse
    }

    /// Where it meets the plane.
    #[inline(always)]
    pub fn hit(&self) -> PreciseHit {
        let inverse = 1.0 / self.determinant;
        let rest = self.rest(inverse);
        PreciseHit { t: self.t_near + rest, u: self.edges[1] * inverse, v: self.edges[2] * inverse }
    }

    /// Where it meets the plane, if that is a point of the triangle. For rays that almost lie in the plane: edge functions
    /// are rounding errors then, but a point of the plane tells on which side of an edge it lies.
    #[inline(always)]
    fn hit_in_plane(&self, ray: &PreciseRay) -> Option<PreciseHit> {
        let rest = self.rest(1.0 / self.determinant);
        let point = along64([0.0; 3], ray.direction, rest);
        let ([a, b, c], n) = (self.corners, self.normal);
        let weights = [weight64(b, c, point, n), weight64(c, a, point, n), weight64(a, b, point, n)];
        let total = weights[0] + weights[1] + weights[2];
        // At the tip of a sliver a point far outside has weights that are rounding errors.
        let tolerance = EDGE_TOLERANCE * self.magnitude();
        let mut is_within = (total > 0.0) & (weights[0] >= 0.0) & (weights[1] >= 0.0) & (weights[2] >= 0.0);
        let mut axis = 0;
        while axis < 3 {
            let low = a[axis].min(b[axis].min(c[axis])) - tolerance;
            let high = a[axis].max(b[axis].max(c[axis])) + tolerance;
            is_within &= (point[axis] >= low) & (point[axis] <= high);
            axis += 1;
        }
        if !is_within {
            return None;
        }
        Some(PreciseHit { t: self.t_near + rest, u: weights[1] / total, v: weights[2] / total })
    }
}

impl PreciseRay {
    /// In the world, or where the map takes it.
    #[inline(always)]
    pub fn of(ray: &Ray, object_from_world: Option<&Affine>) -> PreciseRay {
        let (origin, direction) = (double(ray.origin), double(ray.direction));
        match object_from_world {
            Some(map) => PreciseRay { origin: map.point64(origin), direction: map.direction64(direction) },
            None => PreciseRay { origin, direction },
        }
    }

    /// The ray's own number for the point of it that is closest to another, and that point.
    #[inline(always)]
    fn closest_to(&self, point: Double3) -> (f64, Double3) {
        let (o, d) = (self.origin, self.direction);
        let t = dot64(minus64(point, o), d) / dot64(d, d);
        (t, along64(o, d, t))
    }

    /// How the ray's line passes a triangle that has an area. Free of branches, so that loops over rays become SIMD code.
    #[inline(always)]
    pub fn passage(&self, triangle: &PackedTriangle) -> Passage {
        let d = self.direction;
        let (v0, v1, v2) = (double(triangle.v0), double(triangle.v1), double(triangle.v2));
        let (e1, e2) = (minus64(v1, v0), minus64(v2, v0));
        let (t_near, near) = self.closest_to(v0);
        let corners = [minus64(v0, near), minus64(v1, near), minus64(v2, near)];
        // By edges, and not by both corners, which may be far away: their products would cancel.
        let edges = [
            dot64(cross64(corners[1], minus64(v2, v1)), d),
            dot64(cross64(e2, corners[0]), d),
            dot64(cross64(corners[0], e1), d),
        ];
        let normal = cross64(e1, e2);
        let determinant = dot64(normal, d);
        let sign = if determinant < 0.0 { -1.0 } else { 1.0 };
        let least = {
            let (x, y, z) = (sign * edges[0], sign * edges[1], sign * edges[2]);
            let xy = if x < y { x } else { y };
            if xy < z { xy } else { z }
        };
        let size = sign * determinant;
        let (length1, length2) = (sum64(e1), sum64(e2));
        let lengths = length1 + length2;
        let is_steep = (size >= STEEP * (length1 * length2) * sum64(d))
            & (size >= WIDE * (lengths * lengths) * sum64(d));
        Passage { t_near, near, corners, edges, normal, determinant, size, least, is_steep }
    }

    /// Where the ray meets a triangle, before or behind its origin.
    #[inline(always)]
    pub fn meet_triangle(&self, triangle: &PackedTriangle) -> Option<PreciseHit> {
        if !(triangle.length1 >= 0.0) {
            return None;
        }
        let passage = self.passage(triangle);
        // Rays in the triangle's plane do not meet it.
        if !(passage.size > 0.0) {
            return None;
        }
        if passage.is_within() {
            return Some(passage.hit());
        }
        if passage.is_beside(self) {
            return None;
        }
        if passage.least >= 0.0
            && let Some(hit) = passage.hit_in_plane(self)
        {
            return Some(hit);
        }
        let tolerance = EDGE_TOLERANCE * passage.magnitude();
        let meets = self.meet_edges(&passage.corners, tolerance);
        meets.map(|(t, u, v)| PreciseHit { t: passage.t_near + t, u, v })
    }

    /// Where the ray passes the edge that it passes most closely, within the tolerance: `t`, `u` and `v`. Corners are as seen
    /// from a point of the ray.
    #[inline(always)]
    fn meet_edges(&self, corners: &[Double3; 3], tolerance: f64) -> Option<(f64, f64, f64)> {
        let d = self.direction;
        let squared = dot64(d, d);
        let mut best = None;
        let mut best_apart = tolerance * tolerance;
        let mut k = 0;
        while k < 3 {
            let (from, to) = (corners[k], corners[if k == 2 { 0 } else { k + 1 }]);
            let edge = minus64(to, from);
            let (a, e) = (across(from, d, squared), across(edge, d, squared));
            let share = -(dot64(a, e) / dot64(e, e));
            // NaN where the ray goes along the edge.
            let share = if share > 0.0 { if share < 1.0 { share } else { 1.0 } } else { 0.0 };
            let apart = along64(a, e, share);
            let apart = dot64(apart, apart);
            if apart <= best_apart {
                best_apart = apart;
                let t = dot64(along64(from, edge, share), d) / squared;
                best = Some(if k == 0 {
                    (t, share, 0.0)
                } else if k == 1 {
                    (t, 1.0 - share, share)
                } else {
                    (t, 0.0, 1.0 - share)
                });
            }
            k += 1;
        }
        best
    }

    /// The `t`s, nearer first, at which the ray's line passes through a sphere's surface.
    #[inline(always)]
    pub fn meet_sphere(&self, sphere: &Sphere) -> Option<[f64; 2]> {
        let roots = self.sphere_roots(sphere);
        if roots[0].is_nan() { None } else { Some(roots) }
    }

    /// The same; NaN where it does not. Free of branches, so that loops over rays become SIMD code.
    #[inline(always)]
    pub fn sphere_roots(&self, sphere: &Sphere) -> [f64; 2] {
        let d = self.direction;
        let center = double(sphere.center);
        let (t_near, near) = self.closest_to(center);
        let squared = dot64(d, d);
        // What rounding has left of the way to the closest point.
        let off = minus64(near, center);
        let rest = -(dot64(off, d) / squared);
        let off = along64(off, d, rest);
        let radius = sphere.radius as f64;
        let discriminant = radius * radius - dot64(off, off);
        // The root of what is below 0 is NaN.
        let half = sqrt64(discriminant / squared);
        let t = t_near + rest;
        [t - half, t + half]
    }
}
