//! One SIMD dispatch a tile: the same code, compiled for each instruction set.
//!
//! Everything below [`render_tile_with`] is `inline(always)`, so it takes on the features of the function that it ends up
//! in. `cargo xtask fma` disassembles the binary and fails where AVX2 or AVX-512 code calls a library fma.

use super::SimdLevel;
use super::tile::Tile;
use crate::{Hierarchy, RayStatistics};
use eosphor_accel::PacketTracer;
use eosphor_core::hierarchy::{CountWork, IgnoreWork, Tracer};
use eosphor_core::math::Vec3;
use eosphor_core::view::SceneView;
use eosphor_core::whitted::{RayCounts, pixel_color, render_pixel};
use std::sync::atomic::{AtomicBool, Ordering};

/// A tile to be rendered.
pub(super) struct TileJob<'a> {
    pub(super) tile: Tile,
    /// When raised, the tile is given up.
    pub(super) cancel: &'a AtomicBool,
    /// Count nodes and primitive tests.
    pub(super) count_work: bool,
}

/// Colours of a tile, row after row, and what it took; `None` where it was given up.
type Rendered = Option<(Vec<Vec3>, RayStatistics)>;

/// Shadow rays traced at a time.
const LANES: usize = 16;

/// Renders a tile at a SIMD level that the CPU has.
pub(super) fn render_tile(
    view: &SceneView,
    hierarchy: &Hierarchy,
    job: &TileJob,
    simd: SimdLevel,
) -> Rendered {
    match simd {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: CpuBackend::new has made sure that the CPU has the level.
        SimdLevel::Avx512 => unsafe { render_tile_avx512(view, hierarchy, job) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        SimdLevel::Avx2 => unsafe { render_tile_avx2(view, hierarchy, job) },
        _ => render_tile_baseline(view, hierarchy, job),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt")]
unsafe fn render_tile_avx512(view: &SceneView, hierarchy: &Hierarchy, job: &TileJob) -> Rendered {
    render_tile_with(view, hierarchy, job)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
unsafe fn render_tile_avx2(view: &SceneView, hierarchy: &Hierarchy, job: &TileJob) -> Rendered {
    render_tile_with(view, hierarchy, job)
}

fn render_tile_baseline(view: &SceneView, hierarchy: &Hierarchy, job: &TileJob) -> Rendered {
    render_tile_with(view, hierarchy, job)
}

#[inline(always)]
fn render_tile_with(view: &SceneView, hierarchy: &Hierarchy, job: &TileJob) -> Rendered {
    match (hierarchy, job.count_work) {
        (Hierarchy::Bvh(bvh), false) => {
            trace_tile::<_, LANES>(view, &PacketTracer { scalar: bvh.tracer(IgnoreWork) }, job)
        }
        (Hierarchy::Bvh(bvh), true) => {
            // Work is counted by the scalar traversal: packets share nodes, which would make the figures per ray
            // incomparable.
            let tracer = bvh.tracer(CountWork::default());
            trace_tile::<_, 1>(view, &tracer, job).map(|(colors, s)| (colors, with_work(s, &tracer.work)))
        }
        (Hierarchy::Exhaustive(exhaustive), _) => {
            let tracer = exhaustive.tracer(CountWork::default());
            let rendered = trace_tile::<_, 1>(view, &tracer, job);
            if !job.count_work {
                return rendered;
            }
            rendered.map(|(colors, s)| (colors, with_work(s, &tracer.work)))
        }
    }
}

fn with_work(statistics: RayStatistics, work: &CountWork) -> RayStatistics {
    RayStatistics { nodes_visited: work.nodes.get(), primitive_tests: work.primitives.get(), ..statistics }
}

#[inline(always)]
fn trace_tile<T: Tracer, const W: usize>(view: &SceneView, tracer: &T, job: &TileJob) -> Rendered {
    let mut colors = Vec::with_capacity(job.tile.pixels() as usize);
    let mut statistics = RayStatistics::default();
    for (x, y) in job.tile.places() {
        if job.cancel.load(Ordering::Relaxed) {
            return None;
        }
        let mut counts = RayCounts::default();
        let sum = render_pixel::<T, W>(view, tracer, x, y, &mut counts);
        colors.push(pixel_color(view, &sum));
        statistics += RayStatistics {
            camera: counts.camera,
            reflected: counts.reflected,
            refracted: counts.refracted,
            glossy: counts.glossy,
            shadow: counts.shadow,
            ..RayStatistics::default()
        };
    }
    Some((colors, statistics))
}
