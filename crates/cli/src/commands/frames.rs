//! `eosphor render SCENE -o frame_%04d.png` and `-o flight.mp4`: the frames of an animation.

use super::frames_work::FramesWork;
use crate::animation::{FrameDone, FrameSink, FramesDone, FramesJob};
use crate::arguments::{OutputKind, RenderFlags};
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::ProgressView;
use crate::streams::{self, Verbosity};
use crate::text::grouped;
use crate::watcher::Watcher;
use eosphor::frames::{FramePattern, FramesIdentity, Manifest, ManifestError, Wanted};
use eosphor::job::{check_output as check_output_file, frames_in_memory, make_folder};
use eosphor::{
    Backend, Film, Format, HierarchyStatistics, Moments, Move, RayStatistics, SaveOptions, Scene, SceneData,
    save_within, scene_hash,
};
use serde::Serialize;
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

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
        false => Ok(check_output_file(&FramePattern::new(output).map_err(Failure::usage)?.path(0))?),
    }
}

/// What there is to do, and where it goes.
pub(super) struct Sequence<'a> {
    pub(super) flags: &'a RenderFlags,
    pub(super) scene: &'a Scene,
    pub(super) data: &'a Arc<SceneData>,
    pub(super) options: &'a SaveOptions,
    /// The frames that are asked for.
    pub(super) range: Range<u32>,
}

pub(super) fn render_frames(
    flags: &RenderFlags,
    backend: &dyn Backend,
    scene: &Scene,
    watcher: &Watcher,
) -> Result<(), Failure> {
    let (data, notes) = SceneData::flatten(scene)?;
    watcher.tell(&notes);
    let data = Arc::new(data);
    let mut options = SaveOptions::from(&scene.settings);
    options.exr_half = flags.file.exr_half;
    options.jpeg_quality = flags.file.jpeg_quality.unwrap_or(options.jpeg_quality);
    let has_metadata = Format::of(flags.output()).is_ok_and(Format::has_metadata);
    if !flags.file.no_metadata && has_metadata {
        options.metadata.scene_hash = Some(scene_hash(&data, &options.develop));
    }
    let range = range(flags, scene)?;
    let sequence = Sequence { flags, scene, data: &data, options: &options, range };
    match is_video(flags.output()) {
        #[cfg(feature = "video")]
        true => super::video::render_video(&sequence, backend),
        _ => render_files(&sequence, backend),
    }
}

fn render_files(sequence: &Sequence, backend: &dyn Backend) -> Result<(), Failure> {
    let Sequence { flags, options, .. } = *sequence;
    let pattern = FramePattern::new(flags.output()).map_err(Failure::usage)?;
    let format = Format::of(flags.output())?;
    let SaveOptions { develop: _, jpeg_quality, exr_half, layers: _, alpha: _, metadata, window: _ } =
        options;
    let identity = sequence.identity(&format!("{format:?} {jpeg_quality} {exr_half} {metadata:?}"));
    let range = sequence.range.clone();
    let wanted = match flags.animation.share {
        true => Wanted::Shared(range),
        false if flags.keep.resume => Wanted::Missing(range),
        false => Wanted::Anew(range),
    };
    make_folder(flags.output())?;
    let manifest =
        Manifest::open(&pattern.manifest_path(), &identity, wanted).map_err(|error| match error {
            ManifestError::InUse { is_same: true, .. } => {
                Failure::Failed(format!("{error}; or render other --frames, or let both --share them"))
            }
            error => Failure::because(error),
        })?;
    let is_missing = |frame: &u32| !manifest.is_done(*frame, &pattern.path(*frame));
    let missing: Vec<u32> = sequence.range.clone().filter(is_missing).collect();
    let part = manifest.part();
    let sink = Files { pattern: &pattern, part: &part, manifest: &manifest, options };
    let done = sequence.render(backend, &missing, &sink, None)?;
    manifest.finish().map_err(Failure::because)?;
    done.report(sequence, backend)
}

/// What was rendered.
pub(super) struct Outcome {
    kept: usize,
    done: FramesDone,
    seconds: f64,
    /// Each frame, and what its rays went through.
    frames: Vec<FrameDone>,
    hierarchy: Option<HierarchyStatistics>,
}

impl Sequence<'_> {
    /// What the frames are made of.
    pub(super) fn identity(&self, file: &str) -> FramesIdentity {
        let (moves, [width, height]) = (motions(self.scene), self.scene.settings.size);
        FramesIdentity {
            scene: scene_hash(self.data, &self.options.develop),
            animation: FramesIdentity::hash(&format!("{:?} {moves:?}", self.scene.animation)),
            file: FramesIdentity::hash(file),
            stated: vec![("size", format!("{width} x {height}"))],
        }
    }

    /// Whether the program ffmpeg encodes, which keeps nothing.
    fn is_piped(&self) -> bool {
        #[cfg(feature = "video")]
        return self.flags.animation.ffmpeg;
        #[cfg(not(feature = "video"))]
        return false;
    }

    /// Renders the frames that are missing. After Ctrl-C that is a failure, which says how to go on.
    pub(super) fn render(
        &self,
        backend: &dyn Backend,
        missing: &[u32],
        sink: &dyn FrameSink,
        in_flight: Option<u16>,
    ) -> Result<Outcome, Failure> {
        let start = Instant::now();
        let (all, verbosity) = (self.range.len(), self.flags.report.verbosity());
        let kept = all - missing.len();
        if kept > 0 {
            let note = format!("eosphor: note: {kept} of {all} frames are done already");
            verbosity.say(Verbosity::Normal, &note);
        }
        if missing.is_empty() {
            let done = FramesDone { count: 0, left: 0, statistics: RayStatistics::default() };
            let seconds = start.elapsed().as_secs_f64();
            return Ok(Outcome { kept, done, seconds, frames: Vec::new(), hierarchy: None });
        }
        let prepared = backend.prepare(Arc::clone(self.data))?;
        let in_flight = in_flight.or(self.flags.animation.in_flight).map(usize::from);
        let in_flight =
            frames_in_memory(prepared.size(), in_flight.unwrap_or_else(|| backend.frames_in_flight()))?;
        let frames = Mutex::new(Vec::new());
        let job = FramesJob {
            prepared: &*prepared,
            moments: &Moments::new(self.scene, self.data),
            frames: missing,
            in_flight,
            count_work: self.flags.report.stats,
            one_at_a_time: false,
            log: &|done| {
                frames.lock().unwrap_or_else(PoisonError::into_inner).push(done);
                Ok(())
            },
        };
        let view = ProgressView::new(verbosity);
        let mut done = job.run(sink, &view);
        // Those who had the frames that were left may be gone without having done them.
        while let Ok(sum) = &mut done
            && sum.left > 0
            && !interrupt::cancel().asked().load(Ordering::Relaxed)
        {
            match job.run(sink, &view) {
                Ok(FramesDone { count: 0, .. }) => break,
                Ok(FramesDone { count, statistics, .. }) => {
                    sum.count += count;
                    sum.left = sum.left.saturating_sub(count);
                    sum.statistics += statistics;
                }
                Err(failure) => done = Err(failure),
            }
        }
        view.finish();
        let frames = frames.into_inner().unwrap_or_else(PoisonError::into_inner);
        let done = done.map_err(|failure| match is_video(self.flags.output()) {
            true => failure,
            false => still_there(failure, kept + frames.len(), all, self.flags.animation.share),
        })?;
        if done.count + done.left < missing.len() {
            let (output, count) = (self.flags.output().display(), kept + done.count);
            let state = match self.is_piped() {
                true => lost_by_ffmpeg(count, all),
                false => format!("{count} of {all} frames are done: {}", goes_on(self.flags.animation.share)),
            };
            return Err(Failure::Interrupted(format!("interrupted: {output}: {state}")));
        }
        let hierarchy = Some(prepared.hierarchy_statistics());
        Ok(Outcome { kept, done, seconds: start.elapsed().as_secs_f64(), frames, hierarchy })
    }
}

/// How frames are gone on with.
fn goes_on(is_shared: bool) -> &'static str {
    if is_shared { "the same command goes on" } else { "the same with --resume goes on" }
}

/// Frames of a video that ended early.
pub(super) fn lost_by_ffmpeg(count: usize, all: usize) -> String {
    format!("{count} of {all} frames were done, and none is kept: ffmpeg makes whole videos only")
}

/// With what is left of a sequence that failed.
pub(super) fn still_there(failure: Failure, count: usize, all: usize, is_shared: bool) -> Failure {
    match failure {
        Failure::Failed(line) if count > 0 => {
            let goes_on = goes_on(is_shared);
            Failure::Failed(format!("{line}; {count} of {all} frames are done: {goes_on}"))
        }
        failure => failure,
    }
}

impl Outcome {
    pub(super) fn report(self, sequence: &Sequence, backend: &dyn Backend) -> Result<(), Failure> {
        let Outcome { kept, done, seconds, frames, hierarchy } = self;
        let flags = sequence.flags;
        let work = hierarchy
            .filter(|_| flags.report.stats)
            .map(|hierarchy| FramesWork::new(&frames, done.statistics, hierarchy));
        let report = Report {
            output: flags.output().display().to_string(),
            frames: done.count,
            kept,
            backend: backend.describe(),
            total_rays: done.statistics.total_rays(),
            seconds,
            frames_per_second: if seconds > 0.0 { done.count as f64 / seconds } else { 0.0 },
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
        flags.report.verbosity().say(Verbosity::Normal, &text);
        if let Some(work) = &report.work {
            flags.report.verbosity().say(Verbosity::Normal, &work.table(sequence.scene.settings.size));
        }
        if done.left > 0 {
            let text =
                format!("eosphor: note: {} frames were done by others, or they have them in work", done.left);
            flags.report.verbosity().say(Verbosity::Normal, &text);
        }
        if flags.report.json { streams::json(&report) } else { Ok(()) }
    }
}

/// How objects move: each motion once, as many may share one, and then the numbers of those that each instance has.
fn motions(scene: &Scene) -> (Vec<&Move>, Vec<Vec<usize>>) {
    let (mut all, mut numbers): (Vec<&Move>, _) = (Vec::new(), HashMap::new());
    let mut of_instances = Vec::with_capacity(scene.instances.len());
    for instance in &scene.instances {
        let mut own = Vec::with_capacity(instance.moves.len());
        for motion in &instance.moves {
            own.push(*numbers.entry(Arc::as_ptr(motion)).or_insert_with(|| {
                all.push(motion);
                all.len() - 1
            }));
        }
        of_instances.push(own);
    }
    (all, of_instances)
}

/// The frames that are asked for; all where no range is given.
fn range(flags: &RenderFlags, scene: &Scene) -> Result<Range<u32>, Failure> {
    let Some(animation) = &scene.animation else {
        let message = format!(
            "nothing moves in this scene: {} needs an animation: give the scene one, or --orbit with a number of frames",
            flags.output().display()
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

/// Numbered files.
struct Files<'a> {
    pattern: &'a FramePattern,
    part: &'a Path,
    manifest: &'a Manifest,
    options: &'a SaveOptions,
}

impl FrameSink for Files<'_> {
    fn take(&self, frame: u32, film: Film) -> Result<(), Failure> {
        let path = self.pattern.path(frame);
        save_within(self.part, &film, &path, self.options)?;
        self.manifest.note(frame, &path).map_err(Failure::because)
    }

    fn claim(&self, frame: u32) -> Result<bool, Failure> {
        self.manifest.claim(frame, &self.pattern.path(frame)).map_err(Failure::because)
    }
}
