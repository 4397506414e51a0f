//! From a primitive that a traversal has reached to a hit that counts.

use crate::geometry::{Geometry, Instance, Sphere};
use crate::intersect::{LocalRay, PackedTriangle, Slab, intersect_sphere, intersect_triangle_unless};
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
}

/// The nearest hit.
pub(super) struct Closest {
    pub(super) best: Hit,
}

impl Search for Closest {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.best.t
    }
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> bool {
        if hit.before(&self.best) {
            self.best = hit;
        }
        false
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
}

impl PrimitivesView<'_> {
    /// Tests triangles `first .. first + count` of the array; `true` ends the search.
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
