//! No hierarchy: every primitive is tested. The reference for all others.

use super::candidates::{Placement, PrimitivesView, trusted};
use super::search::Search;
use super::two_level::{SearchScene, answer_queries};
use super::{Tracer, Work};
use crate::intersect::LocalRay;
use crate::ray::{Hit, Ray, RayFilter};

/// Tests every primitive of every instance.
#[derive(Clone, Copy, Debug)]
pub struct ExhaustiveTracer<'a, C> {
    /// Primitives and instances.
    primitives: PrimitivesView<'a>,
    /// Told what is done.
    pub work: C,
}

impl<'a, C: Work> ExhaustiveTracer<'a, C> {
    /// Over trees whose numbers hold together.
    ///
    /// # Safety
    /// The view is [closed](crate::hierarchy#closed-views).
    #[inline(always)]
    pub unsafe fn new(primitives: PrimitivesView<'a>, work: C) -> Self {
        ExhaustiveTracer { primitives, work }
    }
}

impl<C: Work> SearchScene for ExhaustiveTracer<'_, C> {
    #[inline(always)]
    fn primitives(&self) -> &PrimitivesView<'_> {
        &self.primitives
    }

    #[inline(always)]
    fn search_geometry(
        &self,
        geometry: u32,
        ray: &LocalRay,
        placement: &Placement<'_>,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        let g = trusted(self.primitives.geometries, geometry);
        self.work.primitives(g.triangle_count + g.sphere_count);
        self.primitives.test_triangles(g.first_triangle, g.triangle_count, ray, placement, filter, search)
            || self.primitives.search_spheres(g.first_sphere, g.sphere_count, ray, placement, search)
    }

    #[inline(always)]
    fn search_instances(
        &self,
        world_ray: Option<&LocalRay>,
        ray: &Ray,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        let slab = self.primitives.world_slab(ray);
        let goes_on = world_ray.is_none_or(|world_ray| self.goes_on(world_ray));
        let end = if goes_on { self.primitives.instances.len() as u32 } else { 1 };
        let mut number = world_ray.is_none() as u32;
        while number < end {
            self.work.nodes((number > 0) as u32);
            if self.search_instance(number, world_ray, ray, &slab, filter, search) {
                return true;
            }
            number += 1;
        }
        false
    }
}

answer_queries!(ExhaustiveTracer);
