//! The one triangle test.
//!
//! Candidates are found by the first step ([`super::FirstStep`]), in single precision. A hit that is clear of all doubt has
//! that step's `t`, `u` and `v`. About the rest double precision decides ([`super::precise`]), so that no ray slips between
//! neighbours and none hits what it passes.

use super::precise::{PreciseHit, PreciseRay};
use super::{LocalRay, SphereHit};
use crate::geometry::Bounds;
use crate::math::{Affine, Vec3, sqrt};
use crate::out_of_line::{on_cpus, out_of_line};
use crate::ray::{Ray, UNKNOWN_REST};

/// Triangles whose edges meet at an angle with a sine below this have no area that single precision can tell.
const NO_AREA: f32 = 1.0 / 4_194_304.0;

/// More than rounding a `t` to single precision, and adding that to a number, can change it by.
pub const T_ROUNDING: f32 = 1.0 / 4_194_304.0;

/// A triangle as the test reads it: 48 bytes, three 16-byte loads.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub struct PackedTriangle {
    /// First vertex.
    pub v0: Vec3,
    /// From the first vertex to the second; below 0 in a triangle without area, which is never hit.
    pub length1: f32,
    /// Second vertex.
    pub v1: Vec3,
    /// From the first vertex to the third.
    pub length2: f32,
    /// Third vertex.
    pub v2: Vec3,
    /// Its number in its geometry.
    pub primitive: u32,
}

impl PackedTriangle {
    /// Packs a triangle; `primitive` is its index in its geometry. Rounding errors are smallest if the vertices are in the
    /// order of [`longest_edge_last`].
    #[inline(always)]
    pub fn new([v0, v1, v2]: [Vec3; 3], primitive: u32) -> PackedTriangle {
        let (e1, e2) = (v1 - v0, v2 - v0);
        let length = |e: Vec3| sqrt(e.length_squared());
        let (length1, length2) = (length(e1), length(e2));
        // Corners on one line have a normal that is nothing but rounding error.
        let sine = (e1 * (1.0 / length1)).cross(e2 * (1.0 / length2)).length();
        // An edge without length makes it NaN.
        if sine.is_nan() | (sine <= NO_AREA) {
            return PackedTriangle { v0, length1: -1.0, v1: v0, length2: -1.0, v2: v0, primitive };
        }
        PackedTriangle { v0, length1, v1, length2, v2, primitive }
    }

    /// Second vertex minus the first.
    #[inline(always)]
    pub fn e1(&self) -> Vec3 {
        self.v1 - self.v0
    }

    /// Third vertex minus the first.
    #[inline(always)]
    pub fn e2(&self) -> Vec3 {
        self.v2 - self.v0
    }

    /// Its bounds, grown as boxes have to be ([`Bounds::with_slack`]).
    #[inline(always)]
    pub fn bounds(&self) -> Bounds {
        let (low, high) = (self.v0.min(self.v1.min(self.v2)), self.v0.max(self.v1.max(self.v2)));
        Bounds { min: low, max: high }.with_slack()
    }

    /// Not of unit length; on the side from which the vertices run counter-clockwise.
    #[inline(always)]
    pub fn normal(&self) -> Vec3 {
        self.e1().cross(self.e2())
    }
}

on_cpus! {
    /// How far to rotate the vertices so that the edge between second and third is the longest: vertex `(k + i) % 3` comes
    /// to place `i`. The third edge function is a difference of the other two and has their errors; next to the longest
    /// edge they are smallest, so that slivers are clear more often.
    pub fn longest_edge_last(vertices: &[Vec3; 3]) -> usize {
        let [a, b, c] = *vertices;
        let opposite0 = (b - c).length_squared();
        let opposite1 = (c - a).length_squared();
        let opposite2 = (a - b).length_squared();
        if opposite0 >= opposite1 && opposite0 >= opposite2 {
            0
        } else if opposite1 >= opposite2 {
            1
        } else {
            2
        }
    }
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Whether it does, beyond its start.
    pub meets: bool,
    /// Whether single precision was enough.
    pub is_clear: bool,
    /// Distance in units of the direction's length.
    pub t: f32,
    /// What `t` may be wrong by; 0 where it is that of double precision, rounded.
    pub t_error: f32,
    /// What rounding took from the `t` of double precision; [`UNKNOWN_REST`] where single precision was enough.
    pub t_rest: f32,
    /// Weight of the second vertex.
    pub u: f32,
    /// Weight of the third vertex.
    pub v: f32,
}

impl TriangleHit {
    /// They do not meet.
    pub const NOWHERE: TriangleHit =
        TriangleHit { meets: false, is_clear: false, t: 0.0, t_error: 0.0, t_rest: 0.0, u: 0.0, v: 0.0 };

    /// A crossing of a sphere.
    #[inline(always)]
    pub fn of_sphere(hit: &SphereHit) -> TriangleHit {
        TriangleHit { meets: true, t: hit.t, t_rest: hit.t_rest, ..TriangleHit::NOWHERE }
    }

    /// Bounds of the `t` of double precision.
    #[inline(always)]
    pub fn bounds(&self) -> (f32, f32) {
        let error = self.t.abs() * T_ROUNDING + self.t_error;
        (self.t - error, self.t + error)
    }

    /// In double precision.
    #[inline(always)]
    pub fn precise(hit: &PreciseHit, ray: &Ray) -> TriangleHit {
        let t = hit.t as f32;
        TriangleHit {
            // Comparisons are written so that NaN fails them.
            meets: (t > ray.t_min) & (t <= ray.t_max) & (t < f32::INFINITY),
            is_clear: false,
            t,
            t_error: 0.0,
            t_rest: (hit.t - t as f64) as f32,
            u: hit.u as f32,
            v: hit.v as f32,
        }
    }
}

out_of_line! {
    /// Where a ray of the world meets a triangle of a space into which the map takes it; the world itself has none. Its
    /// largest coordinate is `extent`, which changes no hit.
    pub fn intersect_triangle(
        triangle: &PackedTriangle,
        ray: &Ray,
        object_from_world: Option<&Affine>,
        extent: f32,
    ) -> TriangleHit {
        let local = LocalRay::of(ray, object_from_world, extent);
        let step = triangle.first_step(&local);
        // NaN is not a start: nothing is hit.
        if !step.may_meet | local.t_min.is_nan() {
            return TriangleHit::NOWHERE;
        }
        let meeting = step.meeting(&local);
        if meeting.is_clear {
            let (t, t_error, u, v) = (meeting.t, meeting.error, meeting.u, meeting.v);
            return TriangleHit { meets: true, is_clear: true, t, t_error, t_rest: UNKNOWN_REST, u, v };
        }
        match PreciseRay::of(ray, object_from_world).meet_triangle(triangle) {
            Some(hit) => TriangleHit::precise(&hit, ray),
            None => TriangleHit::NOWHERE,
        }
    }
}

out_of_line! {
    /// [`intersect_triangle`] where single precision is not clear.
    pub fn intersect_precisely(
        triangle: &PackedTriangle,
        ray: &Ray,
        object_from_world: Option<&Affine>,
    ) -> TriangleHit {
        match PreciseRay::of(ray, object_from_world).meet_triangle(triangle) {
            Some(hit) => TriangleHit::precise(&hit, ray),
            None => TriangleHit::NOWHERE,
        }
    }
}

out_of_line! {
    /// What the `t` of a triangle's hit lacks of that of double precision.
    pub fn t_rest(
        triangle: &PackedTriangle,
        t: f32,
        ray: &Ray,
        object_from_world: Option<&Affine>,
    ) -> f32 {
        match PreciseRay::of(ray, object_from_world).meet_triangle(triangle) {
            Some(hit) => (hit.t - t as f64) as f32,
            // There is a hit, or single precision would not have been clear about it.
            None => 0.0,
        }
    }
}
