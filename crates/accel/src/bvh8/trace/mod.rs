//! Traversals of the 8-wide hierarchy: one ray at a time and packets of 16; for each instruction set.
//!
//! # Invariants
//!
//! Unsafe code here, in [`crate::simd`] and in the builders rests on these; each SAFETY comment names those that it uses.
//!
//! - **Instruction set**: code for an instruction set runs only below [`run_at`], with a level that the CPU has: tracers are made
//!   for no other, and builders ask first. A kernel that runs another one does so for its own set.
//! - **Closed view**: numbers of nodes, children, blocks, spheres, geometries and instances are numbers of items, and no path is
//!   longer than [`found::STACK`] allows. [`Bvh8`] keeps its fields private, and its builders make them so.
//! - **Stack room**: places of a stack below its count have been written, and those above it have room for whole vectors.
//! - **Lanes**: a vector is as many numbers of 32 bits as it has lanes, one after the other, and a lane is below their count.
//! - **Whole batch**: there are as many filters and answers as rays ([`Batch::new`] checks), and numbers of rays are below that.
//! - **One origin**: what was made for rays of one origin, or for others, is read by code for such rays alone.
//! - **Written places**: memory that may not have been written is read only where it has been.

mod batch;
mod choice;
mod filtered;
mod found;
mod lanes;
mod masked;
mod one_point;
mod packet;
mod single;
mod single_leaf;
mod single_ray;
mod sort;
mod stream;
mod triangle_search;

pub use masked::MaskedTracer;

use super::Bvh8;
use super::view::Bvh8View;
use crate::packed::check_instances;
use crate::simd::{Kernel, Simd, run_at};
use crate::{BatchTracer, Coherence, Filters, SimdLevel};
use batch::Batch;
use eosphor_core::hierarchy::{IgnoreWork, ShadowBatch, Tracer, Work};
use eosphor_core::ray::{Hit, Ray, RayFilter};
use found::{ANY, CLOSEST, Found, NEXT, Query};
use one_point::FromOnePoint;

/// Traces rays through a [`Bvh8`], one at a time ([`Tracer`]) and many ([`BatchTracer`]). Made by [`Bvh8::tracer`].
#[derive(Clone, Copy, Debug)]
pub struct Bvh8Tracer<'a> {
    bvh: Bvh8View<'a>,
    level: SimdLevel,
}

impl Bvh8 {
    /// The traversal at the best SIMD level that is available ([`SimdLevel::best`]).
    ///
    /// # Panics
    /// Where it was built over instances alone: such a hierarchy is the top level of another
    /// ([`Bvh8Tracer::with_instances_of`]).
    pub fn tracer(&self) -> Bvh8Tracer<'_> {
        check_instances(self.named_geometries, self.geometries.len());
        Bvh8Tracer { bvh: self.view(), level: SimdLevel::best() }
    }

    /// The traversal at a SIMD level; `None` where it is not available ([`SimdLevel::is_available`]).
    ///
    /// # Panics
    /// Where it was built over instances alone: such a hierarchy is the top level of another
    /// ([`Bvh8Tracer::with_instances_of`]).
    pub fn tracer_at(&self, level: SimdLevel) -> Option<Bvh8Tracer<'_>> {
        check_instances(self.named_geometries, self.geometries.len());
        level.is_available().then_some(Bvh8Tracer { bvh: self.view(), level })
    }
}

/// One ray through the whole scene.
struct OneRay<'a, W, const QUERY: Query> {
    bvh: &'a Bvh8View<'a>,
    ray: &'a Ray,
    filter: &'a RayFilter,
    work: W,
    found: &'a mut Found,
}

impl<W: Work + Copy, const QUERY: Query> Kernel for OneRay<'_, W, QUERY> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Simd>(self) {
        // SAFETY: instruction set: a kernel is run below its own.
        unsafe { single::trace::<S, W, QUERY>(self.bvh, self.ray, self.filter, self.work, self.found) };
    }
}

impl<'a> Bvh8Tracer<'a> {
    /// The traversal with the instances of another hierarchy, `top`, in place of the own ones: they have been moved. That one may
    /// have been built over the instances alone ([`SceneGeometry::of_instances`](crate::SceneGeometry::of_instances)).
    ///
    /// # Panics
    /// Where an instance is of a geometry that this hierarchy does not have.
    pub fn with_instances_of(self, top: &'a Bvh8) -> Bvh8Tracer<'a> {
        check_instances(top.named_geometries, self.bvh.geometries.len());
        let Bvh8View { instance_nodes, instance_root, instances, instance_bounds, .. } = top.view();
        Bvh8Tracer {
            bvh: Bvh8View { instance_nodes, instance_root, instances, instance_bounds, ..self.bvh },
            ..self
        }
    }

    #[inline(always)]
    fn one<const QUERY: Query>(&self, ray: &Ray, filter: &RayFilter, found: &mut Found) {
        self.one_told::<_, QUERY>(ray, filter, IgnoreWork, found);
    }

    #[inline(always)]
    fn one_told<W: Work + Copy, const QUERY: Query>(
        &self,
        ray: &Ray,
        filter: &RayFilter,
        work: W,
        found: &mut Found,
    ) {
        // SAFETY: instruction set: tracers are made for levels that the CPU has.
        unsafe { run_at(self.level, OneRay::<W, QUERY> { bvh: &self.bvh, ray, filter, work, found }) }
    }

    fn batch<const QUERY: Query>(&self, batch: Batch<QUERY>) {
        // SAFETY: instruction set: tracers are made for levels that the CPU has.
        unsafe { run_at(self.level, batch) };
    }
}

impl Tracer for Bvh8Tracer<'_> {
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        let mut found = Found::nothing(ray.t_max);
        self.one::<CLOSEST>(ray, filter, &mut found);
        found.best
    }

    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        let mut found = Found::nothing(ray.t_max);
        self.one::<ANY>(ray, filter, &mut found);
        found.any
    }

    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        let mut found = Found { after: Some(*after), ..Found::nothing(ray.t_max) };
        self.one::<NEXT>(ray, filter, &mut found);
        found.best
    }

    fn occluded_batch<const W: usize>(
        &self,
        batch: &ShadowBatch<W>,
        filter: &RayFilter,
        active: &[bool; W],
    ) -> [bool; W] {
        // Packets of two registers gain nothing from walking together here: with AVX2 a picture of lamps took no less time.
        if W > 16 && (W > 64 || self.level != SimdLevel::Avx512) {
            return self.occluded_by_sixteens(batch, filter, active);
        }
        let bvh = &self.bvh;
        // SAFETY: instruction set: tracers are made for levels that the CPU has.
        unsafe {
            if W <= 16 {
                run_at(self.level, FromOnePoint::<W, 1> { bvh, batch, filter, active })
            } else if W <= 48 {
                run_at(self.level, FromOnePoint::<W, 3> { bvh, batch, filter, active })
            } else {
                run_at(self.level, FromOnePoint::<W, 4> { bvh, batch, filter, active })
            }
        }
    }
}

/// Traces single rays through a [`Bvh8`] and counts: eight boxes for each node visited, and the triangles of each block.
#[derive(Clone, Copy, Debug)]
pub struct Bvh8CountingTracer<'a, C> {
    tracer: Bvh8Tracer<'a>,
    /// Who is told what the traversal does.
    pub work: C,
}

impl Bvh8 {
    /// The traversal that tells `work` what it does, at the best SIMD level that is available.
    ///
    /// # Panics
    /// Where it was built over instances alone: such a hierarchy is the top level of another
    /// ([`Bvh8Tracer::with_instances_of`]).
    pub fn counting_tracer<C: Work>(&self, work: C) -> Bvh8CountingTracer<'_, C> {
        Bvh8CountingTracer { tracer: self.tracer(), work }
    }
}

impl<'a, C: Work> Bvh8CountingTracer<'a, C> {
    /// The traversal with the instances of another hierarchy, `top`, in place of the own ones: they have been moved. That one may
    /// have been built over the instances alone ([`SceneGeometry::of_instances`](crate::SceneGeometry::of_instances)).
    ///
    /// # Panics
    /// Where an instance is of a geometry that this hierarchy does not have.
    pub fn with_instances_of(self, top: &'a Bvh8) -> Bvh8CountingTracer<'a, C> {
        Bvh8CountingTracer { tracer: self.tracer.with_instances_of(top), ..self }
    }

    fn one<const QUERY: Query>(&self, ray: &Ray, filter: &RayFilter, mut found: Found) -> Found {
        self.tracer.one_told::<_, QUERY>(ray, filter, To(&self.work), &mut found);
        found
    }
}

/// Tells somebody else.
struct To<'a, C>(&'a C);

impl<C> Clone for To<'_, C> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<C> Copy for To<'_, C> {}

impl<C: Work> Work for To<'_, C> {
    #[inline(always)]
    fn nodes(&self, count: u32) {
        self.0.nodes(count);
    }
    #[inline(always)]
    fn primitives(&self, count: u32) {
        self.0.primitives(count);
    }
}

impl<C: Work> Tracer for Bvh8CountingTracer<'_, C> {
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        self.one::<CLOSEST>(ray, filter, Found::nothing(ray.t_max)).best
    }

    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        self.one::<ANY>(ray, filter, Found::nothing(ray.t_max)).any
    }

    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        let found = Found { after: Some(*after), ..Found::nothing(ray.t_max) };
        self.one::<NEXT>(ray, filter, found).best
    }
}

impl BatchTracer for Bvh8Tracer<'_> {
    fn closest_hits(&self, rays: &[Ray], filters: Filters, coherence: Coherence, hits: &mut [Hit]) {
        self.batch(Batch::<CLOSEST>::new(&self.bvh, rays, filters, coherence, hits, &mut []));
    }

    fn occluded_rays(&self, rays: &[Ray], filters: Filters, coherence: Coherence, hidden: &mut [bool]) {
        self.batch(Batch::<ANY>::new(&self.bvh, rays, filters, coherence, &mut [], hidden));
    }

    fn next_hits(&self, rays: &[Ray], filters: Filters, coherence: Coherence, hits: &mut [Hit]) {
        self.batch(Batch::<NEXT>::new(&self.bvh, rays, filters, coherence, hits, &mut []));
    }
}
