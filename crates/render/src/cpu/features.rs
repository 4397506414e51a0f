//! The feature pass: what camera rays find first, in tiles over all cores.
//!
//! It serves every backend. By the picture contract its camera rays hit what those of a GPU hit, bit for bit.

use super::super::{BackendError, check_rows};
use super::queries::{AnyTracer, Queries, with_counting};
use super::tile::{Tile, Tiling};
use super::{CpuFrame, SimdLevel, Watch};
use crate::backend::check_region;
use crate::{CameraWork, FeatureRows, Hierarchy, HierarchyStatistics, Region, ShapedScenes};
use eosphor_core::integrator::{PixelFeatures, pixel_features};
use eosphor_core::view::SceneView;
use eosphor_scene::{FrameState, SceneData};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// A scene ready for its features to be traced; [`super::CpuBackend::feature_pass`] makes it.
#[derive(Clone)]
pub struct FeaturePass {
    pub(super) scene: Arc<SceneData>,
    pub(super) hierarchy: Arc<Hierarchy>,
    pub(super) shaped: Arc<ShapedScenes>,
    pub(super) simd: SimdLevel,
    pub(super) tile: Option<u32>,
    pub(super) pool: Arc<rayon::ThreadPool>,
    /// The part of the picture; all of it where there is none.
    pub(super) region: Option<Region>,
}

impl FeaturePass {
    /// Size, depth and build time of the hierarchy.
    pub fn hierarchy_statistics(&self) -> HierarchyStatistics {
        self.hierarchy.statistics()
    }

    /// This pass for a part of the picture alone. Rows are then counted from the first row of the region.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] where it has no pixels, or some that the picture lacks.
    pub fn of_region(self, region: Region) -> Result<FeaturePass, BackendError> {
        check_region(&region, (self.scene.settings.width, self.scene.settings.height))?;
        Ok(FeaturePass { region: Some(region), ..self })
    }

    /// The part of the picture of a frame that this pass is for.
    fn region_of(&self, state: Option<&FrameState>) -> Region {
        let settings = state.map_or(&self.scene.settings, |state| &state.settings);
        self.region.unwrap_or(Region::whole((settings.width, settings.height)))
    }

    /// Features of some rows of the picture, of a frame, which may have another size, or of the scene as it was prepared.
    /// All but the work is the same bits whatever the threads, tiles, SIMD level and hierarchy. Where `cancel` is raised,
    /// returns soon; the pixels that were not reached show nothing.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] where the rows are none or not in the picture.
    pub fn rows(
        &self,
        rows: Range<u32>,
        state: Option<&FrameState>,
        cancel: &AtomicBool,
    ) -> Result<FeatureRows, BackendError> {
        let region = self.region_of(state);
        check_rows(&rows, region.height)?;
        let region = region.rows(&rows);
        let frame = CpuFrame::new((&self.scene, &self.hierarchy), &self.shaped, state, &self.pool)?;
        let (view, hierarchies) = (frame.view(), frame.hierarchies());
        let tiling = Tiling::for_threads(region, self.tile, self.pool.current_num_threads());
        let features = Mutex::new(FeatureRows::new(region.width, region.height));
        self.pool.install(|| {
            (0..tiling.len()).into_par_iter().with_max_len(1).for_each(|number| {
                let tile = tiling.tile(number);
                let Some((pixels, work)) = trace(&view, hierarchies, tile, cancel, self.simd) else {
                    return;
                };
                let mut features = features.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
                tile.copy_to(&pixels, &mut features.pixels, &region);
                tile.copy_to(&work, &mut features.work, &region);
            });
        });
        Ok(features.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()))
    }

    /// Features of one pixel of a frame.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] where the picture has no such pixel.
    pub fn pixel(&self, x: u32, y: u32, state: &FrameState) -> Result<PixelFeatures, BackendError> {
        let whole = self.region_of(Some(state));
        let region =
            Region { x: whole.x.saturating_add(x), y: whole.y.saturating_add(y), width: 1, height: 1 };
        check_region(&region, (state.settings.width, state.settings.height))?;
        let one = FeaturePass { region: Some(region), ..self.clone() };
        let features = one.rows(0..1, Some(state), &AtomicBool::new(false))?;
        Ok(features.pixels.first().copied().unwrap_or(PixelFeatures::NOTHING))
    }
}

/// Features of the pixels of a tile and the work on them, row after row; `None` where the tile was given up.
type Traced = Option<(Vec<PixelFeatures>, Vec<CameraWork>)>;

/// Traces a tile at a SIMD level that the CPU has, by the scalar tracers: packets share nodes, so their work is no pixel's
/// own. As in `dispatch.rs`, the functions' names are what `cargo xtask fma` looks for.
fn trace(
    view: &SceneView,
    (hierarchy, top): (&Hierarchy, &Hierarchy),
    tile: Tile,
    cancel: &AtomicBool,
    simd: SimdLevel,
) -> Traced {
    let work = Watch::default();
    with_counting(hierarchy, top, &work, simd, |queries| match simd {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: the CPU has AVX-512, as `CpuBackend::new` accepts only levels that are available.
        SimdLevel::Avx512 => unsafe { render_tile_avx512_features(view, queries, &work, tile, cancel) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: the CPU has AVX2 and FMA, as `CpuBackend::new` accepts only levels that are available.
        SimdLevel::Avx2 => unsafe { render_tile_avx2_features(view, queries, &work, tile, cancel) },
        _ => trace_tile(view, queries, &work, tile, cancel),
    })
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
unsafe fn render_tile_avx512_features(
    view: &SceneView,
    queries: &dyn Queries,
    work: &Watch,
    tile: Tile,
    cancel: &AtomicBool,
) -> Traced {
    trace_tile(view, queries, work, tile, cancel)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
unsafe fn render_tile_avx2_features(
    view: &SceneView,
    queries: &dyn Queries,
    work: &Watch,
    tile: Tile,
    cancel: &AtomicBool,
) -> Traced {
    trace_tile(view, queries, work, tile, cancel)
}

#[inline(always)]
fn trace_tile(
    view: &SceneView,
    queries: &dyn Queries,
    work: &Watch,
    tile: Tile,
    cancel: &AtomicBool,
) -> Traced {
    let tracer = AnyTracer(queries);
    let count = tile.pixels() as usize;
    let (mut pixels, mut works) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for (x, y) in tile.places() {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        work.reset();
        pixels.push(pixel_features(view, &tracer, x, y));
        // 65,536 samples can in theory exceed 32 bits.
        let cut = |number: u64| number.min(u32::MAX as u64) as u32;
        works.push(CameraWork { nodes: cut(work.nodes.get()), tests: cut(work.primitives.get()) });
    }
    Some((pixels, works))
}
