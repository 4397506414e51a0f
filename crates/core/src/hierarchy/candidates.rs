//! From a primitive that a traversal has reached to a hit that counts.

use super::SPHERE_REFERENCE;
use super::search::{OfferOutcome, PrimitiveSlot, Search};
use crate::geometry::{Geometry, Instance, Sphere};
use crate::intersect::{
    LocalRay, PackedTriangle, Slab, TriangleHit, intersect_sphere, intersect_triangle, may_meet_sphere,
    t_rest,
};
use crate::math::Affine;
use crate::out_of_line::out_of_line;
use crate::ray::{Hit, PrimitiveId, Ray, RayFilter, UNKNOWN_REST};

/// Primitives and instances, as every hierarchy holds them. Primitives stand in the hierarchy's own order within each
/// geometry's range; triangles carry their number with them.
#[derive(Clone, Copy, Debug)]
pub struct PrimitivesView<'a> {
    /// Triangles of all geometries.
    pub triangles: &'a [PackedTriangle],
    /// Spheres of all geometries.
    pub spheres: &'a [Sphere],
    /// For each sphere, its number in its geometry.
    pub sphere_primitives: &'a [u32],
    /// Ranges of the above.
    pub geometries: &'a [Geometry],
    /// Placed geometries; number 0 is the world.
    pub instances: &'a [Instance],
}

/// What a traversal in the space of one instance needs besides the ray there: whose primitives these are.
#[derive(Clone, Copy)]
pub(crate) struct Placement<'a> {
    /// Number of the instance.
    pub(crate) instance: u32,
    /// The ray in the world.
    pub(crate) world_ray: &'a Ray,
}

impl<'a> Placement<'a> {
    #[inline(always)]
    pub(crate) fn world(world_ray: &'a Ray) -> Placement<'a> {
        Placement { instance: 0, world_ray }
    }

    /// A primitive of the instance.
    #[inline(always)]
    fn place(&self, primitive: u32) -> PrimitiveSlot {
        PrimitiveSlot { instance: self.instance, primitive }
    }
}

impl PrimitivesView<'_> {
    /// Searches triangles `first .. first + count` of the array; `true` ends the search.
    #[inline(always)]
    pub(crate) fn search_triangles<S: Search>(
        &self,
        first: u32,
        count: u32,
        ray: &LocalRay,
        placement: &Placement,
        filter: &RayFilter,
        search: &mut S,
    ) -> bool {
        let mut k = first;
        while k < first + count {
            let number = k;
            k += 1;
            let triangle = trusted(self.triangles, number);
            let step = triangle.first_step(ray);
            if !step.may_meet {
                continue;
            }
            let meeting = step.meeting(ray);
            let id = PrimitiveId { instance: placement.instance, primitive: triangle.primitive };
            let is_left_out = (filter.cull_back_faces & !step.meets_front) | filter.skips(id);
            if meeting.is_beyond(ray.t_min, search.t_max()) | is_left_out {
                continue;
            }
            let place = placement.place(number);
            let mut offered = OfferOutcome::Unclear;
            if meeting.is_certain {
                offered = search.offer_certain(place, meeting.t - meeting.error, meeting.t + meeting.error);
            }
            if offered == OfferOutcome::Ends
                || offered == OfferOutcome::Unclear && search.unclear(self, place, id, placement)
            {
                return true;
            }
        }
        false
    }

    /// The whole test of a triangle by the ray that is this one in the world.
    #[inline(always)]
    pub(crate) fn exact_triangle(&self, place: PrimitiveSlot, world_ray: &Ray) -> TriangleHit {
        let (map, extent) = self.space(place.instance);
        intersect_triangle(trusted(self.triangles, place.primitive), world_ray, map, extent)
    }

    /// What the `t` of a triangle's hit lacks of that of double precision.
    #[inline(always)]
    pub(crate) fn rest(&self, place: PrimitiveSlot, t: f32, world_ray: &Ray) -> f32 {
        let (map, _) = self.space(place.instance);
        t_rest(trusted(self.triangles, place.primitive), t, world_ray, map)
    }

    /// The `t` of a hit in double precision.
    #[inline(always)]
    pub(crate) fn t64(&self, place: PrimitiveSlot, hit: &TriangleHit, world_ray: &Ray) -> f64 {
        let rest = if hit.t_rest == UNKNOWN_REST { self.rest(place, hit.t, world_ray) } else { hit.t_rest };
        hit.t as f64 + rest as f64
    }

    /// What the `t` of a triangle's hit by this ray lacks of that of double precision, by the triangle's name. Looks at all there
    /// are: hardly ever asked for.
    pub(crate) fn rest_by_name(&self, hit: &Hit, world_ray: &Ray) -> f32 {
        let id = hit.id;
        if id.instance as usize >= self.instances.len() {
            return 0.0;
        }
        let (map, extent) = self.space(id.instance);
        rest_among(self.triangles, hit, world_ray, map, extent)
    }

    /// For the world boxes of instances. (These have slack of their own: no extent is needed.)
    #[inline(always)]
    pub(crate) fn world_slab(&self, world_ray: &Ray) -> Slab {
        Slab::new(world_ray.origin, world_ray.direction, 0.0)
    }

    /// How rays come into an instance's space, if not as they are, and the extent of what is there.
    #[inline(always)]
    pub(crate) fn space(&self, instance: u32) -> (Option<&Affine>, f32) {
        if instance == 0 {
            return (None, trusted(self.geometries, 0).extent);
        }
        let instance = trusted(self.instances, instance);
        (Some(&instance.object_from_world), trusted(self.geometries, instance.geometry).extent)
    }

    /// The same by the whole test of every triangle: the reference.
    #[inline(always)]
    pub(crate) fn test_triangles(
        &self,
        first: u32,
        count: u32,
        ray: &LocalRay,
        placement: &Placement,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        let mut k = first;
        while k < first + count {
            let triangle = trusted(self.triangles, k);
            let id = PrimitiveId { instance: placement.instance, primitive: triangle.primitive };
            let step = triangle.first_step(ray);
            // Rays meet the triangle that they start on, and the one that they go to, more often than any other.
            let is_left_out = (filter.cull_back_faces & !step.meets_front) | filter.skips(id);
            if step.may_meet && !is_left_out && search.unclear(self, placement.place(k), id, placement) {
                return true;
            }
            k += 1;
        }
        false
    }

    /// Tests spheres `first .. first + count` of the array; `true` ends the search.
    #[inline(always)]
    pub(crate) fn search_spheres(
        &self,
        first: u32,
        count: u32,
        ray: &LocalRay,
        placement: &Placement,
        search: &mut impl Search,
    ) -> bool {
        let mut k = first;
        while k < first + count {
            let id =
                PrimitiveId { instance: placement.instance, primitive: *trusted(self.sphere_primitives, k) };
            if may_meet_sphere(ray, trusted(self.spheres, k))
                && search.unclear(self, placement.place(k | SPHERE_REFERENCE), id, placement)
            {
                return true;
            }
            k += 1;
        }
        false
    }

    /// Computes the hits of a primitive, and offers them; `true` ends the search.
    #[inline(always)]
    pub(crate) fn decide(
        &self,
        place: PrimitiveSlot,
        id: PrimitiveId,
        placement: &Placement,
        search: &mut impl Search,
    ) -> bool {
        let ray = placement.world_ray;
        if place.primitive & SPHERE_REFERENCE == 0 {
            let hit = self.exact_triangle(place, ray);
            return hit.meets && search.offer(self, ray, place, id, &hit);
        }
        let (map, _) = self.space(place.instance);
        let [first, second] =
            intersect_sphere(trusted(self.spheres, place.primitive & !SPHERE_REFERENCE), ray, map);
        let mut root = 0;
        while root < 2 {
            let crossing = if root == 0 { first } else { second };
            // Roots that are not hits are NaN.
            if !crossing.t.is_nan() {
                let hit = TriangleHit::of_sphere(&crossing);
                if search.offer(self, ray, place, id, &hit) {
                    return true;
                }
            }
            root += 1;
        }
        false
    }

    /// The ray in an instance's space, or `None` where it misses the instance's box between `t_min` and `t_max`, as this slab
    /// measures.
    #[inline(always)]
    pub(crate) fn enter_instance<'r>(
        &self,
        number: u32,
        ray: &'r Ray,
        slab: &Slab,
        [t_min, t_max]: [f32; 2],
    ) -> Option<(Placement<'r>, LocalRay)> {
        let instance = trusted(self.instances, number);
        let (near, far) = slab.interval(&instance.world_bounds, t_min);
        if !Slab::passes(near, far, t_max) {
            return None;
        }
        let extent = trusted(self.geometries, instance.geometry).extent;
        let local = LocalRay::of(ray, Some(&instance.object_from_world), extent);
        Some((Placement { instance: number, world_ray: ray }, local))
    }
}

out_of_line! {
    /// [`PrimitivesView::rest_by_name`].
    fn rest_among(
        triangles: &[PackedTriangle],
        hit: &Hit,
        ray: &Ray,
        map: Option<&Affine>,
        extent: f32,
    ) -> f32 {
        let mut k = 0;
        while k < triangles.len() as u32 {
            let triangle = trusted(triangles, k);
            if triangle.primitive == hit.id.primitive {
                // Triangles of other geometries have this number, too.
                let own = intersect_triangle(triangle, ray, map, extent);
                if own.meets && own.t == hit.t && own.u == hit.u && own.v == hit.v {
                    return t_rest(triangle, hit.t, ray, map);
                }
            }
            k += 1;
        }
        0.0
    }
}

/// An item of a hierarchy's array, by an index that the same hierarchy holds. It is not checked: traversals are reached through
/// tracers alone, and who makes a tracer promises the invariant.
#[inline(always)]
pub(crate) fn trusted<T>(items: &[T], index: u32) -> &T {
    debug_assert!((index as usize) < items.len());
    // SAFETY: closed view, promised to the tracer's `new` (debug builds check it).
    unsafe { items.get_unchecked(index as usize) }
}
