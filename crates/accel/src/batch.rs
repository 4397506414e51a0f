//! Queries for many rays at a time.

use eosphor_core::hierarchy::{ShadowBatch, Tracer};
use eosphor_core::ray::{Hit, Ray, RayFilter};

/// What is known about the rays of a batch. It changes the speed, never the answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coherence {
    /// Nothing: the tracer looks at the rays and chooses.
    #[default]
    Auto,
    /// Neighbours in the batch start close together and go nearly the same way: rays from the camera in the order of
    /// small blocks of pixels, rays towards one light.
    Coherent,
    /// Rays go anywhere.
    Incoherent,
}

/// What the rays of a batch leave out.
#[derive(Clone, Copy, Debug)]
pub enum Filters<'a> {
    /// All rays leave out the same.
    Shared(&'a RayFilter),
    /// Each ray has a filter of its own, at its place in the slice. There are as many filters as rays.
    Each(&'a [RayFilter]),
}

impl<'a> Filters<'a> {
    /// The filter of one ray, by its place in the batch.
    ///
    /// # Panics
    /// Where each ray has a filter and there is none at this place.
    #[inline(always)]
    pub fn of(&self, ray: usize) -> &'a RayFilter {
        match self {
            Filters::Shared(filter) => filter,
            Filters::Each(filters) => &filters[ray],
        }
    }

    /// Panics where there are not as many as rays.
    #[inline(always)]
    pub(crate) fn check(&self, rays: usize) {
        if let Filters::Each(filters) = self {
            assert_eq!(filters.len(), rays, "one filter for each ray");
        }
    }
}

/// Answers queries for many rays at a time, each bit for bit as [`Tracer`] answers it.
pub trait BatchTracer: Tracer {
    /// Finds the closest hit of each ray, as [`Tracer::closest_hit`] does, and writes it to the same place of `hits`; a miss where
    /// there is none. What was in `hits` does not matter.
    ///
    /// # Panics
    /// Where there are not as many hits, or filters of single rays, as rays.
    fn closest_hits(&self, rays: &[Ray], filters: Filters, coherence: Coherence, hits: &mut [Hit]);

    /// Finds whether anything is in the way of each ray, as [`Tracer::occluded`] does, and writes it to the same place of
    /// `hidden`.
    ///
    /// # Panics
    /// Where there are not as many answers, or filters of single rays, as rays.
    fn occluded_rays(&self, rays: &[Ray], filters: Filters, coherence: Coherence, hidden: &mut [bool]);

    /// Finds the next hit of each ray, as [`Tracer::next_hit`] does: the same place of `hits` holds the hit to go on from, which is
    /// replaced by the one that follows, or by a miss.
    ///
    /// # Panics
    /// Where there are not as many hits, or filters of single rays, as rays.
    fn next_hits(&self, rays: &[Ray], filters: Filters, coherence: Coherence, hits: &mut [Hit]);
}

/// Makes a [`BatchTracer`] of any [`Tracer`]: it answers one ray after the other.
#[derive(Clone, Copy, Debug)]
pub struct OneByOne<T>(pub T);

impl<T: Tracer> Tracer for OneByOne<T> {
    #[inline(always)]
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        self.0.closest_hit(ray, filter)
    }
    #[inline(always)]
    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        self.0.occluded(ray, filter)
    }
    #[inline(always)]
    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        self.0.next_hit(ray, filter, after)
    }
    #[inline(always)]
    fn occluded_batch<const W: usize>(
        &self,
        batch: &ShadowBatch<W>,
        filter: &RayFilter,
        active: &[bool; W],
    ) -> [bool; W] {
        self.0.occluded_batch(batch, filter, active)
    }
}

impl<T: Tracer> BatchTracer for OneByOne<T> {
    #[inline(always)]
    fn closest_hits(&self, rays: &[Ray], filters: Filters, _: Coherence, hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "one hit for each ray");
        filters.check(rays.len());
        for (k, (ray, hit)) in rays.iter().zip(hits).enumerate() {
            *hit = self.0.closest_hit(ray, filters.of(k));
        }
    }

    #[inline(always)]
    fn occluded_rays(&self, rays: &[Ray], filters: Filters, _: Coherence, hidden: &mut [bool]) {
        assert_eq!(rays.len(), hidden.len(), "one answer for each ray");
        filters.check(rays.len());
        for (k, (ray, hidden)) in rays.iter().zip(hidden).enumerate() {
            *hidden = self.0.occluded(ray, filters.of(k));
        }
    }

    #[inline(always)]
    fn next_hits(&self, rays: &[Ray], filters: Filters, _: Coherence, hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "one hit for each ray");
        filters.check(rays.len());
        for (k, (ray, hit)) in rays.iter().zip(hits).enumerate() {
            *hit = self.0.next_hit(ray, filters.of(k), hit);
        }
    }
}
