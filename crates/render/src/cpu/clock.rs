//! A clock for what takes less time than the system's clock does to be read.

use eosphor_core::hierarchy::{Phase, PhaseClock};
use std::cell::Cell;
use std::sync::OnceLock;
use std::time::Instant;

/// The count of a counter that goes on evenly: the processor's own where that is known, as it is read in a few nanoseconds.
#[inline(always)]
fn ticks() -> u64 {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: every CPU of this kind has the instruction, which does nothing but read.
    unsafe {
        std::arch::x86_64::_rdtsc()
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        static START: OnceLock<Instant> = OnceLock::new();
        START.get_or_init(Instant::now).elapsed().as_nanos() as u64
    }
}

/// What reading it takes, in its own unit: the median of many pairs of readings.
fn reading() -> u64 {
    static READING: OnceLock<u64> = OnceLock::new();
    *READING.get_or_init(|| {
        let mut pairs: Vec<u64> = (0..1001)
            .map(|_| {
                let first = ticks();
                ticks().saturating_sub(first)
            })
            .collect();
        pairs.sort_unstable();
        pairs[pairs.len() / 2]
    })
}

/// Adds up the lengths of intervals that follow each other, each for one of two phases.
#[derive(Debug)]
pub(crate) struct Clock {
    /// Both clocks at the beginning, for the length of a tick.
    start: (Instant, u64),
    /// When the present interval began, and its phase.
    last: Cell<u64>,
    phase: Cell<Phase>,
    spent: [Cell<u64>; 2],
    intervals: [Cell<u64>; 2],
}

impl Clock {
    pub(super) fn new() -> Clock {
        reading();
        Clock {
            start: (Instant::now(), ticks()),
            last: Cell::new(0),
            phase: Cell::default(),
            spent: Default::default(),
            intervals: Default::default(),
        }
    }

    /// Nanoseconds of both phases. Each interval holds one reading of the clock, which is taken off.
    pub(super) fn nanoseconds(&self) -> [u64; 2] {
        let (start, first) = self.start;
        let all = ticks().saturating_sub(first).max(1);
        let length = start.elapsed().as_nanos() as f64 / all as f64;
        [0, 1].map(|phase| {
            let ticks = without_readings(self.spent[phase].get(), self.intervals[phase].get(), reading());
            (ticks as f64 * length) as u64
        })
    }
}

impl PhaseClock for Clock {
    #[inline(always)]
    fn begin(&self) {
        self.phase.set(Phase::Traversal);
        self.last.set(ticks());
    }

    /// Ends the interval and begins another.
    #[inline(always)]
    fn enter(&self, phase: Phase) {
        if self.phase.get() != phase {
            self.end();
            self.phase.set(phase);
        }
    }

    /// Ends the interval.
    #[inline(always)]
    fn end(&self) {
        let (now, phase) = (ticks(), self.phase.get() as usize);
        let add = |sum: &Cell<u64>, count: u64| sum.set(sum.get().wrapping_add(count));
        // Counters of different cores may differ a little.
        add(&self.spent[phase], now.saturating_sub(self.last.get()));
        add(&self.intervals[phase], 1);
        self.last.set(now);
    }
}

fn without_readings(spent: u64, intervals: u64, reading: u64) -> u64 {
    spent.saturating_sub(intervals.saturating_mul(reading))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_belong_to_their_phases() {
        let clock = Clock::new();
        assert_eq!(clock.nanoseconds(), [0, 0]);
        clock.begin();
        clock.enter(Phase::Traversal);
        clock.enter(Phase::Intersection);
        clock.enter(Phase::Intersection);
        clock.enter(Phase::Traversal);
        clock.end();
        // Traversal, tests, traversal.
        assert_eq!([clock.intervals[0].get(), clock.intervals[1].get()], [2, 1]);
        clock.begin();
        clock.enter(Phase::Intersection);
        clock.end();
        assert_eq!([clock.intervals[0].get(), clock.intervals[1].get()], [3, 2]);
    }

    #[test]
    fn readings_are_taken_off() {
        assert_eq!(without_readings(1000, 10, 20), 800);
        assert_eq!(without_readings(1000, 10, 200), 0);
    }
}
