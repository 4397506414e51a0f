//! No hierarchy: every primitive is tested. The reference for all others.

use super::candidates::{Any, Closest, Next, Placement, PrimitivesView, Search, item};
use super::{Tracer, Work};
use crate::intersect::{LocalRay, Slab};
use crate::ray::{Hit, Ray, RayFilter};

/// Tests every primitive of every instance.
#[derive(Clone, Copy, Debug)]
pub struct ExhaustiveTracer<'a, C> {
    /// Primitives and instances.
    pub primitives: PrimitivesView<'a>,
    /// Told what is done.
    pub work: C,
}

impl<C: Work> ExhaustiveTracer<'_, C> {
    #[inline(always)]
    fn search(&self, ray: &Ray, filter: &RayFilter, search: &mut impl Search) {
        let world_extent = item(self.primitives.geometries, 0).extent;
        let world_ray = LocalRay::new(ray.origin, ray.direction, ray.t_min, world_extent);
        if self.search_geometry(0, &world_ray, &Placement::WORLD, filter, search) {
            return;
        }
        let slab = Slab::new(ray.origin, ray.direction);
        let mut number = 1;
        while number < self.primitives.instances.len() as u32 {
            self.work.nodes(1);
            if let Some((placement, local)) =
                self.primitives.enter_instance(number, ray, &slab, search.t_max())
            {
                let geometry = item(self.primitives.instances, number).geometry;
                if self.search_geometry(geometry, &local, &placement, filter, search) {
                    return;
                }
            }
            number += 1;
        }
    }

    #[inline(always)]
    fn search_geometry(
        &self,
        geometry: u32,
        ray: &LocalRay,
        placement: &Placement,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        let g = item(self.primitives.geometries, geometry);
        self.work.primitives(g.triangle_count + g.sphere_count);
        self.primitives.search_triangles(g.first_triangle, g.triangle_count, ray, placement, filter, search)
            || self.primitives.search_spheres(g.first_sphere, g.sphere_count, ray, placement, search)
    }
}

impl<C: Work> Tracer for ExhaustiveTracer<'_, C> {
    #[inline(always)]
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        let mut search = Closest { best: Hit::miss(ray.t_max) };
        self.search(ray, filter, &mut search);
        search.best
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        let mut search = Any { t_max: ray.t_max, found: false };
        self.search(ray, filter, &mut search);
        search.found
    }

    #[inline(always)]
    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        let mut search = Next { after: *after, best: Hit::miss(ray.t_max) };
        self.search(ray, filter, &mut search);
        search.best
    }
}
