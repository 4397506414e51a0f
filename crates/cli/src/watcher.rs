//! Watching a job: its events become lines on stderr, its progress a bar.

use crate::failure::Failure;
use crate::interrupt;
use crate::progress::ProgressView;
use crate::streams::Verbosity;
use eosphor::Note;
use eosphor::job::{Event, JobControl, JobError};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Notes that are shown without `-v`.
const SHOWN_NOTES: usize = 10;

/// Watches one job.
pub(crate) struct Watcher {
    verbosity: Verbosity,
    view: OnceLock<ProgressView>,
    /// Of loading, and then of flattening.
    notes: Mutex<Vec<String>>,
}

impl Watcher {
    /// Of a job whose scene is loaded, with what that had to say.
    pub(crate) fn new(verbosity: Verbosity, notes: Vec<String>) -> Watcher {
        Watcher { verbosity, view: OnceLock::new(), notes: Mutex::new(notes) }
    }

    /// Runs the job.
    pub(crate) fn run<T>(&self, job: impl FnOnce(&JobControl) -> Result<T, JobError>) -> Result<T, Failure> {
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
        Ok(done?)
    }

    /// Shows what loading and flattening had to say.
    pub(crate) fn tell(&self, notes: &[Note]) {
        let mut all = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        all.extend(notes.iter().map(ToString::to_string));
        show_notes(&all, self.verbosity);
    }

    fn end_view(&self) {
        if let Some(view) = self.view.get() {
            view.finish();
        }
    }

    /// What loading and flattening had to say.
    pub(crate) fn into_notes(self) -> Vec<String> {
        self.notes.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    fn event(&self, event: Event) {
        let note = |text: String| self.verbosity.say(Verbosity::Normal, &format!("eosphor: note: {text}"));
        match event {
            Event::Flattened(notes) => self.tell(notes),
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
            Event::RenderBegins => {
                self.view.get_or_init(|| ProgressView::new(self.verbosity));
            }
            Event::RenderEnds => self.end_view(),
        }
    }
}

fn show_notes(notes: &[String], verbosity: Verbosity) {
    let shown = if verbosity == Verbosity::Verbose { notes.len() } else { SHOWN_NOTES };
    for note in notes.iter().take(shown) {
        verbosity.say(Verbosity::Normal, &format!("eosphor: note: {note}"));
    }
    if notes.len() > shown {
        let rest = notes.len() - shown;
        verbosity.say(Verbosity::Normal, &format!("eosphor: note: {rest} more notes; -v shows all"));
    }
}
