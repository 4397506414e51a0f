//! `eosphor render SCENE -o frame_%04d.png` and `-o flight.mp4`: the frames of an animation.

use super::frames_work::FramesWork;
use crate::arguments::{OutputKind, RenderFlags};
use crate::failure::Failure;
use crate::flag_hints::{RESUME, SHARED};
use crate::streams::{self, Verbosity};
use crate::text::grouped;
use crate::watcher::Watcher;
use eosphor::frames::{FramePattern, ManifestError};
#[cfg(feature = "video")]
use eosphor::job::Video;
use eosphor::job::{self, FrameNames, JobControl, JobError, Sequence, SequenceOutcome};
use eosphor::{Backend, Scene};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What was done, for programs.
#[derive(Serialize)]
struct Report {
    output: String,
    frames: usize,
    kept: usize,
    backend: String,
    total_rays: u64,
    seconds: f64,
    frames_per_second: f64,
    /// `None` where it was not asked for.
    #[serde(flatten)]
    work: Option<FramesWork>,
}

/// Whether several pictures are asked for.
pub(super) fn are_asked_for(flags: &RenderFlags) -> bool {
    let is_one = |output: &PathBuf| FramePattern::is_one(output) || is_video(output);
    flags.animation.frames.is_some() || flags.outputs.iter().any(is_one)
}

/// What is asked for.
pub(super) fn output_kind(flags: &RenderFlags) -> OutputKind {
    match are_asked_for(flags) {
        _ if flags.outputs.iter().any(|output| is_video(output)) => OutputKind::Video,
        true => OutputKind::Frames,
        false => OutputKind::Still,
    }
}

/// Whether a file is to be a video.
pub(super) fn is_video(output: &Path) -> bool {
    output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mp4"))
}

/// Whether frames can be written there.
pub(super) fn check_output(output: &Path) -> Result<(), Failure> {
    match is_video(output) {
        true if cfg!(feature = "video") => Ok(()),
        true => Err(Failure::Usage(format!(
            "{}: this program was built without video: name frames instead, as in frame_%04d.png",
            output.display()
        ))),
        false => Ok(job::check_output(&FrameNames::pattern(output).map_err(Failure::usage)?.path(0))?),
    }
}

pub(super) fn render_frames(
    flags: &RenderFlags,
    backend: &dyn Backend,
    scene: &Scene,
    watcher: &Watcher,
) -> Result<(), Failure> {
    let sequence = Sequence {
        frames: flags.animation.frames.as_ref().map(|range| range.0.clone()),
        file: flags.file_options(),
        resume: flags.keep.resume,
        is_shared: flags.animation.share,
        in_flight: flags.animation.in_flight.map(usize::from),
        count_work: flags.report.stats,
        ..Sequence::new(scene, backend)
    };
    let outcome = watcher.run(|control| write(flags, &sequence, control));
    let outcome = outcome.map_err(|error| of_frames(error, is_video(flags.output())))?;
    if outcome.was_whole {
        return Ok(());
    }
    if !outcome.complete {
        let state = interruption(&outcome, flags.is_piped(), flags.animation.share);
        return Err(Failure::Interrupted(format!("interrupted: {}: {state}", flags.output().display())));
    }
    report(flags, scene, &backend.describe(), outcome)
}

fn write(
    flags: &RenderFlags,
    sequence: &Sequence,
    control: &JobControl,
) -> Result<SequenceOutcome, JobError> {
    #[cfg(feature = "video")]
    if is_video(flags.output()) {
        let defaults = Video::new(flags.output());
        let quality = flags.animation.video_quality.unwrap_or(defaults.quality);
        return sequence
            .write_video(&Video { quality, by_ffmpeg: flags.animation.ffmpeg, ..defaults }, control);
    }
    sequence.write_frames(&FrameNames::pattern(flags.output())?, control)
}

/// For `map_err`: frames that another process has in work, too, may be of a sequence that can be shared.
fn of_frames(error: JobError, is_video: bool) -> Failure {
    match error {
        JobError::Manifest(error @ ManifestError::InUse { is_same: true, .. }) if !is_video => {
            Failure::Failed(format!("{error}; or render other --frames, or let both --share them"))
        }
        error => error.into(),
    }
}

impl RenderFlags {
    /// Whether the program ffmpeg encodes, which keeps nothing.
    fn is_piped(&self) -> bool {
        #[cfg(feature = "video")]
        return self.animation.ffmpeg;
        #[cfg(not(feature = "video"))]
        return false;
    }
}

/// What is left of a sequence after a signal, and how it goes on.
pub(super) fn interruption(outcome: &SequenceOutcome, is_piped: bool, is_shared: bool) -> String {
    let (count, all) = (outcome.kept + outcome.done, outcome.wanted);
    match (is_piped, is_shared) {
        (true, _) => {
            format!("{count} of {all} frames were done, and none is kept: ffmpeg makes whole videos only")
        }
        (false, true) => format!("{count} of {all} frames are done: {SHARED}"),
        (false, false) => format!("{count} of {all} frames are done: {RESUME}"),
    }
}

/// Says what was rendered.
fn report(
    flags: &RenderFlags,
    scene: &Scene,
    backend: &str,
    outcome: SequenceOutcome,
) -> Result<(), Failure> {
    let SequenceOutcome { kept, done, left, frames, statistics, hierarchy, seconds, .. } = outcome;
    let work = hierarchy
        .filter(|_| flags.report.stats)
        .map(|hierarchy| FramesWork::new(&frames, statistics, hierarchy));
    let report = Report {
        output: flags.output().display().to_string(),
        frames: done,
        kept,
        backend: backend.to_owned(),
        total_rays: statistics.total_rays(),
        seconds,
        frames_per_second: if seconds > 0.0 { done as f64 / seconds } else { 0.0 },
        work,
    };
    let text = format!(
        "{}: {} frames on {} in {seconds:.2} s: {:.2} a second, {} rays",
        report.output,
        report.frames,
        report.backend,
        report.frames_per_second,
        grouped(report.total_rays),
    );
    let verbosity = flags.report.verbosity();
    verbosity.say(Verbosity::Normal, &text);
    if let Some(work) = &report.work {
        verbosity.say(Verbosity::Normal, &work.table(scene.settings.size));
    }
    if left > 0 {
        let text = format!("eosphor: note: {left} frames were done by others, or they have them in work");
        verbosity.say(Verbosity::Normal, &text);
    }
    if flags.report.json { streams::json(&report) } else { Ok(()) }
}
