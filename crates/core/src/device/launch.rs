//! What kernels take besides arrays, and what they write: declared once for hosts and devices.

use crate::math::Vec3;
use crate::ray::{Hit, PrimitiveId, UNKNOWN_REST};
use crate::sums::ExactSum;
use crate::view::SceneCounts;

/// The last parameter of every kernel that renders: a band of rows.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct BandLaunch {
    /// How many items the scene's arrays have.
    pub counts: SceneCounts,
    /// The colours of the band's pixels, row after row, are written here: for all samples at once.
    pub film: *mut Vec3,
    /// The sums of the band's pixels are written here instead; null where colours are wanted.
    pub sums: *mut ExactSum,
    /// What the launch traces is added to these, atomically.
    pub totals: *mut RayTotals,
    /// The first row.
    pub first_row: u32,
    /// The row after the last.
    pub end_row: u32,
    /// The first sample of each pixel.
    pub first_sample: u32,
    /// The sample after the last.
    pub end_sample: u32,
    /// So many threads share the samples of a pixel, as a power of two; at most 5: a warp.
    pub sharing: u32,
}

/// Rays of a launch, and the work on them: sums over all threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct RayTotals {
    /// Rays from the camera.
    pub camera: u64,
    /// Mirrored rays.
    pub reflected: u64,
    /// Rays through surfaces.
    pub refracted: u64,
    /// Rays of glossy lobes.
    pub glossy: u64,
    /// Rays towards lights.
    pub shadow: u64,
    /// Searches through a hierarchy; this and what follows is 0 but for kernels that count.
    pub searches: u64,
    /// Nodes that searches visited.
    pub nodes: u64,
    /// Primitives that searches tested.
    pub primitives: u64,
    /// Ticks of the processors' clocks in traversal.
    pub traversal_ticks: u64,
    /// The same in tests of primitives.
    pub intersection_ticks: u64,
    /// Ticks of all threads, from begin to end.
    pub thread_ticks: u64,
    /// The same in nanoseconds of the device's clock, which goes in coarse steps.
    pub thread_nanoseconds: u64,
}

/// A hit as kernels write it: 16 bytes at once. The instance, where there are any, goes to an array of its own.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct HitRow {
    /// Distance along the ray.
    pub t: f32,
    /// First barycentric coordinate.
    pub u: f32,
    /// Second barycentric coordinate.
    pub v: f32,
    /// Index of the primitive, or that of [`PrimitiveId::NONE`].
    pub primitive: u32,
}

impl HitRow {
    /// The hit, where the row of the other array names this instance.
    pub fn hit(&self, instance: u32) -> Hit {
        let &HitRow { t, u, v, primitive } = self;
        let is_miss = primitive == PrimitiveId::NONE.primitive;
        let id = if is_miss { PrimitiveId::NONE } else { PrimitiveId { instance, primitive } };
        // Kernels do not write the rest of `t`.
        Hit { t, t_rest: UNKNOWN_REST, u, v, id }
    }
}

impl From<Hit> for HitRow {
    #[inline(always)]
    fn from(hit: Hit) -> HitRow {
        HitRow { t: hit.t, u: hit.u, v: hit.v, primitive: hit.id.primitive }
    }
}
