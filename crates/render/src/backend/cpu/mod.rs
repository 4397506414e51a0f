//! The CPU backend: tiles over all cores, with one SIMD dispatch a tile.

mod dispatch;
mod options;
mod tile;

pub use options::{CpuOptions, SimdLevel};

use super::{Backend, BackendError, PreparedScene, Progress, RenderControl, Rendered, check_scene};
use crate::{Film, Hierarchy, HierarchyStatistics, RayStatistics};
use dispatch::TileJob;
use eosphor_scene::SceneData;
use rayon::prelude::*;
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
        if options.tile == 0 {
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
}

impl Backend for CpuBackend {
    fn describe(&self) -> String {
        format!("CPU, {} threads, {}", self.threads(), self.simd)
    }

    fn prepare(&self, scene: Arc<SceneData>) -> Result<Box<dyn PreparedScene>, BackendError> {
        check_scene(&scene)?;
        let hierarchy = self.pool.install(|| Hierarchy::build(self.options.accel, &scene));
        let prepared = PreparedCpu {
            scene,
            hierarchy,
            simd: self.simd,
            tile: self.options.tile,
            pool: Arc::clone(&self.pool),
        };
        Ok(Box::new(prepared))
    }
}

struct PreparedCpu {
    scene: Arc<SceneData>,
    hierarchy: Hierarchy,
    simd: SimdLevel,
    tile: u32,
    pool: Arc<rayon::ThreadPool>,
}

impl PreparedScene for PreparedCpu {
    fn hierarchy_statistics(&self) -> HierarchyStatistics {
        self.hierarchy.statistics()
    }

    fn render(&self, control: &RenderControl) -> Result<Rendered, BackendError> {
        let (width, height) = (self.scene.settings.width, self.scene.settings.height);
        let view = self.scene.view();
        let pixels_total = width as u64 * height as u64;
        let film = Mutex::new((Film::new(width, height), RayStatistics::default()));
        let (pixels_done, rays) = (AtomicU64::new(0), AtomicU64::new(0));
        let tiling = Tiling::new(width, height, self.tile);
        self.pool.install(|| {
            (0..tiling.len()).into_par_iter().with_max_len(1).for_each(|number| {
                let tile = tiling.tile(number);
                let job = TileJob { tile, cancel: control.cancel, count_work: control.count_work };
                let Some((colors, statistics)) =
                    dispatch::render_tile(&view, &self.hierarchy, &job, self.simd)
                else {
                    return;
                };
                {
                    // A tile is done or not: nothing panics between here and the end of the block.
                    let mut guard = film.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
                    tile.copy_to(&colors, &mut guard.0);
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
