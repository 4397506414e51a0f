//! `eosphor course`: the task of PLATO's course, by its own input and output.

use crate::animation::{FrameSink, FramesJob};
use crate::arguments::CourseFlags;
use crate::backend::ranks_or_own;
use crate::failure::Failure;
use crate::interrupt;
use crate::memory;
use crate::progress::ProgressView;
use crate::streams::{self, Verbosity};
use eosphor::frames::{FramesIdentity, Manifest, Wanted};
use eosphor::{
    Backend, CourseInput, CourseOptions, Film, Moments, SaveOptions, SceneData, save_within, scene_hash,
};
use std::fs;
use std::io::{Read, stdin};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// No input is longer.
const MOST_BYTES: u64 = 1 << 20;

/// `ranks` is the backend where there are several.
pub(crate) fn course(flags: &CourseFlags, ranks: Option<&dyn Backend>) -> Result<(), Failure> {
    if flags.default {
        return streams::result(&CourseInput::colourful().to_string());
    }
    let input = read_input()?;
    let usual = CourseOptions::default();
    let options = CourseOptions {
        shapes: flags.bodies.map_or(usual.shapes, |bodies| bodies.0),
        diodes: flags.edge_lights,
        ..usual
    };
    interrupt::watch(Verbosity::Normal)?;
    let loaded = input.scene(&options)?;
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
    make_folder(&input)?;
    let manifest = open_manifest(flags, &input, &options, &data)?;
    let frames: Vec<u32> =
        (0..input.frames).filter(|frame| !manifest.is_done(*frame, &input.output.path(*frame))).collect();
    let kept = input.frames as usize - frames.len();
    if kept > 0 {
        streams::message(&format!("eosphor: note: {kept} of {} frames are done already", input.frames));
    }
    if frames.is_empty() {
        return manifest.finish().map_err(Failure::because);
    }
    let prepared = backend.prepare(Arc::clone(&data))?;
    let sink = Files { input: &input, part: &manifest.part(), manifest: &manifest, options };
    let job = FramesJob {
        prepared: &*prepared,
        moments: &Moments::new(&scene, &data),
        frames: &frames,
        in_flight: memory::frames(prepared.size(), backend.frames_in_flight())?,
        // Ranks render frames at the same time, each for itself.
        one_at_a_time: ranks.is_none(),
        count_work: false,
        log: &|done| {
            let rays = done.statistics.total_rays();
            streams::result(&format!("{}\t{:.3}\t{rays}\n", done.frame, done.milliseconds))
        },
    };
    let view = ProgressView::new(Verbosity::Quiet);
    let done = job.run(&sink, &view)?;
    if done.count < frames.len() {
        let (done, all) = (kept + done.count, input.frames);
        let message = format!("interrupted: {done} of {all} frames are done: the same with --resume goes on");
        return Err(Failure::Interrupted(message));
    }
    manifest.finish().map_err(Failure::because)
}

/// What is done of the frames, beside them.
fn open_manifest(
    flags: &CourseFlags,
    input: &CourseInput,
    options: &SaveOptions,
    data: &SceneData,
) -> Result<Manifest, Failure> {
    let moving = format!("{input} {:?} {}", flags.bodies, flags.edge_lights);
    let identity = FramesIdentity {
        scene: scene_hash(data, &options.develop),
        animation: FramesIdentity::hash(&moving),
        file: FramesIdentity::hash("course"),
    };
    let frames = 0..input.frames;
    let wanted = if flags.resume { Wanted::Missing(frames) } else { Wanted::Anew(frames) };
    let path = PathBuf::from(format!("{}.manifest", input.output));
    Manifest::open(&path, &identity, wanted).map_err(Failure::because)
}

/// The folder of the frames, where it is not there.
fn make_folder(input: &CourseInput) -> Result<(), Failure> {
    let path = input.output.path(0);
    let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) else {
        return Ok(());
    };
    fs::create_dir_all(folder).map_err(|error| {
        Failure::Failed(format!("cannot make the folder of the frames: {}: {error}", folder.display()))
    })
}

/// Standard input, which must end somewhere.
fn read_input() -> Result<CourseInput, Failure> {
    let mut bytes = Vec::new();
    let read = stdin().lock().take(MOST_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|error| Failure::Failed(format!("cannot read the input: standard input: {error}")))?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(Failure::Failed("the input is too long: it must end within 1 MB".into()));
    }
    Ok(CourseInput::parse(&bytes, Path::new("standard input"))?)
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
