//! Watching a job: its events become lines on stderr, its progress a bar.

use crate::failure::Failure;
use crate::interrupt;
use crate::progress::ProgressView;
use crate::streams::Verbosity;
use eosphor::job::{Event, FrameDone, JobControl, JobError};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Notes that are shown without `-v`.
const SHOWN_NOTES: usize = 10;

/// A line of a log.
type Log<'a> = &'a (dyn Fn(&FrameDone) -> Result<(), Failure> + Sync);

/// Watches one job.
pub(crate) struct Watcher<'a> {
    verbosity: Verbosity,
    view: OnceLock<ProgressView>,
    /// Notes of loading, and then of flattening.
    notes: Mutex<Vec<String>>,
    /// Told of each frame, instead of a view of the progress.
    log: Option<Log<'a>>,
    /// Why the log could not be written.
    failure: Mutex<Option<Failure>>,
}

impl<'a> Watcher<'a> {
    /// A watcher of a job whose scene is loaded; `notes` are what loading had to say.
    pub(crate) fn new(verbosity: Verbosity, notes: Vec<String>) -> Watcher<'a> {
        Watcher {
            verbosity,
            view: OnceLock::new(),
            notes: Mutex::new(notes),
            log: None,
            failure: Mutex::new(None),
        }
    }

    /// A watcher that logs frames instead of showing the progress.
    pub(crate) fn with_log(notes: Vec<String>, log: Log<'a>) -> Watcher<'a> {
        Watcher { log: Some(log), ..Watcher::new(Verbosity::Normal, notes) }
    }

    /// Runs the job.
    pub(crate) fn run<T>(&self, job: impl FnOnce(&JobControl) -> Result<T, JobError>) -> Result<T, JobError> {
        let on_progress = |progress| {
            if let Some(view) = self.view.get() {
                view.update(progress);
            }
        };
        let on_event = |event: Event| self.event(event);
        let control =
            JobControl { on_progress: &on_progress, on_event: &on_event, cancel: interrupt::cancel() };
        let done = job(&control);
        // A job that fails does not say that rendering has ended.
        self.end_view();
        done
    }

    /// What loading and flattening had to say.
    pub(crate) fn into_notes(self) -> Vec<String> {
        self.notes.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// Why the log could not be written, if so. The job was cancelled then.
    pub(crate) fn take_failure(&self) -> Option<Failure> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    fn event(&self, event: Event) {
        let note = |text: String| self.verbosity.say(Verbosity::Normal, &format!("eosphor: note: {text}"));
        match event {
            Event::Flattened(notes) => {
                let mut all = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
                all.extend(notes.iter().map(ToString::to_string));
                self.show_notes(&all);
            }
            Event::Resumed { done } => {
                note(format!("{} % of the samples are done already", (1000.0 * done).floor() / 10.0));
            }
            Event::NothingToResume { checkpoint } => note(format!(
                "{} is not there, or has nothing yet: the picture is rendered from its beginning",
                checkpoint.display()
            )),
            Event::CheckpointFound { checkpoint } => note(format!(
                "{} is of a render that ended early: --resume would go on with it",
                checkpoint.display()
            )),
            Event::CheckpointWritten { done } => {
                let line = format!("kept: {:.2} % of the samples", 100.0 * done);
                self.verbosity.say(Verbosity::Verbose, &line);
            }
            Event::CheckpointFailed(error) => note(error.to_string()),
            Event::FileBegun(file) => interrupt::note_unfinished(file),
            Event::FramesKept { kept, all } => note(format!("{kept} of {all} frames are done already")),
            Event::VideoIsWhole(video) => note(format!("{} is done already", video.display())),
            Event::VideoPadded { size: (width, height) } => note(format!(
                "videos have even sides: this one has {width} x {height}, with the last row or column twice"
            )),
            Event::RenderBegins => {
                if self.log.is_none() {
                    self.view.get_or_init(|| ProgressView::new(self.verbosity));
                }
            }
            Event::FrameDone(done) => {
                if let Some(Err(failure)) = self.log.map(|log| log(done)) {
                    interrupt::cancel().ask();
                    let mut first = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
                    first.get_or_insert(failure);
                }
            }
            Event::RenderEnds => self.end_view(),
        }
    }

    fn end_view(&self) {
        if let Some(view) = self.view.get() {
            view.finish();
        }
    }

    fn show_notes(&self, notes: &[String]) {
        let is_long = self.log.is_none() && self.verbosity != Verbosity::Verbose;
        let shown = if is_long { SHOWN_NOTES } else { notes.len() };
        for note in notes.iter().take(shown) {
            self.verbosity.say(Verbosity::Normal, &format!("eosphor: note: {note}"));
        }
        if notes.len() > shown {
            let rest = notes.len() - shown;
            self.verbosity.say(Verbosity::Normal, &format!("eosphor: note: {rest} more notes; -v shows all"));
        }
    }
}
