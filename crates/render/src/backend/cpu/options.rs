//! Choices that change the time a picture takes, and nothing else about it.

use crate::Accel;
use eosphor_accel::{BuildOptions, Builder, SimdLevel};

/// How the CPU backend works.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CpuOptions {
    /// Threads; `None`: one for each core the process may use.
    pub threads: Option<usize>,
    /// Side of a tile in pixels, at least 1; `None`: 32, or less where that would leave threads idle.
    pub tile: Option<u32>,
    /// The hierarchy.
    pub accel: Accel,
    /// How bounding volume hierarchies are built. Trees of [`Builder::Spatial`] can lose a ray that lies in a triangle's
    /// plane to within rounding; all others give the same picture.
    pub builder: Builder,
    /// SIMD level; `None`: the best that the CPU has.
    pub simd: Option<SimdLevel>,
    /// The order in which rays are traced.
    pub scheduler: Scheduler,
}

/// In which order the rays of a tile are traced. All give the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scheduler {
    /// Many at a time: those of neighbouring pixels, those towards one light, those that go on. Without a hierarchy, and
    /// where work is counted, rays are traced as by [`Scheduler::Scalar`].
    #[default]
    Batched,
    /// Pixel after pixel, each path to its end: the reference, `eosphor_core::whitted::radiance`.
    Scalar,
}

impl Default for CpuOptions {
    fn default() -> CpuOptions {
        CpuOptions {
            threads: None,
            tile: None,
            accel: Accel::Bvh8,
            builder: BuildOptions::default().builder,
            simd: None,
            scheduler: Scheduler::Batched,
        }
    }
}
