//! From a prepared scene to its frames: some are in work at the same time, so that no device waits while a picture is developed
//! and written.

use super::{Event, JobControl, JobError};
use eosphor_picture::output::{DevelopSettings, Developed};
use eosphor_render::{PreparedScene, Progress, RayStatistics, RenderControl, Rendered, RenderedBytes};
use eosphor_scene::FrameStates;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Where frames go to.
pub(super) trait FrameSink: Sync {
    /// How frames are developed, where it takes nothing but their bytes; `None`: it takes films.
    fn develop(&self) -> Option<DevelopSettings>;

    /// A frame that is whole. Called from several threads, in any order.
    fn take(&self, frame: u32, picture: FramePicture) -> Result<(), JobError>;

    /// Asked before a frame is rendered. `false`: it is somebody else's.
    fn claim(&self, _frame: u32) -> Result<bool, JobError> {
        Ok(true)
    }
}

/// A frame as its sink takes it.
pub(super) enum FramePicture {
    Film(Rendered),
    Bytes(RenderedBytes),
}

impl FramePicture {
    fn render(
        prepared: &dyn PreparedScene,
        develop: Option<&DevelopSettings>,
        control: &RenderControl,
    ) -> Result<FramePicture, JobError> {
        Ok(match develop {
            None => FramePicture::Film(prepared.render(control)?),
            Some(develop) => FramePicture::Bytes(prepared.render_developed(develop, control)?),
        })
    }

    /// Whether all of it was rendered, and by which rays.
    fn done(&self) -> (bool, RayStatistics) {
        match self {
            FramePicture::Film(rendered) => (rendered.complete, rendered.statistics),
            FramePicture::Bytes(rendered) => (rendered.complete, rendered.statistics),
        }
    }

    /// Its bytes.
    pub(super) fn developed(self, develop: &DevelopSettings) -> Developed {
        match self {
            FramePicture::Film(rendered) => Developed::new(&rendered.film, develop),
            FramePicture::Bytes(rendered) => rendered.developed(),
        }
    }
}

/// A frame that is rendered and written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameDone {
    /// Number of the frame, from 0.
    pub frame: u32,
    /// Wall-clock milliseconds that it was rendered for, without writing. Where a GPU develops, that is in it; on CPUs it is not.
    pub milliseconds: f64,
    /// Rays that the frame took, and the work on them where it was counted.
    pub statistics: RayStatistics,
}

/// Frames to be rendered.
pub(super) struct Frames<'a> {
    pub(super) prepared: &'a dyn PreparedScene,
    pub(super) states: &'a FrameStates<'a>,
    /// Which ones, in order.
    pub(super) frames: &'a [u32],
    /// How many are in work at the same time.
    pub(super) in_flight: usize,
    /// Count and time what rays need.
    pub(super) count_work: bool,
    /// One frame is rendered at a time, while others are developed and written: its time is its own then.
    pub(super) one_at_a_time: bool,
    pub(super) control: &'a JobControl<'a>,
}

/// What was done, also where that failed.
#[derive(Default)]
pub(super) struct FramesDone {
    /// How many frames are whole.
    pub(super) count: usize,
    /// How many were somebody else's.
    pub(super) left: usize,
    pub(super) statistics: RayStatistics,
    /// Those that were told, in order.
    pub(super) told: Vec<FrameDone>,
    pub(super) failure: Option<JobError>,
}

impl FramesDone {
    /// With what was done of those that were somebody else's.
    pub(super) fn add(&mut self, more: FramesDone) {
        self.count += more.count;
        self.left = self.left.saturating_sub(more.count);
        self.statistics += more.statistics;
        self.told.extend(more.told);
        self.failure = self.failure.take().or(more.failure);
    }
}

/// What the workers share.
struct State {
    /// Results of frames that wait for those before them; `None` inside where another process renders the frame.
    waiting: Vec<Option<Option<FrameDone>>>,
    /// How many do not wait any more.
    passed: usize,
    done: FramesDone,
}

impl Frames<'_> {
    /// Renders all of them, or, where the job is cancelled, those that are begun and can be ended.
    pub(super) fn run(&self, sink: &dyn FrameSink) -> FramesDone {
        let waiting = vec![None; self.frames.len()];
        let state = Mutex::new(State { waiting, passed: 0, done: FramesDone::default() });
        let (next, stop, turn) = (AtomicUsize::new(0), AtomicBool::new(false), Mutex::new(()));
        let (pixels, rays) = (AtomicU64::new(0), AtomicU64::new(0));
        let work = || {
            while !stop.load(Ordering::Relaxed) && !self.control.cancel.is_asked() {
                let number = next.fetch_add(1, Ordering::Relaxed);
                let Some(&frame) = self.frames.get(number) else { break };
                // No more than so many can be in work beside this one.
                let left = self.frames.len() - number - 1;
                self.prepared.frames_left(left.min(self.in_flight.saturating_sub(1)));
                let done = match sink.claim(frame) {
                    Ok(true) => self.render(frame, sink, (&pixels, &rays), &turn).map(|done| done.map(Some)),
                    Ok(false) => Ok(Some(None)),
                    Err(error) => Err(error),
                };
                let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
                match done {
                    Ok(Some(done)) => self.note(&mut state, number, done),
                    // Cancelled.
                    Ok(None) => break,
                    Err(error) => {
                        stop.store(true, Ordering::Relaxed);
                        state.done.failure.get_or_insert(error);
                    }
                }
            }
        };
        std::thread::scope(|scope| {
            // Where no more threads can be had, fewer do.
            for _ in 1..self.in_flight.min(self.frames.len()) {
                let _ = std::thread::Builder::new().spawn_scoped(scope, work);
            }
            work();
        });
        state.into_inner().unwrap_or_else(PoisonError::into_inner).done
    }

    /// `None` where it is cancelled.
    fn render(
        &self,
        frame: u32,
        sink: &dyn FrameSink,
        (pixels, rays): (&AtomicU64, &AtomicU64),
        turn: &Mutex<()>,
    ) -> Result<Option<FrameDone>, JobError> {
        let state = self.states.at(frame)?;
        let (width, height) = self.prepared.size();
        let pixels_total = u64::from(width) * u64::from(height) * self.frames.len() as u64;
        let before = Mutex::new((0, 0));
        let on_progress = |progress: Progress| {
            // Reports of one frame may overtake each other.
            let mut before = before.lock().unwrap_or_else(PoisonError::into_inner);
            let newly =
                (progress.pixels_done.saturating_sub(before.0), progress.rays.saturating_sub(before.1));
            *before = (before.0 + newly.0, before.1 + newly.1);
            (self.control.on_progress)(Progress {
                pixels_done: pixels.fetch_add(newly.0, Ordering::Relaxed) + newly.0,
                pixels_total,
                rays: rays.fetch_add(newly.1, Ordering::Relaxed) + newly.1,
            });
        };
        let cancel = self.control.cancel.asked();
        let (count_work, state) = (self.count_work, Some(&state));
        let control = RenderControl { on_progress: &on_progress, cancel, count_work, frame: state };
        let develop = sink.develop();
        let (picture, milliseconds) = {
            let _mine = self.one_at_a_time.then(|| turn.lock().unwrap_or_else(PoisonError::into_inner));
            let start = Instant::now();
            let picture = FramePicture::render(self.prepared, develop.as_ref(), &control)?;
            (picture, start.elapsed().as_secs_f64() * 1e3)
        };
        let (complete, statistics) = picture.done();
        if !complete {
            return Ok(None);
        }
        sink.take(frame, picture)?;
        Ok(Some(FrameDone { frame, milliseconds, statistics }))
    }

    /// Tells what can be told in order.
    fn note(&self, state: &mut State, number: usize, done: Option<FrameDone>) {
        match done {
            Some(FrameDone { statistics, .. }) => {
                state.done.count += 1;
                state.done.statistics += statistics;
            }
            None => state.done.left += 1,
        }
        state.waiting[number] = Some(done);
        while let Some(Some(done)) = state.waiting.get(state.passed).copied() {
            state.passed += 1;
            if let Some(done) = done {
                self.control.tell(Event::FrameDone(&done));
                state.done.told.push(done);
            }
        }
    }
}
