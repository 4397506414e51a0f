//! A ray in the space of a geometry, with what the intersection tests need of it.

use super::precise::{PreciseRay, single};
use super::{EDGE_REACH, Slab};
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
    /// Hits must not lie beyond this.
    pub t_max: f32,
    /// For boxes.
    pub slab: Slab,
    /// At least the direction's length, with what mapping it into this space may have changed. Infinite where products
    /// might leave the range of numbers: nothing is clear then.
    pub length: f32,
    /// Added to distances from the origin: [`EDGE_REACH`] of the one from 0; mapping it into this space may have moved it by a
    /// share of this.
    pub reach: f32,
    /// At least the distance from 0 to the ray's origin in the world, in the units of this space.
    pub scale: f32,
}

/// Rays whose direction is shorter hit nothing: beside it, the slab test's smallest component would be a tilt.
pub const SHORTEST_DIRECTION: f32 = 1e-11;

/// Rays with larger numbers, infinities or NaN hit nothing: products of smaller ones stay finite.
pub const LARGEST_NUMBER: f32 = 1e18;

/// The largest coordinate of a ray's origin, in world units, up to which single precision is trusted.
pub const USUAL_REACH: f32 = 1e12;

/// The lengths of a ray's direction for which single precision is trusted: products neither underflow nor overflow.
pub const USUAL_LENGTH: [f32; 2] = [1e-6, 3e4];

/// Mapped directions count as longer by this factor, which covers their rounding.
pub const WORLD_FROM_OBJECT_ROUNDING: f32 = 1.25;

#[inline(always)]
fn sum(v: Vec3) -> f32 {
    v.x.abs() + v.y.abs() + v.z.abs()
}

impl LocalRay {
    /// A ray of the world in a geometry's space, into which the map takes it; the world itself has none.
    #[inline(always)]
    pub(crate) fn of(ray: &Ray, object_from_world: Option<&Affine>, extent: f32) -> LocalRay {
        match object_from_world {
            Some(map) => LocalRay::mapped(ray, map, extent),
            None => LocalRay::new(ray, extent),
        }
    }

    /// In the world, whose largest coordinate is `extent`.
    #[inline(always)]
    pub fn new(ray: &Ray, extent: f32) -> LocalRay {
        let (length, scale) = (sum(ray.direction), sum(ray.origin));
        let own = LocalRay::in_space(ray, ray.origin, ray.direction, extent, length, 0.0, scale);
        LocalRay { reach: EDGE_REACH * scale, ..own }
    }

    /// In an object's space.
    #[inline(always)]
    pub fn mapped(ray: &Ray, map: &Affine, extent: f32) -> LocalRay {
        // Mapped in double precision: what is rounded is no more than the ray in this space.
        let PreciseRay { origin, direction } = PreciseRay::of(ray, Some(map));
        let (origin, direction) = (single(origin), single(direction));
        let length = WORLD_FROM_OBJECT_ROUNDING * sum(direction);
        let scale = sum(ray.origin) * (length / sum(ray.direction));
        LocalRay::in_space(ray, origin, direction, extent, length, sum(origin), scale)
    }

    #[inline(always)]
    fn in_space(
        ray: &Ray,
        origin: Vec3,
        direction: Vec3,
        extent: f32,
        length: f32,
        reach: f32,
        scale: f32,
    ) -> LocalRay {
        let own = sum(direction);
        // The sum is NaN where one of them is.
        let in_range = (sum(origin) + own <= LARGEST_NUMBER) & (own >= SHORTEST_DIRECTION);
        let [shortest, longest] = USUAL_LENGTH;
        let largest = origin.abs().max_component();
        let is_usual = (largest + reach <= USUAL_REACH) & (shortest <= own) & (length <= longest);
        LocalRay {
            origin,
            direction,
            t_min: if in_range { ray.t_min } else { f32::NAN },
            t_max: ray.t_max,
            slab: Slab::new(origin, direction, extent),
            length: if is_usual { length } else { f32::INFINITY },
            reach,
            scale,
        }
    }
}
