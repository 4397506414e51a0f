//! One SIMD dispatch a tile: the same code, compiled for each instruction set.
//!
//! Everything below [`render_tile_with`] is `inline(always)`, so it takes on the features of the function that it ends up
//! in; queries are compiled apart (`queries.rs`). `cargo xtask fma` disassembles the binary and fails where AVX2 or
//! AVX-512 code calls a library fma.

use super::batched::{self, Workspace};
use super::queries::{AnyTracer, Queries, with_batches, with_counting};
use super::tile::Tile;
use super::watch::{seen, with_clock};
use super::{Scheduler, SimdLevel};
use crate::{Hierarchy, RayStatistics};
use eosphor_core::integrator::{RayCounts, Samples, render_samples};
use eosphor_core::settings::Integrator;
use eosphor_core::view::SceneView;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// A tile to be rendered.
#[derive(Clone)]
pub(super) struct TileJob<'a> {
    pub(super) tile: Tile,
    pub(super) samples: Range<u32>,
    /// When raised, the tile is given up.
    pub(super) cancel: &'a AtomicBool,
    /// Count and time what queries do.
    pub(super) count_work: bool,
    pub(super) scheduler: Scheduler,
}

/// The rays of a tile, whose sums are in the workspace then; `None` where it was given up.
type Traced = Option<RayCounts>;

/// Shadow rays that the scalar scheduler traces at a time.
const LANES: usize = 16;

/// Renders a tile at a SIMD level that the CPU has, and leaves its sums in the workspace ([`Workspace::sums`]). Instances
/// are those of `top`. `None` where it was given up.
pub(super) fn render_tile(
    view: &SceneView,
    (hierarchy, top): (&Hierarchy, &Hierarchy),
    job: &TileJob,
    work: &mut Workspace,
    simd: SimdLevel,
) -> Option<RayStatistics> {
    if job.count_work {
        // By the scalar traversals: packets share nodes, which would make the figures per ray incomparable.
        let job = TileJob { scheduler: Scheduler::Scalar, ..job.clone() };
        let watch = with_clock();
        let traced =
            with_counting(hierarchy, top, &watch, simd, |queries| at_level(view, queries, &job, work, simd));
        return traced.map(|rays| seen(&watch, rays.into()));
    }
    // Without a hierarchy batches gain nothing, and would keep a tile from being given up for long.
    let scheduler = match hierarchy {
        Hierarchy::Exhaustive(_) => Scheduler::Scalar,
        _ => job.scheduler,
    };
    let job = TileJob { scheduler, ..job.clone() };
    let traced = with_batches(hierarchy, top, simd, |queries| at_level(view, queries, &job, work, simd));
    traced.map(RayStatistics::from)
}

fn at_level(
    view: &SceneView,
    queries: &dyn Queries,
    job: &TileJob,
    work: &mut Workspace,
    simd: SimdLevel,
) -> Traced {
    match simd {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: the CPU has AVX-512, as `CpuBackend::new` accepts only levels that are available.
        SimdLevel::Avx512 => unsafe { render_tile_avx512(view, queries, job, work) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: the CPU has AVX2 and FMA, as `CpuBackend::new` accepts only levels that are available.
        SimdLevel::Avx2 => unsafe { render_tile_avx2(view, queries, job, work) },
        _ => render_tile_with(view, queries, job, work),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
unsafe fn render_tile_avx512(
    view: &SceneView,
    queries: &dyn Queries,
    job: &TileJob,
    work: &mut Workspace,
) -> Traced {
    render_tile_with(view, queries, job, work)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
unsafe fn render_tile_avx2(
    view: &SceneView,
    queries: &dyn Queries,
    job: &TileJob,
    work: &mut Workspace,
) -> Traced {
    render_tile_with(view, queries, job, work)
}

#[inline(always)]
fn render_tile_with(view: &SceneView, queries: &dyn Queries, job: &TileJob, work: &mut Workspace) -> Traced {
    let tracer = AnyTracer(queries);
    match (job.scheduler, view.settings.integrator) {
        (Scheduler::Batched, Integrator::Whitted) => batched::trace_tile(view, &tracer, job, work),
        (Scheduler::Batched, Integrator::Path) => batched::trace_paths(view, &tracer, job, work),
        (Scheduler::Scalar, _) => pixel_by_pixel(view, &tracer, job, work),
    }
}

/// By the reference scheduler.
#[inline(always)]
fn pixel_by_pixel(view: &SceneView, tracer: &AnyTracer, job: &TileJob, work: &mut Workspace) -> Traced {
    let mut counts = RayCounts::default();
    let samples = Samples { first: job.samples.start, end: job.samples.end, step: 1 };
    work.sums.clear();
    for place in job.tile.places() {
        if job.cancel.load(Ordering::Relaxed) {
            return None;
        }
        work.sums.push(render_samples::<_, LANES>(view, tracer, place, samples, &mut counts));
    }
    Some(counts)
}
