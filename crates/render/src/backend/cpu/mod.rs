//! The CPU backend: tiles over all cores, with one SIMD dispatch a tile.

mod batched;
mod dispatch;
mod features;
mod measure;
mod options;
mod queries;
mod rays;
mod tile;

pub use eosphor_accel::SimdLevel;
pub use features::FeaturePass;
pub use measure::CameraSpeed;
pub use options::{CpuOptions, Scheduler};
pub(crate) use queries::{Queries, with_level};

use super::{
    Backend, BackendError, PreparedScene, Progress, RenderControl, Rendered, check_rows, check_scene,
};
use crate::{Film, Hierarchy, HierarchyStatistics, RayStatistics};
use batched::Workspace;
use dispatch::TileJob;
use eosphor_accel::Builder;
use eosphor_scene::{Moment, SceneData};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use tile::Tiling;

/// Renders on the cores of the CPU.
pub struct CpuBackend {
    options: CpuOptions,
    simd: SimdLevel,
    pool: Arc<rayon::ThreadPool>,
}

impl CpuBackend {
    /// With these options. Fails where the CPU lacks the SIMD level asked for or threads cannot be started.
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

    /// Threads that render.
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
        let build = || Arc::new(self.build(&scene));
        let hierarchy = hierarchy.unwrap_or_else(build);
        let (simd, tile, pool) = (self.simd, self.options.tile, Arc::clone(&self.pool));
        Ok(FeaturePass { scene, hierarchy, simd, tile, pool })
    }

    fn build(&self, scene: &SceneData) -> Hierarchy {
        let CpuOptions { accel, builder, .. } = self.options;
        self.pool.install(|| Hierarchy::build(accel, builder, scene))
    }
}

impl Backend for CpuBackend {
    fn describe(&self) -> String {
        format!("CPU, {} threads, {}", self.threads(), self.simd)
    }

    fn prepare(&self, scene: Arc<SceneData>) -> Result<Box<dyn PreparedScene>, BackendError> {
        check_scene(&scene)?;
        let hierarchy = self.build(&scene);
        let prepared = PreparedCpu {
            scene,
            hierarchy: Arc::new(hierarchy),
            simd: self.simd,
            tile: self.options.tile,
            scheduler: self.options.scheduler,
            pool: Arc::clone(&self.pool),
        };
        Ok(Box::new(prepared))
    }
}

/// The top level of a moment's own, where instances are elsewhere then.
fn top_of(hierarchy: &Hierarchy, moment: Option<&Moment>, pool: &rayon::ThreadPool) -> Option<Hierarchy> {
    let places = moment?.places.as_ref()?;
    // It is built again for each frame, and most have few instances.
    let build = || Hierarchy::build_top(hierarchy.accel(), Builder::Binned, &places.instances);
    Some(pool.install(build))
}

struct PreparedCpu {
    scene: Arc<SceneData>,
    hierarchy: Arc<Hierarchy>,
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

    fn render_rows(&self, rows: Range<u32>, control: &RenderControl) -> Result<Rendered, BackendError> {
        let (width, height) = self.size();
        check_rows(&rows, height)?;
        let view = self.scene.view_at(control.moment);
        let top = top_of(&self.hierarchy, control.moment, &self.pool);
        let hierarchies = (&*self.hierarchy, top.as_ref().unwrap_or(&self.hierarchy));
        let tiling = Tiling::for_threads(width, rows.clone(), self.tile, self.pool.current_num_threads());
        let film = Film::new(width, rows.end - rows.start);
        let pixels_total = film.pixels.len() as u64;
        let film = Mutex::new((film, RayStatistics::default()));
        let (pixels_done, rays) = (AtomicU64::new(0), AtomicU64::new(0));
        // A tile takes one and gives it back: there are as many as tiles in work at one time.
        let workspaces = Mutex::new(Vec::<Workspace>::new());
        let lock_workspaces = || workspaces.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        self.pool.install(|| {
            (0..tiling.len()).into_par_iter().with_max_len(1).for_each(|number| {
                let tile = tiling.tile(number);
                let (cancel, count_work) = (control.cancel, control.count_work);
                let job = TileJob { tile, cancel, count_work, scheduler: self.scheduler };
                let mut workspace = lock_workspaces().pop().unwrap_or_default();
                let rendered = dispatch::render_tile(&view, hierarchies, &job, &mut workspace, self.simd);
                lock_workspaces().push(workspace);
                let Some((colors, statistics)) = rendered else {
                    return;
                };
                {
                    // A tile is done or not: nothing panics between here and the end of the block.
                    let mut guard = film.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
                    tile.copy_to(&colors, &mut guard.0.pixels, width, rows.start);
                    guard.1 += statistics;
                }
                let done = pixels_done.fetch_add(tile.pixels(), Ordering::Relaxed) + tile.pixels();
                let rays =
                    rays.fetch_add(statistics.total_rays(), Ordering::Relaxed) + statistics.total_rays();
                (control.on_progress)(Progress { pixels_done: done, pixels_total, rays });
            });
        });
        let (film, statistics) = film.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
        Ok(Rendered { film, complete: pixels_done.into_inner() == pixels_total, statistics })
    }
}
