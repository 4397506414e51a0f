//! Choices that change the time a picture takes, and nothing else about it.

use crate::Accel;
use eosphor_accel::SimdLevel;

/// How the CPU backend works.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CpuOptions {
    /// Threads; `None`: one for each core the process may use.
    pub threads: Option<usize>,
    /// Side of a tile in pixels, at least 1.
    pub tile: u32,
    /// The hierarchy.
    pub accel: Accel,
    /// SIMD level; `None`: the best that the CPU has.
    pub simd: Option<SimdLevel>,
}

impl Default for CpuOptions {
    fn default() -> CpuOptions {
        CpuOptions { threads: None, tile: 16, accel: Accel::Bvh, simd: None }
    }
}
