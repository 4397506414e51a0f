//! A first look at a triangle: most rays miss, and most hits are certain long before they are computed.
//!
//! What it says is a matter of bounds, not of bits: about all that is not certain, [`PackedTriangle::test`] decides.

use super::{LocalRay, PackedTriangle, SMALLEST_DETERMINANT, STEEP};
use crate::math::{Vec3, fma, min};

/// Tolerances by which edge functions are at most below 0 for a first look.
///
/// Those functions, of [`PackedTriangle::test_edges`] or with products in another order, are wrong by some 6 · 2^-24 of the
/// product of all lengths, at most 1.5 tolerances. So none is missed. (Walks that find certain hits with this constant
/// take those that are above it: the true ones are by 2 then. [`FirstLook::meeting`] knows better.)
pub const EDGE_SLACK: f32 = 4.0;

/// Bounds of `t`: by how much the first step's may differ from the second's, times the lengths of the triangle's edges and
/// the distance over the determinant, for rays that are steep. In units of 2^-24 of that, at most 14 come from the product
/// above and 14 from the one below; this is 128. The distance is that of the triangle's first corner from the ray's origin,
/// with the edges; the reach of ray and geometry is more than that.
pub const T_SLACK: f32 = 1.0 / 131_072.0;

/// The share of the reach that is added to the distance, for triangles at the origin, so that the products below do not
/// underflow.
const NEAR: f32 = 1.0 / 256.0;

/// Where edge functions are above this (16 · 2^-24) of the product of all lengths, with the distance for that of corner
/// and origin, it is a hit: the true ones are above 10 of those 16, and so is the canonical test's first step above 0; where it
/// asks double precision, that says the same.
const CERTAIN: f32 = 1.0 / 1_048_576.0;

/// That holds for products that neither underflow nor overflow: where the extent of geometry and ray is in this range,
pub const USUAL_REACH: [f32; 2] = [1.0 / 65_536.0, 1e12];
/// and the direction's length in this one.
pub const USUAL_LENGTH: [f32; 2] = [1e-6, 3e4];

/// What a first look at a triangle says.
#[derive(Clone, Copy, Debug)]
pub struct FirstLook {
    /// Whether the ray may meet it.
    pub may_meet: bool,
    /// Direction dot normal is below 0 or not a number: the ray meets the front.
    pub meets_front: bool,
    size: f32,
    /// The smallest edge function.
    least: f32,
    from_origin: Vec3,
    numerator: f32,
}

/// When a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// No earlier than this, where it is steep,
    pub low: f32,
    /// and no later than this.
    pub high: f32,
    /// Whether the bounds hold.
    pub is_steep: bool,
    /// Whether there is a hit at all, if between the ray's ends.
    pub is_certain: bool,
}

impl PackedTriangle {
    /// Whether a ray may meet it.
    #[inline(always)]
    pub fn first_look(&self, ray: &LocalRay) -> FirstLook {
        let from_origin: Vec3 = self.v0 - ray.origin;
        let r = from_origin.cross(ray.direction);
        let normal = self.normal();
        let determinant = normal.dot(ray.direction);
        let sign = determinant.to_bits() & 0x8000_0000;
        let signed = |x: f32| f32::from_bits(x.to_bits() ^ sign);
        let (u, v, size) = (signed(r.dot(self.e2)), signed(-r.dot(self.e1)), determinant.abs());
        let least = min(min(u, v), size - u - v);
        let slack = EDGE_SLACK * ray.edge_tolerance * (self.length1 + self.length2);
        let numerator = signed(normal.dot(from_origin));
        FirstLook { may_meet: least >= -slack, meets_front: sign != 0, size, least, from_origin, numerator }
    }
}

impl FirstLook {
    /// When they meet.
    #[inline(always)]
    pub fn meeting(&self, triangle: &PackedTriangle, ray: &LocalRay) -> Meeting {
        let (lengths, product) = (triangle.length1 + triangle.length2, triangle.length1 * triangle.length2);
        let away = self.from_origin;
        let distance = (away.x.abs() + away.y.abs()) + (away.z.abs() + lengths);
        // The ray's slack is infinite where it is not usual.
        let distance = fma(ray.t_slack, NEAR / T_SLACK, distance);
        let inverse = 1.0 / self.size;
        let t = self.numerator * inverse;
        let t_slack = (T_SLACK * distance) * (product * inverse);
        let is_steep = self.size >= fma(ray.steep, product, SMALLEST_DETERMINANT);
        // In `steep` is the direction's length.
        let slack = (CERTAIN / STEEP * ray.steep) * (distance * lengths);
        Meeting {
            low: t - t_slack,
            high: t + t_slack,
            is_steep,
            is_certain: is_steep & (self.least >= slack),
        }
    }
}
