//! The CPU backend: tiles over all cores, with one SIMD dispatch a tile.

mod batched;
mod clock;
mod dispatch;
mod features;
mod measure;
mod options;
mod queries;
mod rays;
mod tile;
mod watch;

use eosphor_accel::SimdLevel;
pub use features::FeaturePass;
pub use measure::CameraSpeed;
pub use options::{CpuOptions, Scheduler};
pub(crate) use watch::{Watch, Watched};

use super::{
    Backend, BackendError, PreparedScene, Progress, RenderControl, Rendered, Sampled, check_rows,
    check_samples,
};
use crate::backend::check_region;
use crate::{
    Accel, Film, Hierarchy, HierarchyOptions, HierarchyStatistics, RayStatistics, Region, SampleSums,
    ShapedScene, ShapedScenes,
};
use crate::{build_hierarchy, check_scene, options_by_work};
use batched::Workspace;
use dispatch::TileJob;
use eosphor_core::integrator::pixel_color;
use eosphor_core::sums::ExactSum;
use eosphor_core::view::SceneView;
use eosphor_scene::{FrameState, Places, SceneData};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use tile::{Tile, Tiling};

/// Renders on the cores of the CPU.
pub struct CpuBackend {
    options: CpuOptions,
    simd: SimdLevel,
    pool: Arc<rayon::ThreadPool>,
}

impl CpuBackend {
    /// A backend with these options. Fails where the CPU lacks the SIMD level of the options or threads cannot be started.
    pub fn new(options: CpuOptions) -> Result<CpuBackend, BackendError> {
        let simd = match options.simd {
            None => SimdLevel::best(),
            Some(level) if level.is_available() => level,
            Some(level) => {
                return Err(BackendError::Unavailable(format!(
                    "this CPU has no {level}: choose one of {}, or leave the choice to the program",
                    SimdLevel::available().map(|l| l.to_string()).collect::<Vec<_>>().join(", ")
                )));
            }
        };
        if options.tile == Some(0) {
            return Err(BackendError::Failed("the tile size must be at least 1".into()));
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(options.threads.unwrap_or(0))
            .build()
            .map_err(|e| BackendError::Failed(format!("cannot start threads: {e}")))?;
        Ok(CpuBackend { options, simd, pool: Arc::new(pool) })
    }

    /// The number of threads that render.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// The SIMD level in use.
    pub fn simd(&self) -> SimdLevel {
        self.simd
    }

    /// What camera rays find first, on the threads of this backend and with its options. Where a scene has been
    /// prepared, its [`PreparedScene::hierarchy`] can be used again; otherwise one is built.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] where the scene does not hold together.
    pub fn feature_pass(
        &self,
        scene: Arc<SceneData>,
        hierarchy: Option<Arc<Hierarchy>>,
    ) -> Result<FeaturePass, BackendError> {
        check_scene(&scene)?;
        let hierarchy = match hierarchy {
            Some(hierarchy) => hierarchy,
            None => Arc::new(self.build(&scene, self.options.hierarchy)?),
        };
        let (simd, tile, pool) = (self.simd, self.options.tile, Arc::clone(&self.pool));
        let shaped = self.shaped_scenes(&scene, &hierarchy);
        Ok(FeaturePass { scene, hierarchy, shaped, simd, tile, pool, region: None })
    }

    fn shaped_scenes(&self, scene: &Arc<SceneData>, hierarchy: &Arc<Hierarchy>) -> Arc<ShapedScenes> {
        let options = self.options.hierarchy;
        Arc::new(ShapedScenes::new(Arc::clone(scene), Arc::clone(hierarchy), options))
    }

    fn build(&self, scene: &SceneData, options: HierarchyOptions) -> Result<Hierarchy, BackendError> {
        self.pool.install(|| build_hierarchy(self.options.accel, &options, scene))
    }
}

/// For so many samples of path tracing a triangle, cutting triangles pays: it takes four times as long to build (a microsecond a
/// triangle more), and takes a tenth off paths through buildings, nothing off those through scanned bodies (a path takes some four
/// microseconds).
const SAMPLES_WORTH_CUTTING: u64 = 8;

fn by_work(options: HierarchyOptions, accel: Accel, scene: &SceneData) -> HierarchyOptions {
    if accel == Accel::Bvh8 { options_by_work(options, scene, SAMPLES_WORTH_CUTTING) } else { options }
}

impl Backend for CpuBackend {
    fn describe(&self) -> String {
        format!("CPU, {} threads, {}", self.threads(), self.simd)
    }

    fn prepare(&self, scene: Arc<SceneData>) -> Result<Box<dyn PreparedScene>, BackendError> {
        check_scene(&scene)?;
        let options = by_work(self.options.hierarchy, self.options.accel, &scene);
        let hierarchy = Arc::new(self.build(&scene, options)?);
        let prepared = PreparedCpu {
            shaped: self.shaped_scenes(&scene, &hierarchy),
            scene,
            hierarchy,
            simd: self.simd,
            tile: self.options.tile,
            scheduler: self.options.scheduler,
            pool: Arc::clone(&self.pool),
        };
        Ok(Box::new(prepared))
    }
}

/// A scene and the hierarchies over it, in a frame.
struct CpuFrame<'a> {
    scene: &'a SceneData,
    state: Option<&'a FrameState>,
    hierarchy: &'a Hierarchy,
    /// Where vertices of meshes are elsewhere than in the prepared scene.
    shaped: Option<Arc<ShapedScene>>,
    /// The tree over the instances, where these alone are elsewhere.
    top: Option<Hierarchy>,
}

impl<'a> CpuFrame<'a> {
    fn new(
        (scene, hierarchy): (&'a SceneData, &'a Hierarchy),
        shaped: &ShapedScenes,
        state: Option<&'a FrameState>,
        pool: &rayon::ThreadPool,
    ) -> Result<CpuFrame<'a>, BackendError> {
        let shaped = pool.install(|| shaped.of_frame(state))?;
        let places = state.and_then(|state| state.places.as_ref()).filter(|_| shaped.is_none());
        // It is built again for each frame, and most have few instances.
        let build = |places: &Places| Hierarchy::build_top(hierarchy.accel(), &places.instances);
        let top =
            places.map(|places| pool.install(|| build(places)).expect("a frame's instances are in range"));
        Ok(CpuFrame { scene, state, hierarchy, shaped, top })
    }

    fn view(&self) -> SceneView<'_> {
        self.scene.view_at(self.state, self.shaped.as_ref().map(|shaped| &shaped.arrays))
    }

    /// The one with the geometries, and the one with the instances.
    fn hierarchies(&self) -> (&Hierarchy, &Hierarchy) {
        let hierarchy = self.shaped.as_ref().map_or(self.hierarchy, |shaped| &shaped.hierarchy);
        (hierarchy, self.top.as_ref().unwrap_or(hierarchy))
    }
}

struct PreparedCpu {
    scene: Arc<SceneData>,
    hierarchy: Arc<Hierarchy>,
    shaped: Arc<ShapedScenes>,
    simd: SimdLevel,
    tile: Option<u32>,
    scheduler: Scheduler,
    pool: Arc<rayon::ThreadPool>,
}

impl PreparedScene for PreparedCpu {
    fn hierarchy_statistics(&self) -> HierarchyStatistics {
        self.hierarchy.statistics()
    }

    fn hierarchy(&self) -> Option<Arc<Hierarchy>> {
        Some(Arc::clone(&self.hierarchy))
    }

    fn size(&self) -> (u32, u32) {
        (self.scene.settings.width, self.scene.settings.height)
    }

    fn samples(&self) -> u32 {
        self.scene.settings.samples
    }

    /// Several tiles a thread.
    fn pixels_at_a_time(&self) -> u64 {
        Tiling::fewest_pixels(self.pool.current_num_threads())
    }

    fn render_rows(&self, rows: Range<u32>, control: &RenderControl) -> Result<Rendered, BackendError> {
        let (width, height) = control.size_of(self);
        check_rows(&rows, height)?;
        let region = Region::whole((width, height)).rows(&rows);
        let film = Mutex::new(Film::new(width, region.height));
        let samples = 0..control.samples_of(self);
        let frame = self.frame(control)?;
        let view = frame.view();
        let color = |sum: &ExactSum| pixel_color(&view, sum);
        let (complete, statistics) = self.trace_tiles(&frame, region, samples, control, &|tile, sums| {
            // A tile is done or not: nothing panics between here and the end.
            let mut film = film.lock().unwrap_or_else(PoisonError::into_inner);
            tile.put_to(sums, &mut film.pixels, &region, color);
        });
        let film = film.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(Rendered { film, complete, statistics })
    }

    fn sample_rows(
        &self,
        rows: Range<u32>,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError> {
        let size = control.size_of(self);
        check_rows(&rows, size.1)?;
        self.sample_region(&Region::whole(size).rows(&rows), samples, control)
    }

    fn sample_region(
        &self,
        region: &Region,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError> {
        check_region(region, control.size_of(self))?;
        check_samples(&samples, control.samples_of(self))?;
        let sums = Mutex::new(SampleSums::new(region.width, region.height));
        let frame = self.frame(control)?;
        let (complete, statistics) = self.trace_tiles(&frame, *region, samples, control, &|tile, of_tile| {
            let mut sums = sums.lock().unwrap_or_else(PoisonError::into_inner);
            tile.copy_to(of_tile, &mut sums.sums, region);
        });
        let sums = sums.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(Sampled { sums, complete, statistics })
    }
}

impl PreparedCpu {
    fn frame<'a>(&'a self, control: &RenderControl<'a>) -> Result<CpuFrame<'a>, BackendError> {
        CpuFrame::new((&self.scene, &self.hierarchy), &self.shaped, control.frame, &self.pool)
    }

    /// Takes samples of a region, tile by tile. `store` is told the sums of each tile, row after row. Whether all tiles were done.
    fn trace_tiles(
        &self,
        frame: &CpuFrame<'_>,
        region: Region,
        samples: Range<u32>,
        control: &RenderControl,
        store: &(dyn Fn(Tile, &[ExactSum]) + Sync),
    ) -> (bool, RayStatistics) {
        let (view, hierarchies) = (frame.view(), frame.hierarchies());
        let pixels_total = region.pixels();
        let tiling = Tiling::for_threads(region, self.tile, self.pool.current_num_threads());
        let all = Mutex::new(RayStatistics::default());
        let (pixels_done, rays) = (AtomicU64::new(0), AtomicU64::new(0));
        // A tile takes one and gives it back: there are as many as tiles in work at one time.
        let workspaces = Mutex::new(Vec::<Workspace>::new());
        let lock_workspaces = || workspaces.lock().unwrap_or_else(PoisonError::into_inner);
        self.pool.install(|| {
            (0..tiling.len()).into_par_iter().with_max_len(1).for_each(|number| {
                let tile = tiling.tile(number);
                let (cancel, count_work) = (control.cancel, control.count_work);
                let scheduler = self.scheduler;
                let job = TileJob { tile, samples: samples.clone(), cancel, count_work, scheduler };
                let mut workspace = lock_workspaces().pop().unwrap_or_default();
                let traced = dispatch::render_tile(&view, hierarchies, &job, &mut workspace, self.simd);
                if traced.is_some() {
                    store(tile, &workspace.sums);
                }
                lock_workspaces().push(workspace);
                let Some(statistics) = traced else { return };
                *all.lock().unwrap_or_else(PoisonError::into_inner) += statistics;
                let done = pixels_done.fetch_add(tile.pixels(), Ordering::Relaxed) + tile.pixels();
                let rays =
                    rays.fetch_add(statistics.total_rays(), Ordering::Relaxed) + statistics.total_rays();
                (control.on_progress)(Progress { pixels_done: done, pixels_total, rays });
            });
        });
        let statistics = all.into_inner().unwrap_or_else(PoisonError::into_inner);
        (pixels_done.into_inner() == pixels_total, statistics)
    }
}
