//! A ray as the search for one ray at a time reads it.

use crate::simd::{Float, Mask, Simd};
use eosphor_core::intersect::{
    EDGE_SLACK, EDGE_TOLERANCE, HIT_TOLERANCE, LARGEST_NUMBER, LocalRay, PADDING, SHORTEST_DIRECTION,
    SLAB_SLACK, SMALLEST_DIRECTION, STEEP, Slab, T_SLACK, USUAL_LENGTH, USUAL_REACH,
};
use eosphor_core::math::{Vec3, vec3};

/// A ray in the space of a geometry, ready for its tree. It stays small and in memory: what a step needs in all lanes
/// is a load away. Vectors have x, y, z and something else.
pub(super) struct SingleRay {
    /// And `t_min`; NaN where the ray has numbers out of range.
    pub(super) origin: [f32; 4],
    /// And the sum of its components, without signs.
    pub(super) direction: [f32; 4],
    pub(super) inverse: [f32; 4],
    pub(super) near_offset: [f32; 4],
    pub(super) far_offset: [f32; 4],
    edge_tolerance: f32,
    /// [`EDGE_SLACK`] tolerances.
    pub(super) edge_slack: f32,
    pub(super) t_slack: f32,
    extent: f32,
    pub(super) octant: usize,
}

impl SingleRay {
    /// As `LocalRay::new`, in lanes.
    #[inline(always)]
    pub(super) fn new<S: Simd>(origin: Vec3, direction: Vec3, t_min: f32, extent: f32) -> SingleRay {
        let largest = origin.abs().max_component();
        let reach = extent + largest;
        let (o, d) = (origin.abs(), direction.abs());
        let length = d.x + d.y + d.z;
        let [[reach_low, reach_high], [length_low, length_high]] = [USUAL_REACH, USUAL_LENGTH];
        let is_usual =
            (reach_low <= reach) & (reach <= reach_high) & (length_low <= length) & (length <= length_high);
        // What is usual is in range.
        let t_min = if is_usual { t_min } else { t_min_of_unusual(o, length, t_min) };
        let origin = [origin.x, origin.y, origin.z, t_min];
        let direction = [direction.x, direction.y, direction.z, length];
        let (o, d) = (S::F4::from_array(&origin), S::F4::from_array(&direction));
        let smallest = S::F4::splat(SMALLEST_DIRECTION);
        let safe = d.or_else(smallest.lt(d.abs()), smallest.xor(d.sign()));
        let inverse = S::F4::splat(1.0).div(safe);
        let slack = inverse.abs().mul(S::F4::splat(SLAB_SLACK * largest));
        let offset = o.mul(inverse).negate();
        SingleRay {
            origin,
            direction,
            inverse: inverse.to_array(),
            near_offset: offset.sub(slack).to_array(),
            far_offset: offset.add(slack).to_array(),
            edge_tolerance: EDGE_TOLERANCE * reach * length,
            edge_slack: EDGE_SLACK * EDGE_TOLERANCE * reach * length,
            t_slack: if is_usual { T_SLACK * reach } else { f32::INFINITY },
            extent,
            octant: (inverse.lt(S::F4::splat(0.0)).bits() & 7) as usize,
        }
    }

    /// As `LocalRay::new`: what nobody asks for is not computed.
    #[inline(always)]
    pub(super) fn local(&self) -> LocalRay {
        let vector = |v: &[f32; 4]| vec3(v[0], v[1], v[2]);
        let direction = vector(&self.direction);
        LocalRay {
            origin: vector(&self.origin),
            direction,
            t_min: self.origin[3],
            slab: Slab {
                inverse: vector(&self.inverse),
                near_offset: vector(&self.near_offset),
                far_offset: vector(&self.far_offset),
            },
            inverse_direction_squared: 1.0 / direction.length_squared(),
            edge_tolerance: self.edge_tolerance,
            steep: STEEP * self.direction[3],
            t_slack: self.t_slack,
            hit_tolerance: HIT_TOLERANCE * self.extent,
            padding: PADDING * self.extent,
        }
    }
}

/// `t_min`, or NaN where numbers are out of range.
#[cold]
fn t_min_of_unusual(origin: Vec3, length: f32, t_min: f32) -> f32 {
    let in_range =
        ((origin.x + origin.y + origin.z) + length <= LARGEST_NUMBER) & (length >= SHORTEST_DIRECTION);
    if in_range { t_min } else { f32::NAN }
}
