//! What watched queries say of a tile.

use super::clock::Clock;
use crate::{QueryTimes, RayStatistics};
use eosphor_core::hierarchy::{self, Phase};

/// Counts what queries do; with a clock, which costs time itself, where that is asked for.
pub(crate) type Watch = hierarchy::Watch<Option<Clock>>;

/// A tracer that is watched.
pub(crate) type Watched<'a, T> = hierarchy::Watched<'a, T, Option<Clock>>;

/// With a clock.
pub(super) fn with_clock() -> Watch {
    Watch { clock: Some(Clock::new()), ..Watch::default() }
}

/// What was seen, added to what is known of the rays.
pub(super) fn seen(watch: &Watch, rays: RayStatistics) -> RayStatistics {
    let nanoseconds = watch.clock.as_ref().map_or([0; 2], Clock::nanoseconds);
    RayStatistics {
        searches: watch.searches.get(),
        nodes_visited: watch.nodes.get(),
        primitive_tests: watch.primitives.get(),
        times: QueryTimes {
            traversal_nanoseconds: nanoseconds[Phase::Traversal as usize],
            intersection_nanoseconds: nanoseconds[Phase::Intersection as usize],
        },
        ..rays
    }
}
