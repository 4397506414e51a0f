//! All ranks as one backend: what rank 0's command renders with.
//!
//! The command runs on a thread of its own, and knows nothing of ranks. Its calls go to the thread that has MPI
//! ([`super::lead`]) and come back as pixels.

use super::follow::Prepared;
use super::wire::{self, Unit};
use eosphor::{
    Backend, BackendError, Film, Hierarchy, HierarchyStatistics, PreparedScene, Progress, RayStatistics,
    RenderControl, Rendered, SceneData, check_rows,
};
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Units a rank of a picture that nothing comes after: the last ones are small then.
const UNITS_A_RANK: u32 = 32;

/// Units have at least so many samples, on CPUs and on GPUs, which are idle with fewer,
const LEAST_SAMPLES: [u32; 2] = [1 << 13, 1 << 20];
/// and at least so many pixels.
const LEAST_PIXELS: [u32; 2] = [1 << 10, 1 << 13];

/// Asks the thread with MPI to get all ranks ready for a scene.
pub(super) struct Request {
    pub(super) scene: Arc<SceneData>,
    /// What is to be rendered then, until nobody can send more.
    pub(super) units: Receiver<Submission>,
    pub(super) reply: Sender<Result<Crew, BackendError>>,
}

/// A unit, and where its rows go to. They are dropped where they are not rendered.
pub(super) struct Submission {
    pub(super) unit: Vec<u8>,
    pub(super) reply: Sender<(u32, Vec<u8>)>,
    pub(super) first_row: u32,
}

/// All ranks, when they are ready.
pub(super) struct Crew {
    /// Rank 0's own, when it is there.
    pub(super) local: Arc<Prepared>,
    pub(super) size: (u32, u32),
    /// Of a pixel.
    pub(super) samples: u32,
    pub(super) description: String,
    pub(super) ranks: u32,
    pub(super) are_gpus: bool,
}

/// All ranks.
pub(crate) struct ClusterBackend {
    requests: Mutex<Sender<Request>>,
    ranks: u32,
    description: OnceLock<String>,
}

impl ClusterBackend {
    pub(super) fn new(requests: Sender<Request>, ranks: u32) -> ClusterBackend {
        ClusterBackend { requests: Mutex::new(requests), ranks, description: OnceLock::new() }
    }
}

fn gone() -> BackendError {
    BackendError::Failed("the other ranks are gone".into())
}

impl Backend for ClusterBackend {
    fn describe(&self) -> String {
        self.description.get().cloned().unwrap_or_else(|| format!("{} ranks", self.ranks))
    }

    /// So many that no rank waits for a frame to be developed and written.
    fn frames_in_flight(&self) -> usize {
        3 * self.ranks as usize + 3
    }

    fn prepare(&self, scene: Arc<SceneData>) -> Result<Box<dyn PreparedScene>, BackendError> {
        let ((submit, units), (reply, answer)) = (channel(), channel());
        let requests = self.requests.lock().unwrap_or_else(PoisonError::into_inner);
        requests.send(Request { scene, units, reply }).map_err(|_| gone())?;
        drop(requests);
        let crew = answer.recv().map_err(|_| gone())??;
        let _ = self.description.set(crew.description.clone());
        Ok(Box::new(PreparedCluster { crew, submit: Mutex::new(submit), frames_left: AtomicU32::new(0) }))
    }
}

struct PreparedCluster {
    crew: Crew,
    submit: Mutex<Sender<Submission>>,
    /// Frames that are still to be begun.
    frames_left: AtomicU32,
}

impl PreparedScene for PreparedCluster {
    fn hierarchy_statistics(&self) -> HierarchyStatistics {
        match self.crew.local.wait() {
            Ok(scene) => scene.hierarchy_statistics(),
            // All ranks end for that.
            Err(_) => HierarchyStatistics::default(),
        }
    }

    fn hierarchy(&self) -> Option<Arc<Hierarchy>> {
        self.crew.local.wait().as_ref().ok()?.hierarchy()
    }

    fn size(&self) -> (u32, u32) {
        self.crew.size
    }

    fn render_rows(&self, rows: Range<u32>, control: &RenderControl) -> Result<Rendered, BackendError> {
        let (width, height) = self.size();
        check_rows(&rows, height)?;
        self.render_units(width, rows, control)
    }

    fn frames_left(&self, frames: usize) {
        self.frames_left.store(frames.try_into().unwrap_or(u32::MAX), Ordering::Relaxed);
    }
}

impl PreparedCluster {
    fn render_units(
        &self,
        width: u32,
        rows: Range<u32>,
        control: &RenderControl,
    ) -> Result<Rendered, BackendError> {
        let (reply, results) = channel();
        let step = self.rows_of_unit(width, rows.end - rows.start);
        for first_row in rows.clone().step_by(step as usize) {
            let unit = Unit {
                rows: first_row..rows.end.min(first_row.saturating_add(step)),
                count_work: control.count_work,
                moment: control.moment.cloned(),
            };
            let unit = wire::encode(&unit).map_err(BackendError::Failed)?;
            let submission = Submission { unit, reply: reply.clone(), first_row };
            let submit = self.submit.lock().unwrap_or_else(PoisonError::into_inner);
            submit.send(submission).map_err(|_| gone())?;
        }
        drop(reply);

        let mut film = Film::new(width, rows.end - rows.start);
        let (mut complete_pixels, mut statistics) = (0, RayStatistics::default());
        let pixels_total = film.pixels.len() as u64;
        // It ends when every unit has been answered or dropped.
        for (first_row, bytes) in results {
            let unit = wire::decode_result(&bytes).map_err(BackendError::Failed)?;
            let start = (first_row - rows.start) as usize * width as usize;
            let place = film.pixels.get_mut(start..start + unit.film.pixels.len());
            place.ok_or_else(gone)?.copy_from_slice(&unit.film.pixels);
            statistics += unit.statistics;
            if unit.complete {
                complete_pixels += unit.film.pixels.len() as u64;
            }
            let (pixels_done, rays) = (complete_pixels, statistics.total_rays());
            (control.on_progress)(Progress { pixels_done, pixels_total, rays });
        }
        Ok(Rendered { film, complete: complete_pixels == pixels_total, statistics })
    }

    /// While many frames are to come, a unit is a whole one; of the last ones, and of a picture alone, all ranks have shares,
    /// the smaller the less there is after them.
    fn rows_of_unit(&self, width: u32, rows: u32) -> u32 {
        let (ranks, left) = (self.crew.ranks, self.frames_left.load(Ordering::Relaxed));
        if left >= 2 * ranks {
            return rows;
        }
        let units = ranks * (UNITS_A_RANK / (left + 1)).max(1);
        let kind = usize::from(self.crew.are_gpus);
        let least = LEAST_PIXELS[kind].max(LEAST_SAMPLES[kind] / self.crew.samples.max(1));
        rows.div_ceil(units).max(least.div_ceil(width)).max(1)
    }
}
