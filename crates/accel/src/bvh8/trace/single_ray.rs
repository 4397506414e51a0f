//! A ray as the search for one ray at a time reads it.

use super::found::Found;
use crate::bvh8::view::GeometrySize;
use crate::simd::{Float, Kernel, Mask, Simd};
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::{BoxEntry, LOST, is_far, moved_at};
use eosphor_core::intersect::{
    EDGE_REACH, EDGE_SLACK, EXTENT_SLACK, LARGEST_NUMBER, LocalRay, ORIGIN_SLACK, SHORTEST_DIRECTION,
    SMALLEST_DIRECTION, T_SLACK, USUAL_LENGTH,
};
use eosphor_core::math::Affine;
use eosphor_core::ray::Ray;

/// Room for the rounding of sums that bound others.
const ROUNDING: f32 = 1.0001;

/// The distances from the origin to a triangle's first vertex and to a hit of the triangle are together at most this
/// times the largest distance from the origin to a point of the geometry. The vertex counts 1. The hit counts 1.32,
/// because its `t` in single precision is wrong by at most 0.135 of the two distances together. (With u = 2^-24, the
/// error is 13 u of the product of the two edges' lengths over the determinant, and the determinant is above 3 times
/// 8 u of the square of the sum of these lengths.)
const HIT_DISTANCES: f32 = 2.5;

/// Below this, the volume of no edges and distance overflows.
const LARGEST_VOLUME: f32 = 1e36;

/// [`SingleRay::t_slack`] of a ray whose origin lies no farther than `scale` from 0: infinite, which makes no hit certain, where
/// the normal of a triangle times the distance to it may overflow.
#[inline(always)]
fn t_slack(size: GeometrySize, scale: f32) -> f32 {
    let distances = 3.0 * size.extent + scale;
    // (Edges are no longer than 3.5 extents.)
    let overflows = !(size.extent * size.extent * distances < LARGEST_VOLUME);
    if overflows { f32::INFINITY } else { (T_SLACK * HIT_DISTANCES) * distances }
}

/// A ray in the space of a geometry, ready for its tree. It stays small and in memory: what a step needs in all lanes
/// is a load away. Vectors have x, y, z and something else.
///
/// In this order, since numbers that are read together must not lie side by side: the compiler would read two at a time, and
/// where these have just been written one by one the CPU has to wait (diffuse rays were 8 percent slower).
#[repr(C)]
pub(super) struct SingleRay<'a> {
    /// And `t_min`; NaN where the ray has numbers out of range.
    pub(super) origin: [f32; 4],
    /// And its length, as in `LocalRay`.
    pub(super) direction: [f32; 4],
    pub(super) inverse: [f32; 4],
    pub(super) near_offset: [f32; 4],
    pub(super) far_offset: [f32; 4],
    /// [`EDGE_SLACK`] of the length.
    pub(super) edge_slack: f32,
    /// [`T_SLACK`] of the distances of any hit of the geometry: times a product of lengths over a determinant, more than `t`
    /// may be wrong by where a ray is within the edges for certain. Infinite where it may be anything.
    pub(super) t_slack: f32,
    pub(super) octant: u32,
    /// Times the lengths of its edges, edge functions of any triangle of the geometry are below this only where the ray
    /// passes by.
    pub(super) outside: f32,
    /// The ray in the world, and its way into this space.
    pub(super) world: Ray,
    pub(super) reach: f32,
    pub(super) map: Option<&'a Affine>,
    pub(super) scale: f32,
    /// The origin is not the ray's own but where it enters the tree's box, at this `t` of the ray.
    pub(super) from: Option<f64>,
    /// Hits that are not over before this are not certain. From the origin, like `t_min`.
    pub(super) t_max: f32,
    /// [`LOST`] of the way to there.
    pub(super) lost: f32,
}

/// A copy, in one piece: the compiler would make it of two that overlap, which a CPU has to wait for.
#[inline(always)]
fn copied<S: Simd>(ray: &Ray) -> Ray {
    let mut copy = std::mem::MaybeUninit::<Ray>::uninit();
    // SAFETY: lanes: a ray is eight floats.
    unsafe {
        S::F8::load((&raw const *ray).cast()).store(copy.as_mut_ptr().cast());
        copy.assume_init()
    }
}

impl<'a> SingleRay<'a> {
    /// Whether [`SingleRay::of_world`] is for this ray, to which its own numbers do no harm, which does not start farther
    /// away than this, and which begins at its origin or beyond and ends later.
    #[inline(always)]
    pub(super) fn is_usual(ray: &Ray, near: f32) -> bool {
        let (o, d) = (ray.origin.abs(), ray.direction.abs());
        let length = d.x + d.y + d.z;
        let [shortest, longest] = USUAL_LENGTH;
        let is_forward = (0.0 <= ray.t_min) & (ray.t_min <= ray.t_max);
        (o.max_component() <= near) & (shortest <= length) & (length <= longest) & is_forward
    }

    /// In the world.
    #[inline(always)]
    pub(super) fn of_world<S: Simd>(ray: &Ray, size: GeometrySize) -> SingleRay<'a> {
        let (o, d) = (ray.origin.abs(), ray.direction.abs());
        let (length, scale) = (d.x + d.y + d.z, o.x + o.y + o.z);
        // (With `t_max` beside the direction, dividing by it would often give a denormal number, which is slow.)
        let origin = [ray.origin.x, ray.origin.y, ray.origin.z, ray.t_min];
        let direction = [ray.direction.x, ray.direction.y, ray.direction.z, length];
        let slab_extent = size.extent + o.max_component();
        SingleRay::usual::<S>(ray, origin, direction, slab_extent, scale, size)
    }

    /// A ray whose direction has a usual length ([`USUAL_LENGTH`]). The fourth numbers of `origin` and `direction` are
    /// `t_min` and the length. `slab_extent` is at least the extent of all boxes and the largest coordinate of the
    /// origin, added. `size` is that of the geometry. `scale` is the distance from 0 to the origin, with the ray's
    /// reach added.
    #[inline(always)]
    fn usual<S: Simd>(
        world: &Ray,
        origin: [f32; 4],
        direction: [f32; 4],
        slab_extent: f32,
        scale: f32,
        size: GeometrySize,
    ) -> SingleRay<'a> {
        let (lanes, d) = (S::F4::from_array(&origin), S::F4::from_array(&direction));
        let smallest = S::F4::splat(SMALLEST_DIRECTION);
        let safe = d.or_else(smallest.lt(d.abs()), smallest.xor(d.sign()));
        let inverse = S::F4::splat(1.0).div(safe);
        let everywhere = S::F4::splat(EXTENT_SLACK * slab_extent);
        let slack = inverse.abs().mul(lanes.abs().mul(S::F4::splat(ORIGIN_SLACK)).add(everywhere));
        let offset = lanes.mul(inverse).negate();
        let edge_slack = EDGE_SLACK * direction[3];
        let most_distance = (size.farthest + scale) * ROUNDING;
        let t_slack = t_slack(size, scale);
        SingleRay {
            origin,
            direction,
            inverse: inverse.to_array(),
            near_offset: offset.sub(slack).to_array(),
            far_offset: offset.add(slack).to_array(),
            edge_slack,
            t_slack,
            outside: -edge_slack * most_distance,
            reach: EDGE_REACH * scale,
            scale,
            // (Not of the inverse, for which the first node would have to wait.)
            octant: safe.lt(S::F4::splat(0.0)).bits() & 7,
            world: copied::<S>(world),
            map: None,
            from: None,
            t_max: world.t_max,
            lost: 0.0,
        }
    }

    /// Any ray in the world, whose tree has this box. `None` where the ray passes that by, as far as that is known.
    #[inline(always)]
    pub(super) fn of_any<S: Simd>(ray: &Ray, size: GeometrySize, bounds: &Bounds) -> Option<SingleRay<'a>> {
        if is_far(ray.origin, bounds.extent()) {
            return SingleRay::far::<S>(ray, To::World, size, bounds);
        }
        Some(SingleRay::from_local::<S>(&LocalRay::new(ray, size.extent), ray, None, size, None))
    }

    /// Any ray in the world, for the tree over the instances, which has this box.
    #[inline(always)]
    pub(super) fn to_instances<S: Simd>(ray: &Ray, bounds: &Bounds) -> Option<SingleRay<'a>> {
        // There are no triangles in it.
        let size = GeometrySize { extent: bounds.extent(), farthest: 0.0 };
        if is_far(ray.origin, size.extent) {
            return SingleRay::far::<S>(ray, To::Instances, size, bounds);
        }
        Some(SingleRay::from_local::<S>(&LocalRay::new(ray, size.extent), ray, None, size, None))
    }

    /// In an object's space.
    #[inline(always)]
    pub(super) fn of_object<S: Simd>(
        ray: &Ray,
        map: &'a Affine,
        size: GeometrySize,
        bounds: &Bounds,
    ) -> Option<SingleRay<'a>> {
        let local = LocalRay::mapped(ray, map, size.extent);
        if is_far(local.origin, bounds.extent()) {
            // Numbers that are out of range here alone: such a ray hits nothing, from wherever it is looked at.
            if local.t_min.is_nan() {
                return None;
            }
            return SingleRay::far::<S>(ray, To::Object(map), size, bounds);
        }
        Some(SingleRay::from_local::<S>(&local, ray, Some(map), size, None))
    }

    #[inline(always)]
    fn far<S: Simd>(ray: &Ray, to: To<'a>, size: GeometrySize, bounds: &Bounds) -> Option<SingleRay<'a>> {
        // SAFETY: instruction set: this runs below a kernel's.
        unsafe { S::run(Far { ray, to, size, bounds }) }
    }

    #[inline(always)]
    fn from_box<S: Simd>(
        ray: &Ray,
        to: To<'a>,
        size: GeometrySize,
        bounds: &Bounds,
    ) -> Option<SingleRay<'a>> {
        let (o, d) = (ray.origin.abs(), ray.direction.abs());
        let length = d.x + d.y + d.z;
        // Such a ray hits nothing, from wherever it is looked at. NaN is neither.
        if !(((o.x + o.y + o.z) + length <= LARGEST_NUMBER) & (length >= SHORTEST_DIRECTION)) {
            return None;
        }
        let (map, moved_at) = match to {
            To::World => (None, 0.0),
            To::Instances => (None, moved_at(ray)),
            To::Object(map) => (Some(map), 0.0),
        };
        let entry = BoxEntry::new(ray, map, bounds, moved_at)?;
        let (from, slab_extent) = (entry.from, bounds.extent() + moved_at);
        if entry.length.is_infinite() {
            return Some(SingleRay::from_local::<S>(&entry.ray(slab_extent), ray, map, size, Some(from)));
        }
        let (o, d, at) = (entry.origin, entry.direction, entry.origin.abs());
        let reach = at.x + at.y + at.z;
        let usual = SingleRay::usual::<S>(
            ray,
            [o.x, o.y, o.z, entry.t_min],
            [d.x, d.y, d.z, entry.length],
            slab_extent + at.max_component(),
            reach + reach,
            size,
        );
        let lost = (from.abs() * LOST) as f32;
        Some(SingleRay { reach, scale: 0.0, map, from: Some(from), t_max: entry.t_max, lost, ..usual })
    }

    #[inline(always)]
    fn from_local<S: Simd>(
        local: &LocalRay,
        world: &Ray,
        map: Option<&'a Affine>,
        size: GeometrySize,
        from: Option<f64>,
    ) -> SingleRay<'a> {
        let (o, d, slab) = (local.origin, local.direction, &local.slab);
        let four = |v: eosphor_core::math::Vec3, w: f32| [v.x, v.y, v.z, w];
        let i = slab.inverse;
        let (edge_slack, at) = (EDGE_SLACK * local.length, o.abs());
        let scale = at.x + at.y + at.z + local.reach;
        let most_distance = (size.farthest + scale) * ROUNDING;
        let t_slack = t_slack(size, scale);
        let octant = (i.x < 0.0) as u32 | ((i.y < 0.0) as u32) << 1 | ((i.z < 0.0) as u32) << 2;
        SingleRay {
            origin: four(o, local.t_min),
            direction: four(d, local.length),
            inverse: four(i, 0.0),
            near_offset: four(slab.near_offset, 0.0),
            far_offset: four(slab.far_offset, 0.0),
            edge_slack,
            t_slack,
            outside: -edge_slack * most_distance,
            reach: local.reach,
            scale: local.scale,
            octant,
            world: *world,
            map,
            from,
            t_max: local.t_max,
            lost: from.map_or(0.0, |from| (from.abs() * LOST) as f32),
        }
    }

    /// Tells the search from where it measures now.
    #[inline(always)]
    pub(super) fn enter(&self, found: &mut Found) {
        if (self.from != found.from) | self.from.is_some() {
            found.measure_from(self.from);
        }
    }
}

/// What a ray from far away goes to: the tree of the world, the one over the instances, or one into whose space this takes it.
enum To<'a> {
    World,
    Instances,
    Object(&'a Affine),
}

/// A ray from far away: a function of its own, since it is rare.
struct Far<'a, 'b> {
    ray: &'b Ray,
    to: To<'a>,
    size: GeometrySize,
    bounds: &'b Bounds,
}

impl<'a> Kernel for Far<'a, '_> {
    type Output = Option<SingleRay<'a>>;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> Option<SingleRay<'a>> {
        SingleRay::from_box::<S>(self.ray, self.to, self.size, self.bounds)
    }
}

/// For tests whether a ray may meet a sphere, which read no more of it.
impl SingleRay<'_> {
    #[inline(always)]
    pub(super) fn local(&self) -> LocalRay {
        let vector = |v: &[f32; 4]| eosphor_core::math::vec3(v[0], v[1], v[2]);
        LocalRay {
            origin: vector(&self.origin),
            direction: vector(&self.direction),
            t_min: self.origin[3],
            t_max: self.world.t_max,
            slab: eosphor_core::intersect::Slab {
                inverse: vector(&self.inverse),
                near_offset: vector(&self.near_offset),
                far_offset: vector(&self.far_offset),
            },
            length: self.direction[3],
            reach: self.reach,
            scale: self.scale,
        }
    }
}
