//! One SIMD dispatch a tile: the same code, compiled for each instruction set.
//!
//! Everything below [`render_tile_with`] is `inline(always)`, so it takes on the features of the function that it ends up
//! in. `cargo xtask fma` disassembles the binary and fails where AVX2 or AVX-512 code calls a library fma.

use super::batched::{self, Workspace};
use super::tile::Tile;
use super::{Scheduler, SimdLevel};
use crate::hierarchy::with_tracer;
use crate::{Hierarchy, RayStatistics};
use eosphor_accel::{BatchTracer, OneByOne, PacketTracer};
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
    pub(super) scheduler: Scheduler,
}

/// Colours of a tile, row after row, and what it took; `None` where it was given up.
type Rendered = Option<(Vec<Vec3>, RayStatistics)>;

/// Shadow rays traced at a time by the scalar scheduler.
const LANES: usize = 16;

/// Renders a tile at a SIMD level that the CPU has.
pub(super) fn render_tile(
    view: &SceneView,
    hierarchy: &Hierarchy,
    job: &TileJob,
    work: &mut Workspace,
    simd: SimdLevel,
) -> Rendered {
    match simd {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: CpuBackend::new has made sure that the CPU has the level.
        SimdLevel::Avx512 => unsafe { render_tile_avx512(view, hierarchy, job, work) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        SimdLevel::Avx2 => unsafe { render_tile_avx2(view, hierarchy, job, work) },
        _ => render_tile_baseline(view, hierarchy, job, work),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt")]
unsafe fn render_tile_avx512(
    view: &SceneView,
    hierarchy: &Hierarchy,
    job: &TileJob,
    work: &mut Workspace,
) -> Rendered {
    render_tile_with(view, hierarchy, job, work)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
unsafe fn render_tile_avx2(
    view: &SceneView,
    hierarchy: &Hierarchy,
    job: &TileJob,
    work: &mut Workspace,
) -> Rendered {
    render_tile_with(view, hierarchy, job, work)
}

fn render_tile_baseline(
    view: &SceneView,
    hierarchy: &Hierarchy,
    job: &TileJob,
    work: &mut Workspace,
) -> Rendered {
    render_tile_with(view, hierarchy, job, work)
}

#[inline(always)]
fn render_tile_with(
    view: &SceneView,
    hierarchy: &Hierarchy,
    job: &TileJob,
    work: &mut Workspace,
) -> Rendered {
    if job.count_work {
        // By the scalar traversals: packets share nodes, which would make the figures per ray incomparable.
        return with_tracer!(hierarchy, CountWork::default(), |tracer| {
            let (colors, rays) = pixel_by_pixel::<_, 1>(view, &tracer, job)?;
            let (nodes, tests) = (tracer.work.nodes.get(), tracer.work.primitives.get());
            Some((colors, RayStatistics { nodes_visited: nodes, primitive_tests: tests, ..rays.into() }))
        });
    }
    match hierarchy {
        // Batches gain nothing here, and would keep a tile from being given up for long.
        Hierarchy::Exhaustive(exhaustive) => {
            finish(pixel_by_pixel::<_, 1>(view, &exhaustive.tracer(IgnoreWork), job))
        }
        Hierarchy::Bvh(bvh) => {
            in_batches_or_not(view, &OneByOne(PacketTracer { scalar: bvh.tracer(IgnoreWork) }), job, work)
        }
    }
}

#[inline(always)]
fn in_batches_or_not<T: BatchTracer>(
    view: &SceneView,
    tracer: &T,
    job: &TileJob,
    work: &mut Workspace,
) -> Rendered {
    finish(match job.scheduler {
        Scheduler::Batched => batched::trace_tile(view, tracer, job.tile, job.cancel, work),
        Scheduler::Scalar => pixel_by_pixel::<_, LANES>(view, tracer, job),
    })
}

#[inline(always)]
fn finish(traced: Option<(Vec<Vec3>, RayCounts)>) -> Rendered {
    traced.map(|(colors, counts)| (colors, counts.into()))
}

/// By the reference scheduler.
#[inline(always)]
fn pixel_by_pixel<T: Tracer, const W: usize>(
    view: &SceneView,
    tracer: &T,
    job: &TileJob,
) -> Option<(Vec<Vec3>, RayCounts)> {
    let mut colors = Vec::with_capacity(job.tile.pixels() as usize);
    let mut counts = RayCounts::default();
    for (x, y) in job.tile.places() {
        if job.cancel.load(Ordering::Relaxed) {
            return None;
        }
        let sum = render_pixel::<T, W>(view, tracer, x, y, &mut counts);
        colors.push(pixel_color(view, &sum));
    }
    Some((colors, counts))
}
