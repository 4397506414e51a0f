//! One SIMD dispatch a tile: the same code, compiled for each instruction set.
//!
//! Everything below [`render_tile_with`] is `inline(always)`, so it takes on the features of the function that it ends up
//! in. `cargo xtask fma` disassembles the binary and fails where AVX2 or AVX-512 code calls a library fma.

use super::options::SimdLevel;
use super::tile::Tile;
use crate::RayStatistics;
use eosphor_accel::{Bvh, Exhaustive, PacketTracer};
use eosphor_core::hierarchy::{CountWork, IgnoreWork, Tracer};
use eosphor_core::math::Vec3;
use eosphor_core::view::SceneView;
use eosphor_core::whitted::{RayCounts, pixel_color, render_pixel};

/// What answers queries.
pub(super) enum Structure {
    Exhaustive(Exhaustive),
    Bvh(Bvh),
}

/// Shadow rays traced at a time.
const LANES: usize = 16;

/// Colours of a tile, row after row, and what it took.
pub(super) fn render_tile(
    view: &SceneView,
    structure: &Structure,
    tile: &Tile,
    simd: SimdLevel,
    count_work: bool,
) -> (Vec<Vec3>, RayStatistics) {
    match simd {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: CpuBackend::new has made sure that the CPU has the level.
        SimdLevel::Avx512 => unsafe { render_tile_avx512(view, structure, tile, count_work) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        SimdLevel::Avx2 => unsafe { render_tile_avx2(view, structure, tile, count_work) },
        _ => render_tile_baseline(view, structure, tile, count_work),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt")]
unsafe fn render_tile_avx512(
    view: &SceneView,
    structure: &Structure,
    tile: &Tile,
    count_work: bool,
) -> (Vec<Vec3>, RayStatistics) {
    render_tile_with(view, structure, tile, count_work)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
unsafe fn render_tile_avx2(
    view: &SceneView,
    structure: &Structure,
    tile: &Tile,
    count_work: bool,
) -> (Vec<Vec3>, RayStatistics) {
    render_tile_with(view, structure, tile, count_work)
}

fn render_tile_baseline(
    view: &SceneView,
    structure: &Structure,
    tile: &Tile,
    count_work: bool,
) -> (Vec<Vec3>, RayStatistics) {
    render_tile_with(view, structure, tile, count_work)
}

#[inline(always)]
fn render_tile_with(
    view: &SceneView,
    structure: &Structure,
    tile: &Tile,
    count_work: bool,
) -> (Vec<Vec3>, RayStatistics) {
    match (structure, count_work) {
        (Structure::Bvh(bvh), false) => {
            trace_tile::<_, LANES>(view, &PacketTracer { scalar: bvh.tracer(IgnoreWork) }, tile)
        }
        (Structure::Bvh(bvh), true) => {
            // Work is counted by the scalar traversal: packets share nodes, which would make the figures per ray
            // incomparable.
            let tracer = bvh.tracer(CountWork::default());
            let (colors, statistics) = trace_tile::<_, 1>(view, &tracer, tile);
            (colors, with_work(statistics, &tracer.work))
        }
        (Structure::Exhaustive(exhaustive), _) => {
            let tracer = exhaustive.tracer(CountWork::default());
            let (colors, statistics) = trace_tile::<_, 1>(view, &tracer, tile);
            (colors, if count_work { with_work(statistics, &tracer.work) } else { statistics })
        }
    }
}

fn with_work(statistics: RayStatistics, work: &CountWork) -> RayStatistics {
    RayStatistics { nodes_visited: work.nodes.get(), primitive_tests: work.primitives.get(), ..statistics }
}

#[inline(always)]
fn trace_tile<T: Tracer, const W: usize>(
    view: &SceneView,
    tracer: &T,
    tile: &Tile,
) -> (Vec<Vec3>, RayStatistics) {
    let mut colors = Vec::with_capacity(tile.pixels() as usize);
    let mut statistics = RayStatistics::default();
    for (x, y) in tile.places() {
        let mut counts = RayCounts::default();
        let sum = render_pixel::<T, W>(view, tracer, x, y, &mut counts);
        colors.push(pixel_color(view, &sum));
        statistics += RayStatistics {
            camera: counts.camera as u64,
            reflected: counts.reflected as u64,
            refracted: counts.refracted as u64,
            glossy: counts.glossy as u64,
            shadow: counts.shadow as u64,
            ..RayStatistics::default()
        };
    }
    (colors, statistics)
}
