//! Watching queries: what they do is counted, and how long that takes is measured, for those who ask.

use super::clock::Clock;
use crate::{QueryTimes, RayStatistics};
use eosphor_core::hierarchy::{Tracer, Work};
use eosphor_core::ray::{Hit, Ray, RayFilter};
use std::cell::Cell;

/// Phases of a query. What leads to the primitives is traversal: nodes, rays that are mapped into instances.
const TRAVERSAL: usize = 0;
/// From the first primitive of a leaf that is tested to the next node.
const INTERSECTION: usize = 1;

/// Counts what queries do.
#[derive(Default)]
pub(crate) struct Watch {
    pub(super) searches: Cell<u64>,
    /// Nodes whose box was tested.
    pub(super) nodes: Cell<u64>,
    /// Primitives that were tested.
    pub(super) primitives: Cell<u64>,
    clock: Option<Clock>,
}

impl Watch {
    /// With clocks, which cost time themselves.
    pub(super) fn with_clock() -> Watch {
        Watch { clock: Some(Clock::new()), ..Watch::default() }
    }

    /// From 0 again.
    pub(super) fn reset(&self) {
        [&self.searches, &self.nodes, &self.primitives].into_iter().for_each(|count| count.set(0));
    }

    /// What was seen, added to what is known of the rays.
    pub(super) fn add_to(&self, rays: RayStatistics) -> RayStatistics {
        let nanoseconds = self.clock.as_ref().map_or([0; 2], Clock::nanoseconds);
        RayStatistics {
            searches: self.searches.get(),
            nodes_visited: self.nodes.get(),
            primitive_tests: self.primitives.get(),
            times: QueryTimes {
                traversal_nanoseconds: nanoseconds[TRAVERSAL],
                intersection_nanoseconds: nanoseconds[INTERSECTION],
            },
            ..rays
        }
    }

    /// A search begins.
    #[inline(always)]
    fn begin(&self) {
        add(&self.searches, 1);
        if let Some(clock) = &self.clock {
            clock.begin(TRAVERSAL);
        }
    }

    /// It is over.
    #[inline(always)]
    fn end(&self) {
        if let Some(clock) = &self.clock {
            clock.end();
        }
    }
}

/// Told by tracers, before boxes and primitives are tested.
impl Work for &Watch {
    #[inline(always)]
    fn nodes(&self, count: u32) {
        add(&self.nodes, count);
        if let Some(clock) = &self.clock {
            clock.enter(TRAVERSAL);
        }
    }

    #[inline(always)]
    fn primitives(&self, count: u32) {
        add(&self.primitives, count);
        if let Some(clock) = &self.clock {
            clock.enter(INTERSECTION);
        }
    }
}

#[inline(always)]
fn add(sum: &Cell<u64>, count: u32) {
    sum.set(sum.get() + u64::from(count));
}

/// A tracer whose work is a [`Watch`], which is told of each search, too. Rays of a batch go one by one.
pub(crate) struct Watched<'a, T> {
    pub(crate) tracer: T,
    pub(crate) watch: &'a Watch,
}

impl<T: Tracer> Tracer for Watched<'_, T> {
    #[inline(always)]
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        self.watch.begin();
        let answer = self.tracer.closest_hit(ray, filter);
        self.watch.end();
        answer
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        self.watch.begin();
        let answer = self.tracer.occluded(ray, filter);
        self.watch.end();
        answer
    }

    #[inline(always)]
    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        self.watch.begin();
        let answer = self.tracer.next_hit(ray, filter, after);
        self.watch.end();
        answer
    }
}
