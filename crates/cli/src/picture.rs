//! From a prepared scene to the file of a still: strips of rows are rendered and written one after another, so that a picture
//! of any size takes the memory of one strip, and what is done is kept while it goes on.

use crate::failure::Failure;
use crate::interrupt;
use crate::progress::ProgressView;
use crate::report::{Seconds, timed};
use crate::streams::Verbosity;
use crate::target::Target;
use crate::text::ratio;
use cpu_time::ProcessTime;
use eosphor::shares::{ShareHeader, ShareWriter};
use eosphor::still::{Checkpoint, Strip, StripPlan};
use eosphor::{BackendError, FeatureRows, Film, OutputError, PictureWriter, PreparedScene, Progress};
use eosphor::{RayStatistics, RenderControl, Sampled, SaveOptions, partial_path};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// How long a piece of work should take: a signal waits for its end, and threads wait for each other there.
const PIECE: Duration = Duration::from_secs(3);

/// What is done of a piece is lost where the program is killed, so that several must fit between two checkpoints: also where
/// its samples take some times as long as those before, as at the upper edge of a thing of glass.
const PIECES_A_CHECKPOINT: u32 = 12;

/// What a picture is rendered for.
#[derive(Clone, Copy)]
pub(crate) enum Product<'a> {
    /// Where it goes, and how each is saved.
    Pictures(&'a [(Target, SaveOptions)]),
    /// Some of its samples: what is kept is all that is wanted.
    Samples,
    /// A share of its rows, and its file.
    Rows(&'a Path, &'a ShareHeader),
}

/// What makes the layers of some rows.
pub(crate) type Features<'a> = Box<dyn Fn(Range<u32>) -> Result<FeatureRows, BackendError> + 'a>;

/// A picture, or a share of one, to be rendered and written, or some of its samples to be kept.
pub(crate) struct PictureJob<'a> {
    pub(crate) prepared: &'a dyn PreparedScene,
    /// Where the file has layers.
    pub(crate) features: Option<Features<'a>>,
    pub(crate) product: Product<'a>,
    /// Count nodes and tests.
    pub(crate) count_work: bool,
    /// Rows that are in memory at a time.
    pub(crate) most_rows: u32,
    pub(crate) checkpoint_interval: Duration,
    /// The samples of each pixel: all of them, or a share.
    pub(crate) samples: Range<u32>,
    pub(crate) verbosity: Verbosity,
}

/// What was done.
pub(crate) struct Done {
    /// Every pixel has all its samples.
    pub(crate) complete: bool,
    /// Share of the samples that are done, 0 to 1. Where it is 0, nothing was written.
    pub(crate) share: f64,
    /// The share that an earlier run had done.
    pub(crate) resumed: f64,
    /// Where it is not complete: the file that keeps what is done.
    pub(crate) kept: Option<PathBuf>,
    /// The files that were written: the outputs, or partial pictures beside them; standard output is not among them.
    pub(crate) written: Vec<PathBuf>,
    /// Of this run.
    pub(crate) statistics: RayStatistics,
}

/// How far it is.
struct State {
    plan: StripPlan,
    checkpoint: Checkpoint,
    view: ProgressView,
    /// Samples of all pixels together.
    samples_done: u64,
    samples_total: u64,
    /// What layers take for a sample of a pixel; 0 until it is known.
    layer_seconds: f64,
    statistics: RayStatistics,
}

/// A file in the making.
enum Writer<'a> {
    Picture(&'a Target, PictureWriter),
    Rows(ShareWriter),
}

impl Writer<'_> {
    fn write_rows(&mut self, film: &Film, features: Option<&FeatureRows>) -> Result<(), OutputError> {
        match self {
            Writer::Picture(_, writer) => writer.write_rows(film, features),
            Writer::Rows(writer) => writer.write_rows(film, features),
        }
    }

    /// Ends the file; one that is not complete gets another name, where there are partial ones of its kind.
    fn end(self, complete: bool) -> Result<(), OutputError> {
        match self {
            Writer::Picture(_, writer) if complete => writer.finish(),
            Writer::Picture(Target::File(file, _), writer) => writer.finish_partial(&partial_path(file)),
            // Whoever reads a stream wants whole pictures.
            Writer::Picture(Target::Stdout(_), _) => Ok(()),
            Writer::Rows(writer) if complete => writer.finish(),
            Writer::Rows(_) => Ok(()),
        }
    }

    fn is_stream(&self) -> bool {
        matches!(self, Writer::Picture(Target::Stdout(_), _))
    }
}

impl<'a> PictureJob<'a> {
    /// Renders and writes all of it, or, after a signal, writes what is done beside it.
    pub(crate) fn run(
        &self,
        checkpoint: Checkpoint,
        view: ProgressView,
        seconds: &mut Seconds,
    ) -> Result<Done, Failure> {
        let (width, height) = self.prepared.size();
        let busy = self.prepared.pixels_at_a_time();
        let samples_total = u64::from(width) * u64::from(height) * self.samples.len() as u64;
        let before = checkpoint.samples_done();
        let mut state = State {
            plan: StripPlan::new((width, height), self.most_rows, busy, self.piece().as_secs_f64()),
            samples_done: before,
            samples_total,
            checkpoint,
            view,
            layer_seconds: 0.0,
            statistics: RayStatistics::default(),
        };
        let is_samples = matches!(self.product, Product::Samples);
        let (mut writers, mut row) = (Vec::new(), 0);
        if let Product::Rows(..) = self.product {
            writers = self.open(width, height)?;
        }
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
            let complete = complete.map_err(|failure| still_there(failure, &state.checkpoint))?;
            if strip.samples > 0 && !is_samples {
                timed(&mut seconds.write, || {
                    if writers.is_empty() {
                        writers = self.open(width, height)?;
                    }
                    let film = strip.film();
                    writers.iter_mut().try_for_each(|writer| writer.write_rows(&film, features.as_ref()))
                })?;
            }
            row = strip.rows.end;
            if !complete {
                break false;
            }
            state.checkpoint.take(strip);
            if is_samples && let Some(error) = state.checkpoint.failure() {
                // Nobody would have the picture of it.
                return Err(still_there(Failure::because(error), &state.checkpoint));
            }
            self.keep_if_due(None, &mut state);
        };
        let share = |samples: u64| samples as f64 / samples_total.max(1) as f64;
        state.view.finish();
        let files: Vec<&Path> = match self.product {
            Product::Pictures(outputs) => outputs.iter().filter_map(|(target, _)| target.file()).collect(),
            Product::Samples | Product::Rows(..) => Vec::new(),
        };
        let partials: Vec<PathBuf> = files.iter().map(|file| partial_path(file)).collect();
        let written = match self.product {
            Product::Samples => vec![state.checkpoint.path().to_owned()],
            Product::Rows(file, _) if complete => vec![file.to_owned()],
            _ if complete => files.into_iter().map(PathBuf::from).collect(),
            _ => partials.clone(),
        };
        // Files first: whoever reads a stream may have closed it.
        writers.sort_by_key(Writer::is_stream);
        for writer in writers {
            timed(&mut seconds.write, || writer.end(complete))?;
        }
        let mut kept = None;
        if !complete {
            kept = state.checkpoint.is_kept().then(|| state.checkpoint.path().to_owned());
        } else if is_samples {
            timed(&mut seconds.write, || state.checkpoint.complete()).map_err(Failure::because)?;
        } else if state.checkpoint.remove() {
            // They showed the beginning of this picture.
            partials.iter().for_each(|partial| drop(std::fs::remove_file(partial)));
        }
        let (share, resumed, statistics) = (share(state.samples_done), share(before), state.statistics);
        Ok(Done { complete, share, resumed, kept, written, statistics })
    }

    /// The next strip, with what is done of it.
    fn begin(&self, row: u32, state: &mut State) -> Result<Strip, Failure> {
        let (width, height) = self.prepared.size();
        match state.checkpoint.rows_from(row) {
            Ok(rows) => state.checkpoint.strip(rows).map_err(Failure::because),
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

    /// Before the colours: after a signal in the middle of these, what is done of them has its layers. What is done of other
    /// strips does not wait for them.
    fn features_of(
        &self,
        strip: &Strip,
        state: &mut State,
        seconds: &mut Seconds,
    ) -> Result<Option<FeatureRows>, Failure> {
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

    /// Takes the samples that a strip lacks. Not all of them after a signal.
    fn take_samples(
        &self,
        strip: &mut Strip,
        state: &mut State,
        seconds: &mut Seconds,
    ) -> Result<bool, Failure> {
        let samples = self.samples.len() as u32;
        while strip.samples < samples {
            if interrupt::flag().load(Ordering::Relaxed) {
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
        seconds: &mut Seconds,
    ) -> Result<Sampled, Failure> {
        let all = self.samples.len() as u64;
        let samples = self.samples.start + samples.start..self.samples.start + samples.end;
        let taken = samples.len() as u64;
        let rays = state.statistics.total_rays();
        let control = RenderControl {
            on_progress: &|progress| {
                state.view.update(Progress {
                    pixels_done: (state.samples_done + progress.pixels_done * taken) / all,
                    pixels_total: state.samples_total / all,
                    rays: rays + progress.rays,
                })
            },
            cancel: interrupt::overdue(),
            count_work: self.count_work,
            moment: None,
        };
        let cpu_before = ProcessTime::try_now().ok();
        let sampled = timed(&mut seconds.render, || self.prepared.sample_rows(rows, samples, &control))?;
        if let Some(time) = cpu_before.and_then(|before| before.try_elapsed().ok()) {
            *seconds.render_cpu.get_or_insert_default() += Duration::as_secs_f64(&time);
        }
        Ok(sampled)
    }

    fn open(&self, width: u32, height: u32) -> Result<Vec<Writer<'a>>, OutputError> {
        match self.product {
            Product::Pictures(outputs) => outputs
                .iter()
                .map(|(target, options)| Ok(Writer::Picture(target, target.open((width, height), options)?)))
                .collect(),
            Product::Samples => Ok(Vec::new()),
            Product::Rows(file, header) => {
                let writer = ShareWriter::open(file, header)?;
                interrupt::note_unfinished(writer.temporary_path());
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
        let percent = 100.0 * ratio(state.checkpoint.samples_done() as f64, state.samples_total as f64);
        match state.checkpoint.failure() {
            Some(error) => self.verbosity.say(Verbosity::Normal, &format!("eosphor: note: {error}")),
            None => self.verbosity.say(Verbosity::Verbose, &format!("kept: {percent:.2} % of the samples")),
        }
    }

    /// How long a piece of work should take.
    fn piece(&self) -> Duration {
        PIECE.min(self.checkpoint_interval / PIECES_A_CHECKPOINT)
    }
}

/// With what is left of a render that failed.
fn still_there(failure: Failure, checkpoint: &Checkpoint) -> Failure {
    match failure {
        Failure::Failed(line) if checkpoint.is_kept() => {
            let kept = checkpoint.path().display();
            Failure::Failed(format!("{line}; {kept} has what was done: the same with --resume goes on"))
        }
        failure => failure,
    }
}
