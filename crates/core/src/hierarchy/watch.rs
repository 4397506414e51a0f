//! Watching queries: what they do is counted, and how long that takes may be measured.

use super::{Tracer, Work};
use crate::ray::{Hit, Ray, RayFilter};
use core::cell::Cell;

/// What a query is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(usize)]
pub enum Phase {
    /// What leads to the primitives: nodes, rays that are mapped into instances.
    #[default]
    Traversal,
    /// From the first primitive of a leaf that is tested to the next node.
    Intersection,
}

/// Measures how long queries are in each phase.
pub trait PhaseClock {
    /// A query begins, with traversal.
    fn begin(&self);
    /// The query goes on in this phase; where it is in it already, nothing happens.
    fn enter(&self, phase: Phase);
    /// The query is over.
    fn end(&self);
}

/// Nothing is measured where there is none.
impl<C: PhaseClock> PhaseClock for Option<C> {
    #[inline(always)]
    fn begin(&self) {
        if let Some(clock) = self {
            clock.begin();
        }
    }

    #[inline(always)]
    fn enter(&self, phase: Phase) {
        if let Some(clock) = self {
            clock.enter(phase);
        }
    }

    #[inline(always)]
    fn end(&self) {
        if let Some(clock) = self {
            clock.end();
        }
    }
}

/// Counts what queries do, and has a clock.
#[derive(Debug, Default)]
pub struct Watch<C> {
    /// Queries that were answered.
    pub searches: Cell<u64>,
    /// Nodes whose box was tested.
    pub nodes: Cell<u64>,
    /// Primitives that were tested.
    pub primitives: Cell<u64>,
    /// Of both phases.
    pub clock: C,
}

impl<C> Watch<C> {
    /// Counts from 0 again.
    pub fn reset(&self) {
        [&self.searches, &self.nodes, &self.primitives].into_iter().for_each(|count| count.set(0));
    }
}

/// Told by tracers, before boxes and primitives are tested.
impl<C: PhaseClock> Work for &Watch<C> {
    #[inline(always)]
    fn nodes(&self, count: u32) {
        add(&self.nodes, count);
        self.clock.enter(Phase::Traversal);
    }

    #[inline(always)]
    fn primitives(&self, count: u32) {
        add(&self.primitives, count);
        self.clock.enter(Phase::Intersection);
    }
}

#[inline(always)]
fn add(sum: &Cell<u64>, count: u32) {
    sum.set(sum.get() + u64::from(count));
}

/// A tracer whose work is a [`Watch`], which is told of each search, too. Rays of a batch go one by one.
#[derive(Clone, Copy, Debug)]
pub struct Watched<'a, T, C> {
    /// Answers.
    pub tracer: T,
    /// Is told.
    pub watch: &'a Watch<C>,
}

impl<T: Tracer, C: PhaseClock> Watched<'_, T, C> {
    #[inline(always)]
    fn begin(&self) {
        add(&self.watch.searches, 1);
        self.watch.clock.begin();
    }
}

impl<T: Tracer, C: PhaseClock> Tracer for Watched<'_, T, C> {
    #[inline(always)]
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        self.begin();
        let answer = self.tracer.closest_hit(ray, filter);
        self.watch.clock.end();
        answer
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        self.begin();
        let answer = self.tracer.occluded(ray, filter);
        self.watch.clock.end();
        answer
    }

    #[inline(always)]
    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        self.begin();
        let answer = self.tracer.next_hit(ray, filter, after);
        self.watch.clock.end();
        answer
    }
}
