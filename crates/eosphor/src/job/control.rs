//! How a job is watched and stopped.

use super::{Cancel, FrameDone};
use eosphor_picture::still::SumsError;
use eosphor_render::Progress;
use eosphor_scene::Note;
use std::fmt;
use std::path::Path;

/// How a job is watched and stopped. The default watches nothing and never stops.
#[derive(Clone, Copy)]
pub struct JobControl<'a> {
    /// Called now and then, from any thread, between [`Event::RenderBegins`] and [`Event::RenderEnds`]: pixels of the whole
    /// job, and rays of this run.
    pub on_progress: &'a (dyn Fn(Progress) + Sync),
    /// Called when something happens, from any thread.
    pub on_event: &'a (dyn Fn(Event) + Sync),
    /// Asked whether to go on.
    pub cancel: &'a Cancel,
}

/// The one of those who never stop a job.
static NEVER: Cancel = Cancel::new();

impl Default for JobControl<'_> {
    fn default() -> Self {
        JobControl { on_progress: &|_| {}, on_event: &|_| {}, cancel: &NEVER }
    }
}

impl fmt::Debug for JobControl<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("JobControl").field("cancel", self.cancel).finish_non_exhaustive()
    }
}

impl JobControl<'_> {
    pub(super) fn tell(&self, event: Event) {
        (self.on_event)(event);
    }
}

/// What happens in a job besides progress. None of it is a failure.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// The scene was flattened; this is what was done about all that it leaves open.
    Flattened(&'a [Note]),
    /// A still goes on with what an earlier run has done.
    Resumed {
        /// The share of the samples that is done, 0 to 1.
        done: f64,
    },
    /// A still was to go on, and there is nothing to go on with.
    NothingToResume {
        /// The file that would have it.
        checkpoint: &'a Path,
    },
    /// A still begins anew, though there is what an earlier run has done.
    CheckpointFound {
        /// The file that has it.
        checkpoint: &'a Path,
    },
    /// What is done of a still was written.
    CheckpointWritten {
        /// The share of the samples that is done, 0 to 1.
        done: f64,
    },
    /// What is done of a still could not be written. The render goes on, and it is tried again.
    CheckpointFailed(&'a SumsError),
    /// A temporary file was begun. Who ends the process in the middle of a job should remove it.
    FileBegun(&'a Path),
    /// Frames of an earlier run are kept.
    FramesKept {
        /// How many.
        kept: usize,
        /// How many are wanted.
        all: usize,
    },
    /// A video is whole already, and nothing is done.
    VideoIsWhole(&'a Path),
    /// A video is larger than its frames: the last row or column is there twice, since its sides are even.
    VideoPadded {
        /// Width and height of the video in pixels.
        size: (u32, u32),
    },
    /// From here on [`JobControl::on_progress`] is called.
    RenderBegins,
    /// A frame is done and written. They are told in their order.
    FrameDone(&'a FrameDone),
    /// Nothing more is rendered; files may still have to be ended.
    RenderEnds,
}
