//! The first step of the triangle test, in single precision: most rays miss, and most hits are clear.

use super::{
    EDGE_REACH, EDGE_SLACK, LocalRay, PackedTriangle, T_ERROR, T_SLACK, T_UNDERFLOW, UNDERFLOW_SLACK,
    UV_ERROR,
};
use crate::math::{fma, min};

/// Whether a ray may meet a triangle.
///
/// Möller and Trumbore's formula (1997), arranged around R = C × D as in Embree, with C the first vertex minus the origin
/// and D the direction: edge functions are R·E2 and -R·E1, the third is the determinant less both.
#[derive(Clone, Copy, Debug)]
pub struct FirstStep {
    /// Whether they may meet.
    pub may_meet: bool,
    /// Direction dot normal is below 0 or not a number: the ray meets the front.
    pub meets_front: bool,
    /// Edge functions, and the determinant without its sign.
    u: f32,
    v: f32,
    size: f32,
    /// The smallest edge function, and by how much they may be wrong.
    least: f32,
    slack: f32,
    numerator: f32,
    /// From the origin to the first vertex, at least.
    distance: f32,
    /// Lengths of the edges, multiplied.
    product: f32,
}

/// Where a ray meets a triangle's plane, in single precision, with the bounds of its error.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Distance in units of the direction's length; wrong by at most `error`, where `is_steep`.
    pub t: f32,
    /// What `t` may be wrong by.
    pub error: f32,
    /// Weight of the second vertex.
    pub u: f32,
    /// Weight of the third vertex.
    pub v: f32,
    /// Whether the error is known.
    pub is_steep: bool,
    /// Whether there is a hit for certain, within the error.
    pub is_certain: bool,
    /// Whether `t`, `u` and `v` are the hit's own, too.
    pub is_clear: bool,
}

impl PackedTriangle {
    /// The first step. Free of branches, so that loops over rays become SIMD code.
    #[inline(always)]
    pub fn first_step(&self, ray: &LocalRay) -> FirstStep {
        let (e1, e2) = (self.e1(), self.e2());
        let from_origin = self.v0 - ray.origin;
        let r = from_origin.cross(ray.direction);
        let normal = e1.cross(e2);
        let determinant = normal.dot(ray.direction);
        let sign = determinant.to_bits() & 0x8000_0000;
        let signed = |x: f32| f32::from_bits(x.to_bits() ^ sign);
        let (u, v, size) = (signed(r.dot(e2)), signed(-r.dot(e1)), determinant.abs());
        let least = min(min(u, v), size - u - v);
        let c = from_origin.abs();
        let lengths = self.length1 + self.length2;
        let distance = fma(EDGE_REACH, lengths, (c.x + c.y) + (c.z + ray.reach));
        // Below 0 for triangles without area: those are never met.
        let slack = fma((EDGE_SLACK * ray.length) * (distance + lengths.abs()), lengths, UNDERFLOW_SLACK);
        FirstStep {
            // Numbers out of range may make it NaN: that is for double precision to decide.
            may_meet: !(least < -slack),
            meets_front: sign != 0,
            u,
            v,
            size,
            least,
            slack,
            numerator: signed(normal.dot(from_origin)),
            distance,
            product: self.length1 * self.length2,
        }
    }
}

impl FirstStep {
    /// When they meet.
    #[inline(always)]
    pub fn meeting(&self, ray: &LocalRay) -> Meeting {
        let inverse = 1.0 / self.size;
        let t = self.numerator * inverse;
        let along = t.abs();
        let distances = fma(along, ray.length, self.distance);
        let error = fma(T_SLACK * (self.product * inverse), distances, T_UNDERFLOW * inverse);
        let is_exact = (error * ray.length <= T_ERROR * fma(along, ray.length, ray.scale))
            & (self.slack <= UV_ERROR * self.size);
        let is_between = (t - error > ray.t_min) & (t + error <= ray.t_max);
        Meeting {
            t,
            error,
            u: self.u * inverse,
            v: self.v * inverse,
            is_steep: self.slack <= self.size,
            is_certain: (self.least >= self.slack) & is_between,
            is_clear: (self.least >= self.slack) & is_exact & is_between,
        }
    }
}

impl Meeting {
    /// Whether it lies beyond an end of the ray for certain.
    #[inline(always)]
    pub fn is_beyond(&self, t_min: f32, t_max: f32) -> bool {
        // NaN is neither: it says nothing.
        self.is_steep & ((self.t + self.error < t_min) | (self.t - self.error > t_max))
    }
}
