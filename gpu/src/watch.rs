//! What queries do: nothing is seen of it, or it is counted and timed.

use crate::totals::{Seen, Totals};
use core::arch::asm;
use core::cell::Cell;
use eosphor_core::hierarchy::{IgnoreWork, Phase, PhaseClock, Tracer, Watch, Watched, Work};

/// Whether a kernel counts.
pub(crate) trait Watching {
    /// Is told by structures.
    type Work<'a>: Work
    where
        Self: 'a;
    /// When a thread begins.
    fn new() -> Self;
    /// For structures.
    fn work(&self) -> Self::Work<'_>;
    /// A tracer with that work, as shading has it.
    fn around(&self, tracer: impl Tracer) -> impl Tracer;
    /// Adds what was seen. All threads of a warp come here, at the end.
    fn add_to(&self, totals: &Totals, lane: u32);
}

/// Kernels that do not.
pub(crate) struct Unwatched;

impl Watching for Unwatched {
    type Work<'a> = IgnoreWork;
    #[inline(always)]
    fn new() -> Unwatched {
        Unwatched
    }
    #[inline(always)]
    fn work(&self) -> IgnoreWork {
        IgnoreWork
    }
    #[inline(always)]
    fn around(&self, tracer: impl Tracer) -> impl Tracer {
        tracer
    }
    #[inline(always)]
    fn add_to(&self, _: &Totals, _: u32) {}
}

/// Kernels that do.
pub(crate) struct Counting {
    watch: Watch<Clock>,
    start: (u64, u64),
}

impl Watching for Counting {
    type Work<'a> = &'a Watch<Clock>;
    #[inline(always)]
    fn new() -> Counting {
        Counting { watch: Watch::default(), start: (ticks(), nanoseconds()) }
    }
    #[inline(always)]
    fn work(&self) -> &Watch<Clock> {
        &self.watch
    }
    #[inline(always)]
    fn around(&self, tracer: impl Tracer) -> impl Tracer {
        Watched { tracer, watch: &self.watch }
    }
    #[inline(always)]
    fn add_to(&self, totals: &Totals, lane: u32) {
        let Watch { searches, nodes, primitives, clock } = &self.watch;
        let seen = Seen {
            searches: searches.get(),
            nodes: nodes.get(),
            primitives: primitives.get(),
            traversal_ticks: clock.traversal.get(),
            intersection_ticks: clock.intersection.get(),
            thread_ticks: ticks() - self.start.0,
            thread_nanoseconds: nanoseconds() - self.start.1,
        };
        totals.add_seen(&seen, lane);
    }
}

/// By the processor's clock. A thread that waits for others of its warp goes on counting.
#[derive(Default)]
pub(crate) struct Clock {
    phase: Cell<Phase>,
    last: Cell<u64>,
    traversal: Cell<u64>,
    intersection: Cell<u64>,
}

impl PhaseClock for Clock {
    #[inline(always)]
    fn begin(&self) {
        self.phase.set(Phase::Traversal);
        self.last.set(ticks());
    }

    #[inline(always)]
    fn enter(&self, phase: Phase) {
        if self.phase.get() != phase {
            self.end();
            self.phase.set(phase);
        }
    }

    #[inline(always)]
    fn end(&self) {
        let now = ticks();
        let spent = match self.phase.get() {
            Phase::Traversal => &self.traversal,
            Phase::Intersection => &self.intersection,
        };
        spent.set(spent.get() + (now - self.last.get()));
        self.last.set(now);
    }
}

/// The count of the processor's clock.
#[inline(always)]
fn ticks() -> u64 {
    let ticks;
    // SAFETY: reads a counter.
    unsafe { asm!("mov.u64 {0}, %clock64;", out(reg64) ticks, options(nostack, nomem)) }
    ticks
}

/// The device's clock.
#[inline(always)]
fn nanoseconds() -> u64 {
    let nanoseconds;
    // SAFETY: reads a counter.
    unsafe { asm!("mov.u64 {0}, %globaltimer;", out(reg64) nanoseconds, options(nostack, nomem)) }
    nanoseconds
}
