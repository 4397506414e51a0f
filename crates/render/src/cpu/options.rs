//! Choices that change the time a picture takes, and nothing else about it.

use crate::{Accel, HierarchyOptions};
use eosphor_accel::SimdLevel;

/// Options of the CPU backend: threads, SIMD level, hierarchy, scheduler. They change no pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CpuOptions {
    /// Threads; `None`: one for each core the process may use.
    pub threads: Option<usize>,
    /// Side of a tile in pixels, at least 1; `None`: 32, or less where that would leave threads idle.
    pub tile: Option<u32>,
    /// The kind of hierarchy that rays are traced through.
    pub accel: Accel,
    /// How the hierarchy is built. Where no builder is named, path tracing with many samples a triangle cuts triangles
    /// ([`Builder::Spatial`](crate::Builder::Spatial)).
    pub hierarchy: HierarchyOptions,
    /// SIMD level; `None`: the best that the CPU has.
    pub simd: Option<SimdLevel>,
    /// The order in which rays are traced.
    pub scheduler: Scheduler,
}

/// In which order the rays of a tile are traced. All give the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scheduler {
    /// Many at a time: those of neighbouring pixels, those towards lights, those that go on. Without a hierarchy, and where work
    /// is counted, rays are traced as by [`Scheduler::Scalar`].
    #[default]
    Batched,
    /// Pixel after pixel, each path to its end: the reference, `radiance` of the integrator in `eosphor_core::integrator`.
    Scalar,
}

impl Default for CpuOptions {
    fn default() -> CpuOptions {
        CpuOptions {
            threads: None,
            tile: None,
            accel: Accel::Bvh8,
            hierarchy: HierarchyOptions::default(),
            simd: None,
            scheduler: Scheduler::Batched,
        }
    }
}
