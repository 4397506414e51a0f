//! The one triangle test.
//!
//! Candidates are found by Möller and Trumbore's formula (1997), arranged around R = C × D as in Embree, with edges
//! moved out by the rounding error. A candidate is then computed again from a point close to the triangle, where
//! coordinates are small and so are errors; that gives t, u and v. Where a ray passes an edge within the rounding error,
//! grazes the triangle, or does not meet the point that u and v name, double precision decides, so that no ray slips
//! between neighbours and none hits what it passes. The second step runs once or twice a ray, double precision for some
//! rays in a thousand, so they cost next to nothing.
//!
//! Whatever counts as a hit is a point of the triangle, its rounding aside, and the ray passes that point within
//! the tolerance. So it passes the padded bounds of the triangle, and of any part of it that holds the point.

use super::{LocalRay, SMALLEST_DETERMINANT, Slab};
use crate::geometry::Bounds;
use crate::math::{Affine, Vec3, fma, sqrt, sqrt64};
use crate::ray::Ray;

/// Triangles whose edges meet at an angle with a sine below this have no area that single precision can tell.
const NO_AREA: f32 = 1.0 / 4_194_304.0;

/// A triangle as the test reads it: 48 bytes, three 16-byte loads.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub struct PackedTriangle {
    /// First vertex.
    pub v0: Vec3,
    /// Length of `e1`.
    pub length1: f32,
    /// Second vertex minus the first.
    pub e1: Vec3,
    /// Length of `e2`.
    pub length2: f32,
    /// Third vertex minus the first.
    pub e2: Vec3,
    /// Its number in its geometry.
    pub primitive: u32,
}

impl PackedTriangle {
    /// From three vertices, best in the order of [`longest_edge_last`].
    #[inline(always)]
    pub fn new(vertices: [Vec3; 3], primitive: u32) -> PackedTriangle {
        let (e1, e2) = (vertices[1] - vertices[0], vertices[2] - vertices[0]);
        let length = |e: Vec3| sqrt(e.length_squared());
        let (length1, length2) = (length(e1), length(e2));
        let v0 = vertices[0];
        // Corners on one line have a normal that is nothing but rounding error. Without edges they are never hit.
        let sine = (e1 * (1.0 / length1)).cross(e2 * (1.0 / length2)).length();
        // An edge without length makes it NaN.
        if sine.is_nan() | (sine <= NO_AREA) {
            // With lengths below 0, not even a ray with edge functions of 0 is inside.
            let none = Vec3::ZERO;
            return PackedTriangle { v0, length1: -1.0, e1: none, length2: -1.0, e2: none, primitive };
        }
        PackedTriangle { v0, length1, e1, length2, e2, primitive }
    }

    /// Its bounds, grown by `padding`. Every hierarchy and the test itself use this one function.
    #[inline(always)]
    pub fn bounds(&self, padding: f32) -> Bounds {
        let (v1, v2) = (self.v0 + self.e1, self.v0 + self.e2);
        Bounds { min: self.v0.min(v1.min(v2)), max: self.v0.max(v1.max(v2)) }.padded(padding)
    }
}

/// How far to rotate the vertices so that the edge between second and third is the longest: vertex `(k + i) % 3` comes
/// to place `i`. The third edge function is a difference of the other two and has their errors; next to the longest
/// edge they are smallest, so that slivers do not grow.
pub fn longest_edge_last(vertices: &[Vec3; 3]) -> usize {
    let squared = |a: usize, b: usize| (vertices[a] - vertices[b]).length_squared();
    let (opposite0, opposite1, opposite2) = (squared(1, 2), squared(2, 0), squared(0, 1));
    if opposite0 >= opposite1 && opposite0 >= opposite2 {
        0
    } else if opposite1 >= opposite2 {
        1
    } else {
        2
    }
}

/// What the first step finds out about a ray and a triangle.
#[derive(Clone, Copy, Debug)]
pub struct EdgeTest {
    /// The ray passes within the (widened) edges, on a side that is not culled.
    pub candidate: bool,
    /// So far within the edges that rounding cannot have brought it there, and steep enough for single precision.
    pub clear: bool,
    /// Direction dot normal: negative where the ray meets the front.
    pub determinant: f32,
}

/// By how much rounding `e1` and `e2` to single precision can move a corner, over their lengths together.
const EDGE_ROUNDING: f64 = 1.0 / 16_777_216.0;

#[inline(always)]
fn double(v: Vec3) -> [f64; 3] {
    [v.x as f64, v.y as f64, v.z as f64]
}

#[inline(always)]
fn dot64(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross64(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// What the second step says.
#[derive(Clone, Copy, Debug)]
pub struct Confirmed {
    /// Ray and triangle meet there, within the tolerance. In single precision, `false` says that it cannot tell.
    pub meets: bool,
    /// Distance in units of the direction's length.
    pub t: f32,
    /// The same in a first approximation, for those who cannot wait.
    pub t_near: f32,
    /// Weight of the second vertex.
    pub u: f32,
    /// Weight of the third vertex.
    pub v: f32,
}

/// `(t, u, v)` where the ray meets the triangle beyond `t_min`, or `None`.
#[inline(always)]
pub fn intersect_triangle(
    ray: &LocalRay,
    triangle: &PackedTriangle,
    cull_back_faces: bool,
) -> Option<(f32, f32, f32)> {
    intersect_triangle_unless(ray, triangle, cull_back_faces, || false)
}

/// The same, but what `skips` says true of is not there. It is asked of candidates only, before they are confirmed.
#[inline(always)]
pub(crate) fn intersect_triangle_unless(
    ray: &LocalRay,
    triangle: &PackedTriangle,
    cull_back_faces: bool,
    skips: impl FnOnce() -> bool,
) -> Option<(f32, f32, f32)> {
    let normal = triangle.normal();
    let edges = triangle.test_edges(ray, normal, cull_back_faces);
    if !edges.candidate || skips() {
        return None;
    }
    let hit = triangle.decide(ray, normal, &edges);
    if hit.counts(ray) { Some((hit.t, hit.u, hit.v)) } else { None }
}

/// [`PackedTriangle::test`] by a ray that is this one in the world. What it takes is what searches have anyway, so that
/// they need not keep what only this needs; on GPUs it is a function of its own, so that its registers are not theirs.
#[cfg_attr(target_arch = "nvptx64", inline(never), unsafe(no_mangle))]
#[cfg_attr(not(target_arch = "nvptx64"), inline(always))]
pub(crate) fn decide_triangle(
    triangle: &PackedTriangle,
    ray: &Ray,
    object_from_world: Option<&Affine>,
    extent: f32,
) -> Confirmed {
    let local = LocalRay::of(ray, object_from_world, extent);
    let hit = triangle.test(&local, false);
    Confirmed { meets: hit.counts(&local), ..hit }
}

impl Confirmed {
    /// They do not meet.
    const NOWHERE: Confirmed = Confirmed { meets: false, t: 0.0, t_near: 0.0, u: 0.0, v: 0.0 };

    /// Whether it is a hit of the ray.
    #[inline(always)]
    pub fn counts(&self, ray: &LocalRay) -> bool {
        // Comparisons are written so that NaN fails them.
        self.meets & (self.t > ray.t_min) & (self.t < f32::INFINITY)
    }
}

impl PackedTriangle {
    /// Not of unit length; on the side from which the vertices run counter-clockwise.
    #[inline(always)]
    pub fn normal(&self) -> Vec3 {
        self.e1.cross(self.e2)
    }

    /// The first step. Free of branches, so that loops over rays become SIMD code.
    #[inline(always)]
    pub fn test_edges(&self, ray: &LocalRay, normal: Vec3, cull_back_faces: bool) -> EdgeTest {
        let r = (self.v0 - ray.origin).cross(ray.direction);
        let determinant = normal.dot(ray.direction);
        // Signs of the edge functions are those of the determinant for a ray that passes inside.
        let sign = determinant.to_bits() & 0x8000_0000;
        let signed = |x: f32| f32::from_bits(x.to_bits() ^ sign);
        let u = signed(r.dot(self.e2));
        let v = signed(-r.dot(self.e1));
        let (slack1, slack2) = (ray.edge_tolerance * self.length1, ray.edge_tolerance * self.length2);
        let w = determinant.abs() - u - v;
        let slack3 = slack1 + slack2;
        let inside = (u >= -slack2) & (v >= -slack1) & (w >= -slack3);
        let steep = determinant.abs() >= fma(ray.steep, self.length1 * self.length2, SMALLEST_DETERMINANT);
        let clear = (u >= slack2) & (v >= slack1) & (w >= slack3) & steep;
        // The front is where vertices run counter-clockwise: there the ray goes against the normal.
        let culled = cull_back_faces & (sign == 0);
        EdgeTest { candidate: inside & !culled, clear, determinant }
    }

    /// Both steps.
    #[inline(always)]
    pub fn test(&self, ray: &LocalRay, cull_back_faces: bool) -> Confirmed {
        let normal = self.normal();
        let edges = self.test_edges(ray, normal, cull_back_faces);
        if edges.candidate { self.decide(ray, normal, &edges) } else { Confirmed::NOWHERE }
    }

    /// The second step for a candidate.
    #[inline(always)]
    fn decide(&self, ray: &LocalRay, normal: Vec3, edges: &EdgeTest) -> Confirmed {
        let hit = self.confirm(ray, normal, edges.determinant);
        let hit = if edges.clear & hit.meets { hit } else { self.confirm_in_double(ray) };
        debug_assert!(!hit.counts(ray) | self.passes_bounds(ray, hit.t), "{self:?} {ray:?} {hit:?}");
        hit
    }

    /// The second step in single precision: t by Newton's method, u and v from a point near the triangle. They hold if the first step was
    /// clear and they meet.
    #[inline(always)]
    pub fn confirm(&self, ray: &LocalRay, normal: Vec3, determinant: f32) -> Confirmed {
        let d = ray.direction;
        let inverse = 1.0 / determinant;
        let t_near = normal.dot(self.v0 - ray.origin) * inverse;
        let from_near = self.v0 - ray.origin.along(d, t_near);
        let t_rest = normal.dot(from_near) * inverse;
        let r = from_near.cross(d);
        let (u, v) = (r.dot(self.e2) * inverse, -r.dot(self.e1) * inverse);
        let apart = from_near.along(self.e1, u).along(self.e2, v).along(d, -t_rest);
        let inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0);
        let meets = inside & (apart.length_squared() <= ray.hit_tolerance * ray.hit_tolerance);
        Confirmed { meets, t: t_near + t_rest, t_near, u, v }
    }

    /// The second step where single precision cannot tell. The edges lie further out by the rounding of `e1` and `e2`, so
    /// that neighbours leave no gap; the hit is then moved onto the edge. Rays in the triangle's plane do not hit it.
    #[cfg_attr(not(target_arch = "nvptx64"), cold)]
    pub fn confirm_in_double(&self, ray: &LocalRay) -> Confirmed {
        let (v0, o, d) = (double(self.v0), double(ray.origin), double(ray.direction));
        let (e1, e2) = (double(self.e1), double(self.e2));
        let c = [v0[0] - o[0], v0[1] - o[1], v0[2] - o[2]];
        let r = cross64(c, d);
        let determinant = dot64(cross64(e1, e2), d);
        let sign = if determinant < 0.0 { -1.0 } else { 1.0 };
        let (u, v) = (sign * dot64(r, e2), -(sign * dot64(r, e1)));
        let determinant = sign * determinant;
        let (length1, length2) = (self.length1 as f64, self.length2 as f64);
        let squared = dot64(d, d);
        let moved = EDGE_ROUNDING * (length1 + length2) * sqrt64(squared);
        let w = determinant - u - v;
        let holds = (u >= -moved * length2) & (v >= -moved * length1) & (w >= -moved * (length1 + length2));
        let at_least_0 = |x: f64| if x > 0.0 { x } else { 0.0 };
        let (u, v) = (at_least_0(u / determinant), at_least_0(v / determinant));
        let over = if u + v > 1.0 { 1.0 / (u + v) } else { 1.0 };
        let (u, v) = (u * over, v * over);
        let point = |k: usize| c[k] + u * e1[k] + v * e2[k];
        let point = [point(0), point(1), point(2)];
        let t = dot64(point, d) / squared;
        let apart = [point[0] - t * d[0], point[1] - t * d[1], point[2] - t * d[2]];
        // Squared in single precision it may be 0.
        let tolerance = ray.hit_tolerance as f64;
        let together = dot64(apart, apart) <= tolerance * tolerance;
        let (t, u, v) = (t as f32, u as f32, v as f32);
        Confirmed { meets: holds & together & (determinant > 0.0), t, t_near: t, u, v }
    }

    /// Every hierarchy looks for the triangle within its padded bounds.
    fn passes_bounds(&self, ray: &LocalRay, t: f32) -> bool {
        let (near, far) = ray.slab.interval(&self.bounds(ray.padding), ray.t_min);
        Slab::passes(near, far, t)
    }
}
