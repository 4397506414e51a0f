//! From a primitive that a traversal has reached to a hit that counts.

use super::SPHERE_REFERENCE;
use super::search::{Offered, Place, Search};
use crate::geometry::{Geometry, Instance, Sphere};
use crate::intersect::{
    Confirmed, LocalRay, PackedTriangle, Slab, decide_sphere, decide_triangle, intersect_triangle_unless,
};
use crate::math::Affine;
use crate::ray::{PrimitiveId, Ray, RayFilter};

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

/// What a traversal in the space of one instance needs besides the ray there: whose primitives these are, and when hits
/// count.
#[derive(Clone, Copy)]
pub(super) struct Placement<'a> {
    /// Number of the instance.
    pub(super) instance: u32,
    /// Where the world ray is inside the instance's world box; all of it for the world itself.
    pub(super) world_interval: (f32, f32),
    /// The ray in the world.
    pub(super) world_ray: &'a Ray,
}

impl<'a> Placement<'a> {
    #[inline(always)]
    pub(super) fn world(world_ray: &'a Ray) -> Placement<'a> {
        Placement { instance: 0, world_interval: (f32::NEG_INFINITY, f32::INFINITY), world_ray }
    }

    /// A primitive of the instance.
    #[inline(always)]
    fn place(&self, primitive: u32) -> Place {
        Place { instance: self.instance, primitive }
    }
}

impl PrimitivesView<'_> {
    /// Searches triangles `first .. first + count` of the array; `true` ends the search. A hit may be left pending.
    #[inline(always)]
    pub(super) fn search_triangles(
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
            let number = k;
            k += 1;
            let triangle = item(self.triangles, number);
            let look = triangle.first_look(ray);
            if !look.may_meet {
                continue;
            }
            let meeting = look.meeting(triangle, ray);
            // NaN is neither: it says nothing.
            let too_far = (meeting.low > search.t_max()) | (meeting.high < ray.t_min);
            let id = PrimitiveId { instance: placement.instance, primitive: triangle.primitive };
            let is_left_out = (filter.cull_back_faces & !look.meets_front) | filter.skips(id);
            if (meeting.is_steep & too_far) | is_left_out {
                continue;
            }
            let (near, _) = placement.world_interval;
            let place = placement.place(number);
            let mut offered = Offered::Unclear;
            if meeting.is_certain & (meeting.low > ray.t_min) & (meeting.low >= near) {
                offered = search.offer_certain(place, meeting.low, meeting.high);
            }
            if offered == Offered::Ends
                || offered == Offered::Unclear && search.unclear(self, place, id, placement)
            {
                return true;
            }
        }
        false
    }

    /// The whole test of a triangle by the ray that is this one in the world.
    #[inline(always)]
    pub(super) fn exact_triangle(&self, place: Place, world_ray: &Ray) -> Confirmed {
        let (map, extent) = self.space(place.instance);
        decide_triangle(item(self.triangles, place.primitive), world_ray, map, extent)
    }

    /// What [`PrimitivesView::enter_instance`] says of an instance that is entered.
    #[inline(always)]
    pub(super) fn placement<'r>(&self, instance: u32, world_ray: &'r Ray) -> Placement<'r> {
        if instance == 0 {
            return Placement::world(world_ray);
        }
        let slab = Slab::new(world_ray.origin, world_ray.direction);
        let world_interval = slab.interval(&item(self.instances, instance).world_bounds, world_ray.t_min);
        Placement { instance, world_interval, world_ray }
    }

    /// The same where it is certain that they meet: mostly that needs no double precision.
    #[inline(always)]
    pub(super) fn confirmed_triangle(&self, place: Place, world_ray: &Ray) -> Confirmed {
        let (map, extent) = self.space(place.instance);
        let triangle = item(self.triangles, place.primitive);
        let local = LocalRay::of(world_ray, map, extent);
        let normal = triangle.normal();
        let edges = triangle.test_edges(&local, normal, false);
        let hit = triangle.confirm(&local, normal, edges.determinant);
        if edges.clear & hit.meets { hit } else { decide_triangle(triangle, world_ray, map, extent) }
    }

    /// How rays come into an instance's space, if not as they are, and the extent of what is there.
    #[inline(always)]
    fn space(&self, instance: u32) -> (Option<&Affine>, f32) {
        if instance == 0 {
            return (None, item(self.geometries, 0).extent);
        }
        let instance = item(self.instances, instance);
        (Some(&instance.object_from_world), item(self.geometries, instance.geometry).extent)
    }

    /// The same by the whole test of every triangle: the reference.
    #[inline(always)]
    pub(super) fn test_triangles(
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
            let triangle = item(self.triangles, k);
            let id = PrimitiveId { instance: placement.instance, primitive: triangle.primitive };
            // Rays meet the triangle that they start on, and the one that they go to, more often than any other.
            let skips = || filter.skips(id);
            if let Some((t, _, _)) = intersect_triangle_unless(ray, triangle, filter.cull_back_faces, skips) {
                let (near, far) = placement.world_interval;
                if Slab::passes(near, far, t)
                    && search.offer(self, placement.world_ray, placement.place(k), id, t)
                {
                    return true;
                }
            }
            k += 1;
        }
        false
    }

    /// Tests spheres `first .. first + count` of the array; `true` ends the search.
    #[inline(always)]
    pub(super) fn search_spheres(
        &self,
        first: u32,
        count: u32,
        placement: &Placement,
        search: &mut impl Search,
    ) -> bool {
        let mut k = first;
        while k < first + count {
            let id =
                PrimitiveId { instance: placement.instance, primitive: *item(self.sphere_primitives, k) };
            if search.unclear(self, placement.place(k | SPHERE_REFERENCE), id, placement) {
                return true;
            }
            k += 1;
        }
        false
    }

    /// Computes the hits of a primitive, and offers them; `true` ends the search.
    #[inline(always)]
    pub(super) fn decide(
        &self,
        place: Place,
        id: PrimitiveId,
        placement: &Placement,
        search: &mut impl Search,
    ) -> bool {
        let ray = placement.world_ray;
        let (near, far) = placement.world_interval;
        if place.primitive & SPHERE_REFERENCE == 0 {
            let hit = self.exact_triangle(place, ray);
            return hit.meets & Slab::passes(near, far, hit.t) && search.offer(self, ray, place, id, hit.t);
        }
        let (map, extent) = self.space(place.instance);
        let [t0, t1] =
            decide_sphere(item(self.spheres, place.primitive & !SPHERE_REFERENCE), ray, map, extent);
        let mut root = 0;
        while root < 2 {
            let t = if root == 0 { t0 } else { t1 };
            // Roots that are not hits are NaN.
            if !t.is_nan() & Slab::passes(near, far, t) && search.offer(self, ray, place, id, t) {
                return true;
            }
            root += 1;
        }
        false
    }

    /// The ray in an instance's space, or `None` where it misses the instance's box before `t_max`.
    #[inline(always)]
    pub(super) fn enter_instance<'r>(
        &self,
        number: u32,
        ray: &'r Ray,
        slab: &Slab,
        t_max: f32,
    ) -> Option<(Placement<'r>, LocalRay)> {
        let instance = item(self.instances, number);
        let (near, far) = slab.interval(&instance.world_bounds, ray.t_min);
        if !Slab::passes(near, far, t_max) {
            return None;
        }
        let extent = item(self.geometries, instance.geometry).extent;
        let local = LocalRay::of(ray, Some(&instance.object_from_world), extent);
        Some((Placement { instance: number, world_interval: (near, far), world_ray: ray }, local))
    }
}

/// An item of an array by an index that comes from the scene's own arrays, which builders keep in range.
#[inline(always)]
pub(crate) fn item<T>(items: &[T], index: u32) -> &T {
    debug_assert!((index as usize) < items.len());
    // SAFETY: indices come from SceneData and the hierarchy builders, which make them in range (checked in debug
    // builds, which run the same code).
    unsafe { items.get_unchecked(index as usize) }
}
