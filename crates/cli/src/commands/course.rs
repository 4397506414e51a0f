//! `eosphor course`: the task of PLATO's course, by its own input and output.

use super::frames::{check_output, interruption, is_video};
use crate::arguments::CourseFlags;
use crate::backend::ranks_or_own;
use crate::failure::Failure;
use crate::flag_hints::RESUME;
use crate::interrupt;
use crate::streams::{self, Verbosity};
use crate::watcher::Watcher;
#[cfg(feature = "video")]
use eosphor::job::Video;
use eosphor::job::{self, FileOptions, FrameDone, FrameNames, JobControl, JobError, MadeFrom};
use eosphor::job::{Sequence, SequenceOutcome};
use eosphor::{Backend, CourseInput, CourseLines, CourseOptions, SceneError};
use std::fmt::Display;
use std::io::{Read, stdin};
use std::path::Path;

/// What errors call the input.
const INPUT: &str = "standard input";

/// Most bytes of an input.
const MAX_INPUT_BYTES: u64 = 1 << 20;

/// `ranks` is the backend where there are several.
pub(crate) fn course(flags: &CourseFlags, ranks: Option<&dyn Backend>) -> Result<(), Failure> {
    let video = flags.output.as_deref().filter(|output| is_video(output));
    flags.check(video.is_some())?;
    if flags.default {
        return streams::result(&CourseInput::colourful().to_string());
    }
    if let Some(output) = video {
        check_output(output)?;
    }
    let (mut input, lines) = read_input()?;
    if let Some(output) = flags.output.as_deref().filter(|_| video.is_none()) {
        let not_unicode = || {
            format!("-o: {}: paths of numbered frames must be Unicode: choose another one", output.display())
        };
        let path = output.to_str().ok_or_else(|| Failure::Usage(not_unicode()))?;
        input.output = path.parse().map_err(Failure::usage)?;
    }
    let defaults = CourseOptions::default();
    let options = CourseOptions {
        shapes: flags.bodies.map_or(defaults.shapes, |bodies| bodies.0),
        diodes: flags.edge_lights,
        texture_memory_bytes: flags.textures.memory_bytes(),
        ..defaults
    };
    interrupt::watch(Verbosity::Normal)?;
    let loaded = input.scene(&options).map_err(|error| match of_texture(&error, &input) {
        true => in_input(lines.texture, "texture of the floor", &error),
        false => error.into(),
    })?;
    let scene = loaded.scene;
    flags.device.check_paths()?;
    let backend = ranks_or_own(ranks, &flags.device(), flags.accel, false, Verbosity::Normal)?;
    if video.is_none() {
        job::check_output(&input.output.path(0)).map_err(|error| match flags.output {
            Some(_) => Failure::of_output(error),
            None => in_input(lines.output, "output path", &error),
        })?;
    }
    // Where frames are written says nothing of what they show: their folder may be moved, and its path be written otherwise.
    let shown = CourseInput { output: CourseInput::colourful().output, ..input.clone() };
    let sequence = Sequence {
        resume: flags.resume,
        file: FileOptions { metadata: false, ..FileOptions::default() },
        // Ranks render frames at the same time, each for itself.
        one_at_a_time: ranks.is_none(),
        made_from: Some(MadeFrom {
            motion: format!("{shown} {:?} {}", flags.bodies, flags.edge_lights),
            files: "course".into(),
        }),
        ..Sequence::new(&scene, &*backend)
    };
    let notes = loaded.warnings.iter().map(ToString::to_string).collect();
    let watcher = Watcher::with_log(notes, &log);
    let outcome = watcher.run(|control| write(flags, &input, &sequence, control));
    if let Some(failure) = watcher.take_failure() {
        return Err(still_there(failure, outcome.ok()));
    }
    let outcome = outcome?;
    match outcome.complete {
        true => Ok(()),
        false => {
            let state = interruption(&outcome, flags.is_piped(), false);
            Err(Failure::Interrupted(format!("interrupted: {state}")))
        }
    }
}

fn write(
    flags: &CourseFlags,
    input: &CourseInput,
    sequence: &Sequence,
    control: &JobControl,
) -> Result<SequenceOutcome, JobError> {
    match flags.output.as_deref().filter(|output| is_video(output)) {
        #[cfg(feature = "video")]
        Some(output) => {
            let defaults = Video::new(output);
            let video = Video {
                frame_rate: Some(flags.fps.unwrap_or(24.0)),
                quality: flags.video_quality.unwrap_or(defaults.quality),
                by_ffmpeg: flags.ffmpeg,
                ..defaults
            };
            sequence.write_video(&video, control)
        }
        _ => {
            let pattern = input.output.clone();
            let names = FrameNames::new(Path::new(&pattern.to_string()), move |frame| pattern.path(frame));
            sequence.write_frames(&names, control)
        }
    }
}

/// With what is left where a line of the log could not be written.
fn still_there(failure: Failure, outcome: Option<SequenceOutcome>) -> Failure {
    match (failure, outcome) {
        (Failure::Failed(line), Some(outcome)) if outcome.kept + outcome.done > 0 => {
            let (count, all) = (outcome.kept + outcome.done, outcome.wanted);
            Failure::Failed(format!("{line}; {count} of {all} frames are done: {RESUME}"))
        }
        (failure, _) => failure,
    }
}

/// A line for each frame: its number, milliseconds and rays.
fn log(done: &FrameDone) -> Result<(), Failure> {
    let rays = done.statistics.total_rays();
    streams::result(&format!("{}\t{:.3}\t{rays}\n", done.frame, done.milliseconds))
}

impl CourseFlags {
    /// Whether the program ffmpeg encodes, which keeps nothing.
    fn is_piped(&self) -> bool {
        #[cfg(feature = "video")]
        return self.ffmpeg;
        #[cfg(not(feature = "video"))]
        return false;
    }
}

/// Something that is wrong with what the input names, at its line.
fn in_input(line: u32, field: &str, error: &dyn Display) -> Failure {
    Failure::Failed(format!("{INPUT}:{line}: {field}: {error}"))
}

/// Whether an error is about the picture of the floor.
fn of_texture(error: &SceneError, input: &CourseInput) -> bool {
    let path = match error {
        SceneError::Read { path, .. } => path,
        SceneError::Invalid { place, .. } => &place.path,
        _ => return false,
    };
    path == Path::new(&input.floor.texture)
}

/// Standard input, which must end somewhere.
fn read_input() -> Result<(CourseInput, CourseLines), Failure> {
    let mut bytes = Vec::new();
    let read = stdin().lock().take(MAX_INPUT_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|error| Failure::Failed(format!("cannot read the input: standard input: {error}")))?;
    if bytes.len() as u64 > MAX_INPUT_BYTES {
        return Err(Failure::Failed("the input is too long: it must end within 1 MB".into()));
    }
    CourseInput::parse_with_lines(&bytes, Path::new(INPUT)).map_err(|error| {
        match names_video(&bytes, &error) {
            true => Failure::Failed(format!("{error} (a video is written by --output)")),
            false => error.into(),
        }
    })
}

/// Whether an error is about an output path, the second word of the input, that is meant for a video.
fn names_video(input: &[u8], error: &SceneError) -> bool {
    if !error.to_string().contains("output path") {
        return false;
    }
    let path = input.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).nth(1);
    path.is_some_and(|path| path.to_ascii_lowercase().ends_with(b".mp4"))
}
