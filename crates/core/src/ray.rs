//! Rays, hits, and what a ray must not see.

use crate::material::NONE;
use crate::math::Vec3;

/// A ray in world space. The direction is of unit length, so `t` is a distance in world units. Queries answer for other
/// lengths too, in units of that length.
///
/// Where a number of origin or direction is infinite, NaN or larger than [`crate::intersect::LARGEST_NUMBER`] (their sum
/// is what is compared), the direction is 0, or an end is NaN, nothing is hit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Hits must lie beyond this.
    pub t_min: f32,
    /// Unit vector.
    pub direction: Vec3,
    /// Hits must not lie beyond this.
    pub t_max: f32,
}

impl Ray {
    /// All of the ray from its origin on. The direction is of unit length.
    #[inline(always)]
    pub const fn new(origin: Vec3, direction: Vec3) -> Ray {
        Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
    }
}

/// Names a primitive: the instance that places it and its number in its geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct PrimitiveId {
    /// 0 is the world.
    pub instance: u32,
    /// Triangles first, then spheres.
    pub primitive: u32,
}

impl PrimitiveId {
    /// Names nothing.
    pub const NONE: PrimitiveId = PrimitiveId { instance: NONE, primitive: NONE };

    /// The order that settles ties between hits at the same `t`.
    #[inline(always)]
    pub fn before(self, o: PrimitiveId) -> bool {
        (self.instance < o.instance) | ((self.instance == o.instance) & (self.primitive < o.primitive))
    }
}

/// What a query leaves out. Triangles are left out by number because rounding can put a ray's origin on either side of
/// the triangle that it starts on; spheres are not, since a refracted ray must find the far side of its own sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct RayFilter {
    /// The triangle that the ray starts on.
    pub start: PrimitiveId,
    /// The triangle that it goes to: the sampled light.
    pub target: PrimitiveId,
    /// Triangles seen from behind are not there.
    pub cull_back_faces: bool,
}

impl RayFilter {
    /// Leaves out nothing.
    pub const ALL: RayFilter =
        RayFilter { start: PrimitiveId::NONE, target: PrimitiveId::NONE, cull_back_faces: false };

    /// Whether the triangle is one that the query leaves out by number.
    #[inline(always)]
    pub fn skips(&self, id: PrimitiveId) -> bool {
        (id == self.start) | (id == self.target)
    }
}

/// [`Hit::t_rest`] where it has not been computed.
pub const UNKNOWN_REST: f32 = f32::INFINITY;

/// Where a ray meets a primitive.
///
/// Hits of a ray are ordered by their `t` in double precision, ties by the lowest (instance, primitive).
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// Distance along the ray; the query's `t_max` for a miss. Of the exact distance it differs by no more than
    /// [`crate::intersect::T_ERROR`] × (distance from 0 to the ray's origin + t), mostly by some 2^-22 of that.
    pub t: f32,
    /// The `t` of double precision less `t`. [`UNKNOWN_REST`] in closest hits of triangles where single precision was enough
    /// to tell, as it mostly is; 0 for a miss.
    pub t_rest: f32,
    /// Barycentric weight of the second vertex; 0 for spheres.
    pub u: f32,
    /// Barycentric weight of the third vertex; 0 for spheres.
    pub v: f32,
    /// What was hit; [`PrimitiveId::NONE`] for a miss.
    pub id: PrimitiveId,
}

impl Hit {
    /// Nothing was hit up to `t_max`.
    #[inline(always)]
    pub fn miss(t_max: f32) -> Hit {
        Hit { t: t_max, t_rest: 0.0, u: 0.0, v: 0.0, id: PrimitiveId::NONE }
    }

    /// The `t` of double precision, where its rest is known; else what is known of it.
    #[inline(always)]
    pub fn t64(&self) -> f64 {
        self.t as f64 + if self.t_rest == UNKNOWN_REST { 0.0 } else { self.t_rest as f64 }
    }

    /// Whether `self` comes before `o` along the ray; ties go to the lowest (instance, primitive). For hits whose rest is
    /// known, as those of [`crate::hierarchy::Tracer::next_hit`] are.
    #[inline(always)]
    pub fn before(&self, o: &Hit) -> bool {
        let (t, other) = (self.t64(), o.t64());
        (t < other) | ((t == other) & self.id.before(o.id))
    }

    /// The point that `ray` hit, in world space.
    #[inline(always)]
    pub fn point(&self, ray: &Ray) -> Vec3 {
        ray.origin.plus_scaled(ray.direction, self.t)
    }

    /// Whether nothing was hit.
    #[inline(always)]
    pub fn is_miss(&self) -> bool {
        self.id.primitive == NONE
    }
}
