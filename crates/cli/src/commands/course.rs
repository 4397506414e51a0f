//! `eosphor course`: the task of PLATO's course, by its own input and output.

use super::frames::{check_output, is_video, lost_by_ffmpeg, still_there};
#[cfg(feature = "video")]
use super::video::VideoJob;
use crate::animation::{FrameSink, FramesJob};
use crate::arguments::CourseFlags;
use crate::backend::ranks_or_own;
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::ProgressView;
use crate::streams::{self, Verbosity};
use eosphor::frames::{FramesIdentity, Manifest, Wanted};
use eosphor::job::{check_output as check_output_file, frames_in_memory, make_folder};
use eosphor::{
    Backend, CourseInput, CourseLines, CourseOptions, Film, Moments, SaveOptions, Scene, SceneData,
    SceneError, save_within, scene_hash,
};
use std::fmt::Display;
use std::io::{Read, stdin};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What errors call the input.
const INPUT: &str = "standard input";

/// No input is longer.
const MOST_BYTES: u64 = 1 << 20;

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
    let usual = CourseOptions::default();
    let options = CourseOptions {
        shapes: flags.bodies.map_or(usual.shapes, |bodies| bodies.0),
        diodes: flags.edge_lights,
        texture_memory_bytes: flags.textures.memory_bytes(),
        ..usual
    };
    interrupt::watch(Verbosity::Normal)?;
    let loaded = input.scene(&options).map_err(|error| match of_texture(&error, &input) {
        true => in_input(lines.texture, "texture of the floor", &error),
        false => error.into(),
    })?;
    for warning in &loaded.warnings {
        streams::message(&format!("eosphor: note: {warning}"));
    }
    let scene = loaded.scene;
    let (data, notes) = SceneData::flatten(&scene)?;
    for note in notes {
        streams::message(&format!("eosphor: note: {note}"));
    }
    let data = Arc::new(data);
    let backend = ranks_or_own(ranks, &flags.device(), flags.accel, false, Verbosity::Normal)?;
    let options = SaveOptions::from(&scene.settings);
    let flight =
        Flight { flags, input: &input, scene: &scene, data: &data, options, ranks, backend: &*backend };
    match video {
        #[cfg(feature = "video")]
        Some(output) => flight.to_video(output),
        _ => {
            check_output_file(&input.output.path(0)).map_err(|error| match flags.output {
                Some(_) => Failure::of_output(error),
                None => in_input(lines.output, "output path", &error),
            })?;
            make_folder(&input.output.path(0))?;
            flight.to_files()
        }
    }
}

/// A flight to be rendered.
struct Flight<'a> {
    flags: &'a CourseFlags,
    input: &'a CourseInput,
    scene: &'a Scene,
    data: &'a Arc<SceneData>,
    options: SaveOptions,
    ranks: Option<&'a dyn Backend>,
    backend: &'a dyn Backend,
}

impl Flight<'_> {
    fn to_files(&self) -> Result<(), Failure> {
        let input = self.input;
        let frames = 0..input.frames;
        let wanted =
            if self.flags.resume { Wanted::Missing(frames.clone()) } else { Wanted::Anew(frames.clone()) };
        let path = PathBuf::from(format!("{}.manifest", input.output));
        let manifest = Manifest::open(&path, &self.identity("course"), wanted).map_err(Failure::because)?;
        let missing: Vec<u32> =
            frames.filter(|frame| !manifest.is_done(*frame, &input.output.path(*frame))).collect();
        let sink =
            Files { input, part: &manifest.part(), manifest: &manifest, options: self.options.clone() };
        self.render(&missing, &sink, None)?;
        manifest.finish().map_err(Failure::because)
    }

    #[cfg(feature = "video")]
    fn to_video(&self, output: &Path) -> Result<(), Failure> {
        let [width, height] = self.input.size;
        let job = VideoJob {
            output,
            size: (width, height),
            fps: self.flags.fps.unwrap_or(24.0),
            quality: self.flags.video_quality,
            ffmpeg: self.flags.ffmpeg,
            resume: self.flags.resume,
            range: 0..self.input.frames,
            develop: self.options.develop,
            identity: &|file| self.identity(file),
            verbosity: Verbosity::Normal,
        };
        job.run(&|frames, sink, in_flight| self.render(frames, sink, in_flight)).map(|_| ())
    }

    /// What the frames are made of.
    fn identity(&self, file: &str) -> FramesIdentity {
        let moving = format!("{} {:?} {}", self.input, self.flags.bodies, self.flags.edge_lights);
        FramesIdentity {
            scene: scene_hash(self.data, &self.options.develop),
            animation: FramesIdentity::hash(&moving),
            file: FramesIdentity::hash(file),
            stated: vec![("size", format!("{} x {}", self.input.size[0], self.input.size[1]))],
        }
    }

    /// Renders the frames that are missing, with a line for each.
    fn render(&self, frames: &[u32], sink: &dyn FrameSink, in_flight: Option<u16>) -> Result<(), Failure> {
        let all = self.input.frames;
        let kept = all as usize - frames.len();
        if kept > 0 {
            streams::message(&format!("eosphor: note: {kept} of {all} frames are done already"));
        }
        if frames.is_empty() {
            return Ok(());
        }
        let prepared = self.backend.prepare(Arc::clone(self.data))?;
        let in_flight = in_flight.map_or_else(|| self.backend.frames_in_flight(), usize::from);
        let logged = AtomicUsize::new(kept);
        let job = FramesJob {
            prepared: &*prepared,
            moments: &Moments::new(self.scene, self.data),
            frames,
            in_flight: frames_in_memory(prepared.size(), in_flight)?,
            // Ranks render frames at the same time, each for itself.
            one_at_a_time: self.ranks.is_none(),
            count_work: false,
            log: &|done| {
                logged.fetch_add(1, Ordering::Relaxed);
                let rays = done.statistics.total_rays();
                streams::result(&format!("{}\t{:.3}\t{rays}\n", done.frame, done.milliseconds))
            },
        };
        let done = job.run(sink, &ProgressView::new(Verbosity::Quiet));
        let done = done.map_err(|failure| match self.flags.output.as_deref().is_some_and(is_video) {
            true => failure,
            false => still_there(failure, logged.load(Ordering::Relaxed), all as usize, false),
        })?;
        if done.count < frames.len() {
            let done = kept + done.count;
            let state = match self.is_piped() {
                true => lost_by_ffmpeg(done, all as usize),
                false => format!("{done} of {all} frames are done: the same with --resume goes on"),
            };
            return Err(Failure::Interrupted(format!("interrupted: {state}")));
        }
        Ok(())
    }

    /// Whether the program ffmpeg encodes, which keeps nothing.
    fn is_piped(&self) -> bool {
        #[cfg(feature = "video")]
        return self.flags.ffmpeg;
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
    let read = stdin().lock().take(MOST_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|error| Failure::Failed(format!("cannot read the input: standard input: {error}")))?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(Failure::Failed("the input is too long: it must end within 1 MB".into()));
    }
    Ok(CourseInput::parse_with_lines(&bytes, Path::new(INPUT))?)
}

/// `.data` frames, or others by the name's ending.
struct Files<'a> {
    input: &'a CourseInput,
    part: &'a Path,
    manifest: &'a Manifest,
    options: SaveOptions,
}

impl FrameSink for Files<'_> {
    fn take(&self, frame: u32, film: Film) -> Result<(), Failure> {
        let path = self.input.output.path(frame);
        save_within(self.part, &film, &path, &self.options)?;
        self.manifest.note(frame, &path).map_err(Failure::because)
    }
}
