//! A ray in the space of a geometry, with what the intersection tests need of it.

use super::{EDGE_TOLERANCE, HIT_TOLERANCE, PADDING, STEEP, Slab, T_SLACK, USUAL_LENGTH, USUAL_REACH};
use crate::math::{Affine, Vec3};
use crate::ray::Ray;

/// A ray in a geometry's space. The direction is not of unit length where an instance scales; `t` means the same in
/// every space.
#[derive(Clone, Copy, Debug)]
pub struct LocalRay {
    /// Where it starts.
    pub origin: Vec3,
    /// Any length but 0.
    pub direction: Vec3,
    /// Hits must lie beyond this. NaN where the ray has numbers beyond [`LARGEST_NUMBER`]: nothing is a hit then.
    pub t_min: f32,
    /// For boxes.
    pub slab: Slab,
    /// One over the squared length of the direction, for spheres.
    pub inverse_direction_squared: f32,
    /// What the edge functions of a triangle may be below 0, over the length of the edge.
    pub edge_tolerance: f32,
    /// From this times the lengths of two edges on, a determinant is one that single precision can be trusted with.
    pub steep: f32,
    /// What [`super::T_SLACK`] is multiplied with for this ray, and it; infinite where that does not hold.
    pub t_slack: f32,
    /// What the points on ray and primitive may differ.
    pub hit_tolerance: f32,
    /// Primitive bounds are grown by this.
    pub padding: f32,
}

/// Rays whose direction is shorter hit nothing: beside it, the slab test's smallest component would be a tilt.
pub const SHORTEST_DIRECTION: f32 = 1e-11;

/// Rays with larger numbers, infinities or NaN hit nothing: products of smaller ones stay finite.
pub const LARGEST_NUMBER: f32 = 1e18;

impl LocalRay {
    /// A ray of the world in a geometry's space, into which the map takes it; the world itself has none.
    #[inline(always)]
    pub(crate) fn of(ray: &Ray, object_from_world: Option<&Affine>, extent: f32) -> LocalRay {
        let (origin, direction) = match object_from_world {
            Some(map) => (map.point(ray.origin), map.direction(ray.direction)),
            None => (ray.origin, ray.direction),
        };
        LocalRay::new(origin, direction, ray.t_min, extent)
    }

    /// For a geometry of the given extent ([`crate::geometry::Geometry::extent`]).
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3, t_min: f32, extent: f32) -> LocalRay {
        let squared = direction.length_squared();
        let (o, d) = (origin.abs(), direction.abs());
        // At least the length, and cheaper.
        let length = d.x + d.y + d.z;
        // The sum is NaN where one of them is.
        let in_range = ((o.x + o.y + o.z) + length <= LARGEST_NUMBER) & (length >= SHORTEST_DIRECTION);
        let reach = extent + origin.abs().max_component();
        let [[reach_low, reach_high], [length_low, length_high]] = [USUAL_REACH, USUAL_LENGTH];
        let is_usual =
            (reach_low <= reach) & (reach <= reach_high) & (length_low <= length) & (length <= length_high);
        LocalRay {
            origin,
            direction,
            t_min: if in_range { t_min } else { f32::NAN },
            slab: Slab::new(origin, direction),
            inverse_direction_squared: 1.0 / squared,
            edge_tolerance: EDGE_TOLERANCE * reach * length,
            steep: STEEP * length,
            t_slack: if is_usual { T_SLACK * reach } else { f32::INFINITY },
            hit_tolerance: HIT_TOLERANCE * extent,
            padding: PADDING * extent,
        }
    }
}
