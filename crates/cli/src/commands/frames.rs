//! `eosphor render SCENE -o frame_%04d.png`: the frames of an animation.

use crate::animation::{FrameSink, FramesDone, FramesJob};
use crate::arguments::RenderFlags;
use crate::command_line::command_line_without;
use crate::failure::Failure;
use crate::progress::ProgressView;
use crate::streams::{self, Verbosity};
use crate::text::grouped;
use eosphor::frames::{FramePattern, FramesIdentity, Manifest};
use eosphor::{Backend, Film, Format, Moments, SaveOptions, Scene, SceneData, save, scene_hash};
use serde::Serialize;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

/// Frames in work at the same time: one is rendered, one developed and written, one begun.
const IN_FLIGHT: u16 = 3;

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
}

/// Whether several pictures are asked for.
pub(super) fn are_asked_for(flags: &RenderFlags) -> bool {
    flags.animation.frames.is_some() || FramePattern::is_one(&flags.output)
}

pub(super) fn render_frames(
    flags: &RenderFlags,
    backend: &dyn Backend,
    scene: &Scene,
    data: Arc<SceneData>,
    options: SaveOptions,
) -> Result<(), Failure> {
    let start = Instant::now();
    let pattern = FramePattern::new(&flags.output).map_err(Failure::usage)?;
    let range = range(flags, scene)?;
    let verbosity = flags.report.verbosity();
    let identity = identity(flags, scene, &data, &options)?;
    let manifest = Manifest::open(&pattern.manifest_path(), &identity, flags.animation.resume)
        .map_err(Failure::because)?;
    let all = range.len();
    let missing: Vec<u32> = range.filter(|&frame| !manifest.is_done(frame, &pattern.path(frame))).collect();
    let kept = all - missing.len();
    if kept > 0 {
        verbosity.say(Verbosity::Normal, &format!("eosphor: note: {kept} of {all} frames are done already"));
    }
    let prepared = backend.prepare(Arc::clone(&data))?;
    let moments = Moments::new(scene, &data);
    let sink = Files { pattern: &pattern, manifest: &manifest, options: &options };
    let view = ProgressView::new(verbosity);
    let job = FramesJob {
        prepared: &*prepared,
        moments: &moments,
        frames: &missing,
        in_flight: flags.animation.in_flight.unwrap_or(IN_FLIGHT).into(),
        log: &|_| Ok(()),
    };
    let done = job.run(&sink, &view);
    view.finish();
    let FramesDone { count, statistics } = done?;
    let seconds = start.elapsed().as_secs_f64();
    let output = flags.output.display().to_string();
    if count < missing.len() {
        return Err(Failure::Interrupted(format!(
            "interrupted: {output}: {} of {all} frames are done: the same with --resume goes on",
            kept + count
        )));
    }
    let report = Report {
        frames: count,
        kept,
        backend: backend.describe(),
        total_rays: statistics.total_rays(),
        seconds,
        frames_per_second: if seconds > 0.0 { count as f64 / seconds } else { 0.0 },
        output,
    };
    let text = format!(
        "{}: {count} frames on {} in {seconds:.2} s: {:.2} a second, {} rays",
        report.output,
        report.backend,
        report.frames_per_second,
        grouped(report.total_rays),
    );
    verbosity.say(Verbosity::Normal, &text);
    if flags.report.json {
        streams::json(&report)?;
    }
    Ok(())
}

/// The frames that are asked for; all where no range is given.
fn range(flags: &RenderFlags, scene: &Scene) -> Result<Range<u32>, Failure> {
    let Some(animation) = &scene.animation else {
        let message = format!(
            "nothing moves in this scene: {} needs an animation: give the scene one, or --orbit with a number of frames",
            flags.output.display()
        );
        return Err(Failure::Usage(message));
    };
    match &flags.animation.frames {
        None => Ok(0..animation.frames),
        Some(range) if range.0.end <= animation.frames => Ok(range.0.clone()),
        Some(range) => Err(Failure::Usage(format!(
            "--frames {}..{}: the animation has {} frames, 0..{}",
            range.0.start, range.0.end, animation.frames, animation.frames
        ))),
    }
}

fn identity(
    flags: &RenderFlags,
    scene: &Scene,
    data: &SceneData,
    options: &SaveOptions,
) -> Result<FramesIdentity, Failure> {
    let format = Format::of(&flags.output)?;
    let scene_hash = scene_hash(data, &options.develop);
    let SaveOptions { develop: _, jpeg_quality, exr_half, layers: _, metadata } = options;
    // Not the command line: threads and devices change no pixel.
    let metadata = (&metadata.scene_hash, metadata.command_line.is_some());
    Ok(FramesIdentity {
        scene: scene_hash,
        animation: FramesIdentity::hash(&format!("{:?}", scene.animation)),
        file: FramesIdentity::hash(&format!("{format:?} {jpeg_quality} {exr_half} {metadata:?}")),
    })
}

/// What the files say of themselves: the command line without what an undisturbed run lacks.
pub(super) fn command_line_of_frames() -> String {
    command_line_without("--resume")
}

/// Numbered files.
struct Files<'a> {
    pattern: &'a FramePattern,
    manifest: &'a Manifest,
    options: &'a SaveOptions,
}

impl FrameSink for Files<'_> {
    fn take(&self, frame: u32, film: Film) -> Result<(), Failure> {
        let path = self.pattern.path(frame);
        save(&film, &path, self.options)?;
        self.manifest.note(frame, &path).map_err(Failure::because)
    }
}
