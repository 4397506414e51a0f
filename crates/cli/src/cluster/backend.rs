//! All ranks as one backend: what rank 0's command renders with.
//!
//! The command runs on a thread of its own, and knows nothing of ranks. Its calls go to the thread that has MPI
//! ([`super::coordinator`]) and come back as pixels.

use super::wire::{self, Unit};
use super::worker::Prepared;
use eosphor::{
    Backend, BackendError, Film, Hierarchy, HierarchyStatistics, PreparedScene, Progress, RayStatistics,
    RenderControl, Rendered, SampleSums, Sampled, SceneData, check_rows, check_samples,
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

/// How many pixels keep a rank busy, on CPUs and on GPUs.
const BUSY_PIXELS: [u32; 2] = [1 << 13, 1 << 20];

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
    /// Samples of each pixel.
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

    fn samples(&self) -> u32 {
        self.crew.samples
    }

    fn pixels_at_a_time(&self) -> u64 {
        u64::from(self.crew.ranks) * u64::from(BUSY_PIXELS[usize::from(self.crew.are_gpus)])
    }

    fn render_rows(&self, rows: Range<u32>, control: &RenderControl) -> Result<Rendered, BackendError> {
        let (width, height) = control.size_of(self);
        check_rows(&rows, height)?;
        let mut film = Film::new(width, rows.end - rows.start);
        let step = self.rows_of_unit(width, rows.end - rows.start, control.samples_of(self));
        let units = units(rows.clone(), step, None);
        let (complete, statistics) = self.run(units, (rows, width), control, |start, bytes| {
            let unit = wire::decode_film(bytes).map_err(BackendError::Failed)?;
            let place = film.pixels.get_mut(start..start + unit.film.pixels.len());
            place.ok_or_else(gone)?.copy_from_slice(&unit.film.pixels);
            Ok((unit.complete.then_some(unit.film.pixels.len() as u64), unit.statistics))
        })?;
        Ok(Rendered { film, complete, statistics })
    }

    fn sample_rows(
        &self,
        rows: Range<u32>,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError> {
        let (width, height) = control.size_of(self);
        check_rows(&rows, height)?;
        check_samples(&samples, control.samples_of(self))?;
        let mut sums = SampleSums::new(width, rows.end - rows.start);
        let count = samples.len() as u32;
        let step = self.rows_of_unit(width, rows.end - rows.start, count);
        let shares = self.shares_of_samples(rows.len() as u32, width, step, count);
        let mut units = Vec::new();
        for share in 0..shares {
            let at =
                |share: u32| samples.start + (u64::from(count) * u64::from(share) / u64::from(shares)) as u32;
            units.extend(self::units(rows.clone(), step, Some(at(share)..at(share + 1))));
        }
        let (complete, statistics) = self.run(units, (rows, width), control, |start, bytes| {
            let unit = wire::decode_sums(bytes).map_err(BackendError::Failed)?;
            let place = sums.sums.get_mut(start..start + unit.sums.sums.len()).ok_or_else(gone)?;
            place.iter_mut().zip(&unit.sums.sums).for_each(|(sum, other)| sum.merge(other));
            Ok((unit.complete.then_some(unit.sums.sums.len() as u64), unit.statistics))
        })?;
        Ok(Sampled { sums, complete, statistics })
    }

    fn frames_left(&self, frames: usize) {
        self.frames_left.store(frames.try_into().unwrap_or(u32::MAX), Ordering::Relaxed);
    }
}

/// Rows in units of so many, with some samples or colours.
fn units(rows: Range<u32>, step: u32, samples: Option<Range<u32>>) -> Vec<(Range<u32>, Option<Range<u32>>)> {
    let unit = |first: u32| (first..rows.end.min(first.saturating_add(step)), samples.clone());
    rows.clone().step_by(step as usize).map(unit).collect()
}

impl PreparedCluster {
    /// Lets ranks render units; `take` is given the bytes of each and the number of its first pixel, and says how many pixels
    /// are done, if all of the unit is, and by which rays. Whether all were.
    fn run(
        &self,
        units: Vec<(Range<u32>, Option<Range<u32>>)>,
        (rows, width): (Range<u32>, u32),
        control: &RenderControl,
        mut take: impl FnMut(usize, &[u8]) -> Result<(Option<u64>, RayStatistics), BackendError>,
    ) -> Result<(bool, RayStatistics), BackendError> {
        let (reply, results) = channel();
        let pixels = |rows: &Range<u32>| rows.len() as u64 * u64::from(width);
        let all: u64 = units.iter().map(|(rows, _)| pixels(rows)).sum();
        for (rows, samples) in units {
            let first_row = rows.start;
            let (count_work, state) = (control.count_work, control.frame.cloned());
            let unit = wire::encode(&Unit { rows, samples, count_work, frame: state })
                .map_err(BackendError::Failed)?;
            let submission = Submission { unit, reply: reply.clone(), first_row };
            let submit = self.submit.lock().unwrap_or_else(PoisonError::into_inner);
            submit.send(submission).map_err(|_| gone())?;
        }
        drop(reply);

        let (mut done, mut statistics) = (0, RayStatistics::default());
        let pixels_total = pixels(&rows);
        // It ends when every unit has been answered or dropped.
        for (first_row, bytes) in results {
            let (pixels, rays) = take((first_row - rows.start) as usize * width as usize, &bytes)?;
            statistics += rays;
            done += pixels.unwrap_or(0);
            // (Where units share the samples of pixels, these count by and by.)
            let pixels_done = (u128::from(done) * u128::from(pixels_total) / u128::from(all.max(1))) as u64;
            (control.on_progress)(Progress { pixels_done, pixels_total, rays: statistics.total_rays() });
        }
        Ok((done == all, statistics))
    }

    /// While many frames are to come, a unit is a whole one; of the last ones, and of a picture alone, all ranks have shares,
    /// the smaller the less there is after them.
    fn rows_of_unit(&self, width: u32, rows: u32, samples: u32) -> u32 {
        let (ranks, left) = (self.crew.ranks, self.frames_left.load(Ordering::Relaxed));
        if left >= 2 * ranks {
            return rows;
        }
        let units = ranks * (UNITS_A_RANK / (left + 1)).max(1);
        let kind = usize::from(self.crew.are_gpus);
        let least = LEAST_PIXELS[kind].max(LEAST_SAMPLES[kind] / samples.max(1));
        rows.div_ceil(units).max(least.div_ceil(width)).max(1)
    }

    /// How many units share the samples of each pixel: where rows alone give too few.
    fn shares_of_samples(&self, rows: u32, width: u32, step: u32, samples: u32) -> u32 {
        let wanted = (self.crew.ranks * UNITS_A_RANK).div_ceil(rows.div_ceil(step));
        let least = LEAST_SAMPLES[usize::from(self.crew.are_gpus)];
        let units = u64::from(step.min(rows)) * u64::from(width) * u64::from(samples) / u64::from(least);
        wanted.min(units.max(1).min(u64::from(samples)) as u32).max(1)
    }
}
