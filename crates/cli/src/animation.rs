//! From a prepared scene to the files of its frames: some are in work at the same time, so that no device waits while a
//! picture is developed and written.

use crate::failure::Failure;
use crate::interrupt;
use crate::progress::ProgressView;
use eosphor::{Film, Moments, PreparedScene, Progress, RayStatistics, RenderControl};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Where frames go to.
pub(crate) trait FrameSink: Sync {
    /// A frame that is whole. Called from several threads, in any order.
    fn take(&self, frame: u32, film: Film) -> Result<(), Failure>;

    /// Asked before a frame is rendered. `false`: it is somebody else's.
    fn claim(&self, _frame: u32) -> Result<bool, Failure> {
        Ok(true)
    }
}

/// A frame that is done, for logs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameDone {
    pub(crate) frame: u32,
    /// That it was rendered for, without developing and writing.
    pub(crate) milliseconds: f64,
    pub(crate) statistics: RayStatistics,
}

/// Frames to be rendered.
pub(crate) struct FramesJob<'a> {
    pub(crate) prepared: &'a dyn PreparedScene,
    pub(crate) moments: &'a Moments<'a>,
    /// Which ones, in order.
    pub(crate) frames: &'a [u32],
    /// How many are in work at the same time.
    pub(crate) in_flight: usize,
    /// Count and time what rays need.
    pub(crate) count_work: bool,
    /// One frame is rendered at a time, while others are developed and written: its time is its own then.
    pub(crate) one_at_a_time: bool,
    /// Told of each frame that is done, in their order.
    pub(crate) log: &'a (dyn Fn(FrameDone) -> Result<(), Failure> + Sync),
}

/// What was done.
pub(crate) struct FramesDone {
    /// How many frames are whole.
    pub(crate) count: usize,
    /// How many were somebody else's.
    pub(crate) left: usize,
    pub(crate) statistics: RayStatistics,
}

/// What the workers share.
struct State {
    /// Of frames that wait for those before them; `None` inside where they were somebody else's.
    waiting: Vec<Option<Option<FrameDone>>>,
    /// How many have been logged.
    logged: usize,
    count: usize,
    left: usize,
    statistics: RayStatistics,
    failure: Option<Failure>,
}

impl FramesJob<'_> {
    /// Renders all of them, or, after Ctrl-C, those that are begun and can be ended.
    pub(crate) fn run(&self, sink: &dyn FrameSink, view: &ProgressView) -> Result<FramesDone, Failure> {
        let state = Mutex::new(State {
            waiting: vec![None; self.frames.len()],
            logged: 0,
            count: 0,
            left: 0,
            statistics: RayStatistics::default(),
            failure: None,
        });
        let (next, stop, turn) = (AtomicUsize::new(0), AtomicBool::new(false), Mutex::new(()));
        let (pixels, rays) = (AtomicU64::new(0), AtomicU64::new(0));
        let work = || {
            while !stop.load(Ordering::Relaxed) && !interrupt::cancel().asked().load(Ordering::Relaxed) {
                let number = next.fetch_add(1, Ordering::Relaxed);
                let Some(&frame) = self.frames.get(number) else { break };
                // No more than so many can be in work beside this one.
                let left = self.frames.len() - number - 1;
                self.prepared.frames_left(left.min(self.in_flight.saturating_sub(1)));
                let done = match sink.claim(frame) {
                    Ok(true) => {
                        self.render(frame, sink, view, (&pixels, &rays), &turn).map(|done| done.map(Some))
                    }
                    Ok(false) => Ok(Some(None)),
                    Err(failure) => Err(failure),
                };
                let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
                let result = match done {
                    Ok(Some(statistics)) => self.note(&mut state, number, statistics),
                    // Interrupted.
                    Ok(None) => break,
                    Err(failure) => Err(failure),
                };
                if let Err(failure) = result {
                    stop.store(true, Ordering::Relaxed);
                    state.failure.get_or_insert(failure);
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
        let state = state.into_inner().unwrap_or_else(PoisonError::into_inner);
        match state.failure {
            Some(failure) => Err(failure),
            None => Ok(FramesDone { count: state.count, left: state.left, statistics: state.statistics }),
        }
    }

    /// `None` after Ctrl-C.
    fn render(
        &self,
        frame: u32,
        sink: &dyn FrameSink,
        view: &ProgressView,
        (pixels, rays): (&AtomicU64, &AtomicU64),
        turn: &Mutex<()>,
    ) -> Result<Option<(RayStatistics, f64)>, Failure> {
        let moment = self.moments.at(frame)?;
        let (width, height) = self.prepared.size();
        let pixels_total = u64::from(width) * u64::from(height) * self.frames.len() as u64;
        let before = Mutex::new((0, 0));
        let on_progress = |progress: Progress| {
            // Reports of one frame may overtake each other.
            let mut before = before.lock().unwrap_or_else(PoisonError::into_inner);
            let newly =
                (progress.pixels_done.saturating_sub(before.0), progress.rays.saturating_sub(before.1));
            *before = (before.0 + newly.0, before.1 + newly.1);
            view.update(Progress {
                pixels_done: pixels.fetch_add(newly.0, Ordering::Relaxed) + newly.0,
                pixels_total,
                rays: rays.fetch_add(newly.1, Ordering::Relaxed) + newly.1,
            });
        };
        let cancel = interrupt::cancel().asked();
        let (count_work, moment) = (self.count_work, Some(&moment));
        let control = RenderControl { on_progress: &on_progress, cancel, count_work, moment };
        let (rendered, milliseconds) = {
            let _mine = self.one_at_a_time.then(|| turn.lock().unwrap_or_else(PoisonError::into_inner));
            let start = Instant::now();
            (self.prepared.render(&control)?, start.elapsed().as_secs_f64() * 1e3)
        };
        if !rendered.complete {
            return Ok(None);
        }
        sink.take(frame, rendered.film)?;
        Ok(Some((rendered.statistics, milliseconds)))
    }

    /// Logs what can be logged in order.
    fn note(
        &self,
        state: &mut State,
        number: usize,
        done: Option<(RayStatistics, f64)>,
    ) -> Result<(), Failure> {
        match done {
            Some((statistics, _)) => {
                state.count += 1;
                state.statistics += statistics;
            }
            None => state.left += 1,
        }
        let frame = self.frames[number];
        let line =
            |(statistics, milliseconds): (RayStatistics, f64)| FrameDone { frame, milliseconds, statistics };
        state.waiting[number] = Some(done.map(line));
        while let Some(Some(done)) = state.waiting.get(state.logged).copied() {
            state.logged += 1;
            if let Some(done) = done {
                (self.log)(done)?;
            }
        }
        Ok(())
    }
}
