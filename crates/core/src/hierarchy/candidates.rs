//! From a primitive that a traversal has reached to a hit that counts.

use crate::geometry::{Geometry, Instance, Sphere};
use crate::intersect::{
    LocalRay, PackedTriangle, Slab, decide_triangle, intersect_sphere, intersect_triangle_unless,
};
use crate::material::NONE;
use crate::ray::{Hit, PrimitiveId, Ray, RayFilter};

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

/// What a traversal in the space of one instance needs besides the ray: whose primitives these are, and when hits
/// count there.
#[derive(Clone, Copy)]
pub(super) struct Placement {
    /// Number of the instance.
    pub(super) instance: u32,
    /// Where the world ray is inside the instance's world box; all of it for the world itself.
    pub(super) world_interval: (f32, f32),
}

impl Placement {
    pub(super) const WORLD: Placement =
        Placement { instance: 0, world_interval: (f32::NEG_INFINITY, f32::INFINITY) };
}

/// What is looked for, and what was found so far.
pub(super) trait Search {
    /// Hits beyond this cannot matter any more.
    fn t_max(&self) -> f32;
    /// Offers a hit that counts; `true` ends the search.
    fn offer(&mut self, hit: Hit) -> bool;
    /// Offers a hit of a triangle, by its place in the array, that counts for certain, with bounds of its `t`.
    fn offer_pending(&mut self, place: u32, id: PrimitiveId, low: f32, high: f32) -> Offered;
    /// Whether the best hit so far is one of this primitive, and others do not matter.
    fn has(&self, id: PrimitiveId) -> bool;
    /// Computes what is pending, in the space in which it was offered.
    fn settle(&mut self, primitives: &PrimitivesView, ray: &LocalRay);
}

/// What became of a hit that was offered.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Offered {
    /// It has to be computed to tell.
    Unclear,
    /// Taken.
    Taken,
    /// It ends the search.
    Ends,
}

/// The nearest hit.
///
/// Most hits are certain long before they are computed: the ray passes so far within the edges that rounding cannot have
/// brought it there, and nothing that was met before is near. Such a hit is left pending, with bounds of its `t`, until
/// the search is over or something comes close.
pub(super) struct Closest {
    /// While a hit is pending, only its primitive is known.
    pub(super) best: Hit,
    /// No earlier than the best hit.
    end: f32,
    /// A hit before this is nearer than the best one.
    before: f32,
    /// Place of the triangle whose hit is pending, or [`NONE`].
    pending: u32,
}

impl Closest {
    #[inline(always)]
    pub(super) fn new(t_max: f32) -> Closest {
        Closest { best: Hit::miss(t_max), end: t_max, before: t_max, pending: NONE }
    }

    #[inline(always)]
    fn set(&mut self, hit: Hit) {
        (self.best, self.end, self.before, self.pending) = (hit, hit.t, hit.t, NONE);
    }
}

impl Search for Closest {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.end
    }
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> bool {
        debug_assert!(self.pending == NONE);
        if hit.before(&self.best) {
            self.set(hit);
        }
        false
    }
    #[inline(always)]
    fn offer_pending(&mut self, place: u32, id: PrimitiveId, low: f32, high: f32) -> Offered {
        if high < self.before {
            (self.pending, self.best.id, self.before, self.end) = (place, id, low, high);
            return Offered::Taken;
        }
        Offered::Unclear
    }
    #[inline(always)]
    fn has(&self, id: PrimitiveId) -> bool {
        self.best.id == id
    }
    #[inline(always)]
    fn settle(&mut self, primitives: &PrimitivesView, ray: &LocalRay) {
        if self.pending == NONE {
            return;
        }
        let triangle = item(primitives.triangles, self.pending);
        let normal = triangle.normal();
        let mut hit = triangle.confirm(ray, normal, normal.dot(ray.direction));
        if !hit.meets {
            let ray = *ray;
            hit = decide_triangle(triangle, &ray);
        }
        debug_assert!(hit.counts(ray) & (self.before <= hit.t) & (hit.t <= self.end), "{triangle:?} {ray:?}");
        self.set(Hit { t: hit.t, u: hit.u, v: hit.v, id: self.best.id });
    }
}

/// Any hit.
pub(super) struct Any {
    pub(super) t_max: f32,
    pub(super) found: bool,
}

impl Search for Any {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> bool {
        self.found |= hit.t <= self.t_max;
        self.found
    }
    #[inline(always)]
    fn offer_pending(&mut self, _: u32, _: PrimitiveId, _: f32, high: f32) -> Offered {
        self.found |= high <= self.t_max;
        if self.found { Offered::Ends } else { Offered::Unclear }
    }
    #[inline(always)]
    fn has(&self, _: PrimitiveId) -> bool {
        false
    }
    #[inline(always)]
    fn settle(&mut self, _: &PrimitivesView, _: &LocalRay) {}
}

/// The nearest hit after another one.
pub(super) struct Next {
    pub(super) after: Hit,
    pub(super) best: Hit,
}

impl Search for Next {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.best.t
    }
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> bool {
        if self.after.before(&hit) & hit.before(&self.best) {
            self.best = hit;
        }
        false
    }
    #[inline(always)]
    fn offer_pending(&mut self, _: u32, _: PrimitiveId, _: f32, _: f32) -> Offered {
        Offered::Unclear
    }
    #[inline(always)]
    fn has(&self, _: PrimitiveId) -> bool {
        false
    }
    #[inline(always)]
    fn settle(&mut self, _: &PrimitivesView, _: &LocalRay) {}
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
            let place = k;
            k += 1;
            let triangle = item(self.triangles, place);
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
            let mut offered = Offered::Unclear;
            if meeting.is_certain & (meeting.low > ray.t_min) & (meeting.low >= near) {
                offered = search.offer_pending(place, id, meeting.low, meeting.high);
            }
            if offered == Offered::Ends {
                return true;
            }
            // What has been cut is met again.
            if offered == Offered::Unclear && !search.has(id) {
                search.settle(self, ray);
                let copy = *ray;
                let hit = decide_triangle(triangle, &copy);
                let (near, far) = placement.world_interval;
                let hit_counts = hit.counts(ray) & Slab::passes(near, far, hit.t);
                if hit_counts && search.offer(Hit { t: hit.t, u: hit.u, v: hit.v, id }) {
                    return true;
                }
            }
        }
        false
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
            if let Some((t, u, v)) = intersect_triangle_unless(ray, triangle, filter.cull_back_faces, skips) {
                let (near, far) = placement.world_interval;
                if Slab::passes(near, far, t) && search.offer(Hit { t, u, v, id }) {
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
        ray: &LocalRay,
        placement: &Placement,
        search: &mut impl Search,
    ) -> bool {
        search.settle(self, ray);
        let mut k = first;
        while k < first + count {
            let id =
                PrimitiveId { instance: placement.instance, primitive: *item(self.sphere_primitives, k) };
            let (near, far) = placement.world_interval;
            let [t0, t1] = intersect_sphere(ray, item(self.spheres, k));
            let mut root = 0;
            while root < 2 {
                let t = if root == 0 { t0 } else { t1 };
                // Roots that are not hits are NaN.
                let counts = !t.is_nan() & Slab::passes(near, far, t);
                if counts && search.offer(Hit { t, u: 0.0, v: 0.0, id }) {
                    return true;
                }
                root += 1;
            }
            k += 1;
        }
        false
    }

    /// The ray in an instance's space, or `None` where it misses the instance's box before `t_max`.
    #[inline(always)]
    pub(super) fn enter_instance(
        &self,
        number: u32,
        ray: &Ray,
        slab: &Slab,
        t_max: f32,
    ) -> Option<(Placement, LocalRay)> {
        let instance = item(self.instances, number);
        let (near, far) = slab.interval(&instance.world_bounds, ray.t_min);
        if !Slab::passes(near, far, t_max) {
            return None;
        }
        let map = &instance.object_from_world;
        let extent = item(self.geometries, instance.geometry).extent;
        let local = LocalRay::new(map.point(ray.origin), map.direction(ray.direction), ray.t_min, extent);
        Some((Placement { instance: number, world_interval: (near, far) }, local))
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
