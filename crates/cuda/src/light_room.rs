//! The room of shadow rays of Whitted's trees in a queue.

use eosphor_core::device::{PROGRESS_ROWS, Row};

/// Shadow rays that a queue of their own has room for. By measurement: half as many and twice as many are
/// slower (docs/gpu-speed.md).
const LIGHT_RAYS: u32 = 1 << 23;

/// The fewest points of a round whose shadow rays have a queue of their own: there are other kernels in a round too.
const FEWEST_POINTS: u32 = 1 << 15;

/// Paths of a round are a multiple of it.
pub(crate) const WARP: u32 = 32;

/// Shadow rays of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PointRays {
    /// How many there are at most.
    pub(crate) all: u32,
    /// Whether many of them go to one light. Then those of a point lie side by side in a queue. Otherwise those of several points
    /// to one light do, so that a warp's threads look the same way.
    pub(crate) share_lights: bool,
}

/// How large the queue of shadow rays is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LightRays {
    /// How many of each point are traced together.
    pub(crate) window: u32,
    /// Whether shadows have colours.
    pub(crate) is_coloured: bool,
    /// As [`LightQueue::group_bits`](eosphor_core::device::LightQueue::group_bits).
    pub(crate) group_bits: u32,
}

impl LightRays {
    /// Points of a round whose rays find room, where each has so many.
    pub(crate) fn points(all: u32) -> u32 {
        (LIGHT_RAYS / all.max(1)).max(FEWEST_POINTS)
    }

    /// For so many points, a multiple of a warp.
    pub(crate) fn new(rays: PointRays, is_coloured: bool, points: u32) -> LightRays {
        LightRays {
            window: (LIGHT_RAYS / points.max(1)).clamp(1, rays.all.max(1)),
            is_coloured,
            group_bits: if rays.share_lights { 0 } else { WARP.ilog2() },
        }
    }

    /// How many windows there are, where a point has so many rays.
    pub(crate) fn windows(self, all: u32) -> u32 {
        all.div_ceil(self.window).max(1)
    }

    /// What each point takes.
    pub(crate) fn bytes(&self) -> u64 {
        // With its number in the list of those that have something in their way.
        let through = if self.is_coloured { size_of::<Row>() + size_of::<u32>() } else { 0 };
        let ray = size_of::<Row>() + size_of::<u32>() + size_of::<[f32; 2]>() + through;
        u64::from(self.window) * ray as u64 + (PROGRESS_ROWS * size_of::<Row>()) as u64
    }
}
