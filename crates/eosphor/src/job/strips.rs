//! From a prepared scene to the file of a still: strips of rows are rendered and written one after another, so that a picture
//! of any size takes the memory of one strip, and what is done is kept while it goes on.

use super::output::OpenOutput;
use super::seconds::{process_cpu_seconds, timed};
use super::{Event, JobControl, JobError, Output, StillSeconds, files};
use eosphor_picture::output::{OutputError, SaveOptions, ShareHeader, ShareWriter, partial_path};
use eosphor_picture::still::{Checkpoint, Strip, StripPlan};
use eosphor_render::{
    BackendError, FeatureRows, Film, PreparedScene, Progress, RayStatistics, RenderControl, Sampled,
};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long a piece of work should take: who cancels waits for its end, and threads wait for each other there.
const PIECE: Duration = Duration::from_secs(3);

/// What is done of a piece is lost where the program is killed, so that several must fit between two checkpoints: also where
/// its samples take some times as long as those before, as at the upper edge of a thing of glass.
const PIECES_A_CHECKPOINT: u32 = 12;

/// A strip is written so many pixels at a time, which take memory that lies in the cache, again and again. (New memory for a whole
/// film took longer than making one.)
const PIXELS_AT_A_TIME: u32 = 1 << 17;

/// What a picture is rendered for.
pub(super) enum Product {
    /// Where it goes, and how each is saved.
    Pictures(Vec<(Output, SaveOptions)>),
    /// Some of its samples: what is kept is all that is wanted.
    Samples,
    /// A share of its rows, and its file.
    Rows(PathBuf, Box<ShareHeader>),
}

/// What makes the layers of some rows.
pub(super) type Features<'a> = Box<dyn Fn(Range<u32>) -> Result<FeatureRows, BackendError> + 'a>;

/// A picture, or a share of one, to be rendered and written, or some of its samples to be kept.
pub(super) struct Strips<'a> {
    pub(super) prepared: &'a dyn PreparedScene,
    /// Where the file has layers.
    pub(super) features: Option<Features<'a>>,
    /// Count nodes and tests.
    pub(super) count_work: bool,
    /// Rows that are in memory at a time.
    pub(super) most_rows: u32,
    pub(super) checkpoint_interval: Duration,
    /// The samples of each pixel: all of them, or a share.
    pub(super) samples: Range<u32>,
    pub(super) control: &'a JobControl<'a>,
}

/// What was done.
pub(super) struct Done {
    /// Every pixel has all its samples.
    pub(super) complete: bool,
    /// Share of the samples that are done, 0 to 1. Where it is 0, nothing was written.
    pub(super) done: f64,
    /// The share that an earlier run had done.
    pub(super) resumed: f64,
    /// Where it is not complete: the file that keeps what is done.
    pub(super) kept: Option<PathBuf>,
    /// The files that were written: the outputs, or partial pictures beside them.
    pub(super) written: Vec<PathBuf>,
    /// Rays and work of this run.
    pub(super) statistics: RayStatistics,
}

/// The progress of a render, and how the rest of it is planned.
struct State {
    plan: StripPlan,
    checkpoint: Checkpoint,
    /// Samples of all pixels together.
    samples_done: u64,
    samples_total: u64,
    /// What layers take for a sample of a pixel; 0 until it is known.
    layer_seconds: f64,
    statistics: RayStatistics,
}

/// A file in the making.
enum Writer {
    Picture(OpenOutput),
    Rows(ShareWriter),
}

impl Writer {
    fn write_rows(&mut self, film: &Film, features: Option<&FeatureRows>) -> Result<(), OutputError> {
        match self {
            Writer::Picture(writer) => writer.write_rows(film, features),
            Writer::Rows(writer) => writer.write_rows(film, features),
        }
    }

    /// Ends the file; one that is not complete gets another name, where there are partial ones of its kind.
    fn end(self, complete: bool) -> Result<(), OutputError> {
        match self {
            Writer::Picture(writer) => writer.end(complete),
            Writer::Rows(writer) if complete => writer.finish(),
            Writer::Rows(_) => Ok(()),
        }
    }

    fn is_stream(&self) -> bool {
        match self {
            Writer::Picture(writer) => writer.is_stream(),
            Writer::Rows(_) => false,
        }
    }
}

impl Strips<'_> {
    /// Renders and writes all of it, or, where it is cancelled, writes what is done beside it.
    pub(super) fn run(
        &self,
        mut product: Product,
        checkpoint: Checkpoint,
        seconds: &mut StillSeconds,
    ) -> Result<Done, JobError> {
        let (width, height) = self.prepared.size();
        let busy = self.prepared.pixels_at_a_time();
        let before = checkpoint.samples_done();
        let mut state = State {
            plan: StripPlan::new((width, height), self.most_rows, busy, self.piece().as_secs_f64()),
            samples_done: before,
            samples_total: u64::from(width) * u64::from(height) * self.samples.len() as u64,
            checkpoint,
            layer_seconds: 0.0,
            statistics: RayStatistics::default(),
        };
        let names = Names::of(&product);
        let is_samples = matches!(product, Product::Samples);
        let (mut writers, mut row) = (Vec::new(), 0);
        if let Product::Rows(..) = product {
            writers = self.open(&mut product)?;
        }
        self.control.tell(Event::RenderBegins);
        let complete = loop {
            if row == height {
                break true;
            }
            let mut strip = self.begin(row, &mut state)?;
            let features = self.features_of(&strip, &mut state, seconds)?;
            let complete = self.take_samples(&mut strip, &mut state, seconds);
            if !matches!(complete, Ok(true)) {
                self.keep(Some(&strip), &mut state);
            }
            let complete = complete.map_err(|error| still_there(error.into(), &state.checkpoint))?;
            if strip.samples > 0 && !is_samples {
                timed(&mut seconds.write, || {
                    if writers.is_empty() {
                        writers = self.open(&mut product)?;
                    }
                    write_rows(&strip, features.as_ref(), &mut writers)
                })?;
            }
            row = strip.rows.end;
            if !complete {
                break false;
            }
            state.checkpoint.take(strip);
            if is_samples && let Some(error) = state.checkpoint.failure() {
                // Nobody would have the picture of it.
                return Err(still_there(error.into(), &state.checkpoint));
            }
            self.keep_if_due(None, &mut state);
        };
        self.control.tell(Event::RenderEnds);
        // Files first: whoever reads a stream may have closed it.
        writers.sort_by_key(Writer::is_stream);
        for writer in writers {
            timed(&mut seconds.write, || writer.end(complete))?;
        }
        let total = state.samples_total;
        let (done, resumed) = (share(state.samples_done, total), share(before, total));
        let (statistics, written) = (state.statistics, names.written(complete, &state.checkpoint));
        let mut kept = None;
        if !complete {
            kept = state.checkpoint.is_kept().then(|| state.checkpoint.path().to_owned());
        } else if is_samples {
            timed(&mut seconds.write, || state.checkpoint.complete())?;
        } else if state.checkpoint.remove() {
            // They showed the beginning of this picture.
            files::remove_all(&names.partials());
        }
        Ok(Done { complete, done, resumed, kept, written, statistics })
    }

    /// Begins the strip whose first row is `row`. If the checkpoint has it, the strip starts with the samples from
    /// there. If not, a new strip is planned that ends before the next one of the checkpoint.
    fn begin(&self, row: u32, state: &mut State) -> Result<Strip, JobError> {
        let (width, height) = self.prepared.size();
        match state.checkpoint.rows_from(row) {
            Ok(rows) => Ok(state.checkpoint.strip(rows)?),
            Err(next) => {
                let mut rows = state.plan.rows(row, next.unwrap_or(height), self.samples.len() as u32);
                if self.features.is_some() {
                    // Layers of a strip are one piece of work, of which half the time is planned for: these rows may cost more than
                    // the last ones. Those of one row tell what they cost.
                    let row_seconds = state.layer_seconds * f64::from(width) * self.samples.len() as f64;
                    let is_known = state.layer_seconds > 0.0;
                    let most =
                        if is_known { (0.5 * self.piece().as_secs_f64() / row_seconds) as u32 } else { 1 };
                    rows.end = rows.end.min(rows.start.saturating_add(most.max(1)));
                }
                Ok(Strip::new(width, rows))
            }
        }
    }

    /// Before the colours: where it is cancelled in the middle of these, what is done of them has its layers. What is done of other
    /// strips does not wait for them.
    fn features_of(
        &self,
        strip: &Strip,
        state: &mut State,
        seconds: &mut StillSeconds,
    ) -> Result<Option<FeatureRows>, JobError> {
        let Some(features) = &self.features else { return Ok(None) };
        let units = (strip.pixels() * self.samples.len() as u64).max(1) as f64;
        if state.checkpoint.is_due(self.piece() + Duration::from_secs_f64(state.layer_seconds * units)) {
            self.keep(None, state);
        }
        let start = Instant::now();
        let rows = timed(seconds.layers.get_or_insert_default(), || features(strip.rows.clone()))?;
        // (The next rows may cost more than these: strips at most double.)
        state.layer_seconds = (start.elapsed().as_secs_f64() / units).max(0.5 * state.layer_seconds);
        self.keep_if_due(None, state);
        Ok(Some(rows))
    }

    /// Takes the samples that a strip lacks. Not all of them where it is cancelled.
    fn take_samples(
        &self,
        strip: &mut Strip,
        state: &mut State,
        seconds: &mut StillSeconds,
    ) -> Result<bool, BackendError> {
        let samples = self.samples.len() as u32;
        while strip.samples < samples {
            if self.control.cancel.is_asked() {
                return Ok(false);
            }
            let count = state.plan.samples(strip.pixels(), samples - strip.samples);
            let range = strip.samples..strip.samples + count;
            let start = Instant::now();
            let sampled = self.sample(strip.rows.clone(), range.clone(), state, seconds)?;
            state.statistics += sampled.statistics;
            if !sampled.complete {
                return Ok(false);
            }
            let units = strip.pixels() * u64::from(count);
            state.plan.learn(units, start.elapsed().as_secs_f64());
            strip.add(range, sampled.sums);
            state.samples_done += units;
            if strip.samples < samples {
                self.keep_if_due(Some(strip), state);
            }
        }
        Ok(true)
    }

    /// Some samples of some rows, by their numbers among those that are wanted.
    fn sample(
        &self,
        rows: Range<u32>,
        samples: Range<u32>,
        state: &State,
        seconds: &mut StillSeconds,
    ) -> Result<Sampled, BackendError> {
        let all = self.samples.len() as u64;
        let samples = self.samples.start + samples.start..self.samples.start + samples.end;
        let taken = samples.len() as u64;
        let rays = state.statistics.total_rays();
        let control = RenderControl {
            on_progress: &|progress| {
                (self.control.on_progress)(Progress {
                    pixels_done: (state.samples_done + progress.pixels_done * taken) / all,
                    pixels_total: state.samples_total / all,
                    rays: rays + progress.rays,
                })
            },
            cancel: self.control.cancel.overdue(),
            count_work: self.count_work,
            frame: None,
        };
        let cpu_before = process_cpu_seconds();
        let sampled = timed(&mut seconds.render, || self.prepared.sample_rows(rows, samples, &control))?;
        if let (Some(before), Some(after)) = (cpu_before, process_cpu_seconds()) {
            *seconds.render_cpu.get_or_insert_default() += after - before;
        }
        Ok(sampled)
    }

    /// Begins the files. There is nothing left of the product then.
    fn open(&self, product: &mut Product) -> Result<Vec<Writer>, OutputError> {
        let size = self.prepared.size();
        match std::mem::replace(product, Product::Samples) {
            Product::Pictures(outputs) => outputs
                .into_iter()
                .map(|(output, options)| Ok(Writer::Picture(output.open(size, &options, self.control)?)))
                .collect(),
            Product::Samples => Ok(Vec::new()),
            Product::Rows(file, header) => {
                let writer = ShareWriter::open(&file, &header)?;
                self.control.tell(Event::FileBegun(writer.temporary_path()));
                Ok(vec![Writer::Rows(writer)])
            }
        }
    }

    fn keep_if_due(&self, in_work: Option<&Strip>, state: &mut State) {
        if state.checkpoint.is_due(self.piece()) {
            self.keep(in_work, state);
        }
    }

    /// Writes what is done. Where that fails, the render goes on all the same.
    fn keep(&self, in_work: Option<&Strip>, state: &mut State) {
        state.checkpoint.write(in_work);
        match state.checkpoint.failure() {
            Some(error) => self.control.tell(Event::CheckpointFailed(&error)),
            None => {
                let done = share(state.checkpoint.samples_done(), state.samples_total);
                self.control.tell(Event::CheckpointWritten { done });
            }
        }
    }

    /// How long a piece of work should take.
    fn piece(&self) -> Duration {
        PIECE.min(self.checkpoint_interval / PIECES_A_CHECKPOINT)
    }
}

/// Writes the rows of a strip. Those of a strip with layers all at once.
fn write_rows(
    strip: &Strip,
    features: Option<&FeatureRows>,
    writers: &mut [Writer],
) -> Result<(), OutputError> {
    let (width, height) = (strip.sums.width, strip.sums.height);
    let rows = if features.is_some() { height } else { (PIXELS_AT_A_TIME / width).max(1) };
    for first in (0..height).step_by(rows as usize) {
        let film = strip.film(first..height.min(first.saturating_add(rows)));
        writers.iter_mut().try_for_each(|writer| writer.write_rows(&film, features))?;
    }
    Ok(())
}

/// The files of a product, by name.
struct Names {
    /// Paths of the pictures; those in the making get other names.
    pictures: Vec<PathBuf>,
    /// Path of the file of a share of rows.
    rows: Option<PathBuf>,
    is_samples: bool,
}

impl Names {
    fn of(product: &Product) -> Names {
        let (mut pictures, mut rows, mut is_samples) = (Vec::new(), None, false);
        match product {
            Product::Pictures(outputs) => {
                pictures.extend(outputs.iter().filter_map(|(output, _)| output.path().map(Path::to_owned)));
            }
            Product::Samples => is_samples = true,
            Product::Rows(file, _) => rows = Some(file.clone()),
        }
        Names { pictures, rows, is_samples }
    }

    fn partials(&self) -> Vec<PathBuf> {
        self.pictures.iter().map(|file| partial_path(file)).collect()
    }

    /// Those that are there at the end.
    fn written(&self, complete: bool, checkpoint: &Checkpoint) -> Vec<PathBuf> {
        match (self.is_samples, complete) {
            (true, _) => vec![checkpoint.path().to_owned()],
            (false, true) => self.pictures.iter().chain(&self.rows).cloned().collect(),
            (false, false) => self.partials(),
        }
    }
}

/// So many samples as a share of all.
pub(super) fn share(samples: u64, total: u64) -> f64 {
    samples as f64 / total.max(1) as f64
}

/// With what is left of a still that failed.
fn still_there(error: JobError, checkpoint: &Checkpoint) -> JobError {
    match checkpoint.is_kept() {
        true => JobError::StillKept { error: Box::new(error), checkpoint: checkpoint.path().to_owned() },
        false => error,
    }
}
