//! `eosphor render SCENE -o OUT`.

use super::config;
use super::cost::show_cost;
use super::{frames, tiles};
use crate::arguments::{
    CameraFlags, OutputKind, PictureFlags, RenderFlags, SampleRange, SettingsFlags, Share, Show,
};
use crate::backend::{feature_pass, ranks_or_own};
use crate::command_line::command_line;
use crate::failure::Failure;
use crate::files::same_file;
use crate::picture::{Done, PictureJob};
use crate::progress::ProgressView;
use crate::report::{Report, Seconds, Speed, Work, timed};
use crate::streams::{self, Verbosity};
use crate::target::{Target, is_stdout, names, targets};
use crate::text::ratio;
use crate::{interrupt, memory};
use cpu_time::ProcessTime;
use eosphor::math::Vec3;
use eosphor::still::{Checkpoint, SampleShare, checkpoint_path, sample_share_path};
use eosphor::{Animation, CameraMotion, Move, Note, Scene, SceneData, Transform, load, scene_hash};
use eosphor::{
    Backend, Camera, FeaturePass, Format, HierarchyStatistics, Metadata, PreparedRegion, PreparedScene,
    Region, SaveOptions, Window,
};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Warnings that are shown without `-v`.
const SHOWN_WARNINGS: usize = 10;

/// `ranks` is the backend where there are several.
pub(crate) fn render(flags: &RenderFlags, ranks: Option<&dyn Backend>) -> Result<(), Failure> {
    // What can be known to fail does so before minutes of rendering.
    let kind = frames::output_kind(flags);
    flags.animation.check(kind)?;
    let to_stdout = flags.outputs.iter().any(|output| is_stdout(output));
    let has_file = flags.outputs.iter().any(|output| !is_stdout(output));
    flags.keep.check(kind, &flags.file, flags.show, &flags.report, has_file)?;
    flags.report.check(&flags.device, flags.show, to_stdout)?;
    let sequence = kind != OutputKind::Still;
    let is_share = flags.file.tiles.is_some() || flags.file.sample_range.is_some();
    if flags.outputs.len() > 1 && (sequence || is_share) {
        let message = "several outputs (-o) are for whole single pictures: name one";
        return Err(Failure::Usage(message.into()));
    }
    let targets = match kind {
        OutputKind::Video => Vec::new(),
        _ => targets(&flags.outputs, flags.file.format)?,
    };
    let formats: Vec<Format> = targets.iter().map(Target::format).collect();
    flags.file.check(&formats, to_stdout)?;
    let is_developed = kind == OutputKind::Video || formats.iter().any(|format| !format.is_linear());
    flags.settings.check_development(is_developed && flags.show.is_none())?;
    match sequence {
        true => frames::check_output(flags.output())?,
        false => targets.iter().try_for_each(Target::check)?,
    }
    let verbosity = flags.report.verbosity();
    let backend = ranks_or_own(ranks, &flags.device, flags.picture.accel, flags.report.stats, verbosity)?;
    interrupt::watch(verbosity)?;

    let start = Instant::now();
    let mut seconds = Seconds::default();
    let mut notes = Vec::new();
    let scene = timed(&mut seconds.load, || load_scene(flags, &mut notes))?;
    flags.animation.check_fps(kind, &scene)?;
    #[cfg(feature = "video")]
    check_video_size(flags, kind, scene.settings.size)?;
    let size = size_of_file(flags, scene.settings.size)?;
    let bands =
        memory::bands(size, !flags.file.layers().is_empty() || flags.file.alpha, flags.file.band_rows)?;
    let data = timed(&mut seconds.flatten, || flatten(&scene, &mut notes))?;
    show_notes(&notes, verbosity);
    let options = save_options(flags, &formats, &scene, &data, &mut seconds);
    if sequence {
        let file = &flags.file;
        let is_part = file.tiles.is_some() || file.region.is_some();
        if flags.show.is_some() || is_part || options.needs_features() {
            let message =
                "--show, --tiles, --region, --layers and --alpha are for single pictures: leave them out";
            return Err(Failure::Usage(message.into()));
        }
        return frames::render_frames(flags, &*backend, &scene, &data, &options);
    }
    let of_format = |target: Target| {
        let options = options_of(&options, target.format());
        (target, options)
    };
    let outputs: Vec<(Target, SaveOptions)> = targets.into_iter().map(of_format).collect();
    if let Some(Share(share)) = flags.file.tiles {
        if flags.show.is_some() || flags.report.stats || flags.report.json {
            return Err(Failure::Usage("--show, --stats and --json are not for shares of a picture".into()));
        }
        return tiles::render_share(flags, &*backend, data, options, share);
    }
    if let Some(SampleRange(samples)) = &flags.file.sample_range
        && samples.end > data.settings.samples
    {
        let (first, end, all) = (samples.start, samples.end, data.settings.samples);
        return Err(Failure::Usage(format!("--sample-range {first}..{end}: a pixel has {all} samples")));
    }
    if flags.show == Some(Show::Cost) {
        return show_cost(flags, data, bands, &outputs);
    }
    let (done, hierarchy) = trace(flags, &*backend, data, bands.rows(), &outputs, &mut seconds)?;
    let targets = names(outputs.iter().map(|(target, _)| target));
    if done.share == 0.0 && !done.complete {
        let output = match flags.file.sample_range.is_some() {
            true => names(done.written.iter().map(|path| path.display())),
            false => targets,
        };
        return Err(Failure::Interrupted(format!(
            "interrupted: {output}: nothing was rendered, nothing written"
        )));
    }

    seconds.total = start.elapsed().as_secs_f64();
    if ranks.is_some() {
        // Others have worked, too.
        seconds.render_cpu = None;
    }
    let cpu = ProcessTime::try_now().ok().filter(|_| ranks.is_none());
    seconds.total_cpu = cpu.map(|time| time.as_duration().as_secs_f64());
    let report = report((flags, &outputs), size, &done, hierarchy, backend.describe(), seconds, notes);
    verbosity.say(Verbosity::Normal, &report.table());
    if flags.report.json {
        streams::json(&report)?;
    }
    match done.complete {
        true => Ok(()),
        false => Err(Failure::Interrupted(interruption(flags, &targets, &done))),
    }
}

/// Fails where flags ask for a video of a size that the encoder does not take.
#[cfg(feature = "video")]
fn check_video_size(flags: &RenderFlags, kind: OutputKind, size: [u32; 2]) -> Result<(), Failure> {
    match kind == OutputKind::Video && flags.settings.has_size() && !flags.animation.ffmpeg {
        true => eosphor::video::check_video_size(size.into())
            .map_err(|problem| Failure::Usage(format!("--size: {problem}"))),
        false => Ok(()),
    }
}

/// Width and height of what is rendered: the picture, or a part of it.
fn size_of_file(flags: &RenderFlags, [width, height]: [u32; 2]) -> Result<[u32; 2], Failure> {
    match flags.file.region {
        None => Ok([width, height]),
        Some(region) if region.is_in((width, height)) => Ok([region.width, region.height]),
        Some(Region { x, y, width: w, height: h }) => Err(Failure::Usage(format!(
            "--region {x},{y},{w}x{h}: the picture has {width} x {height} pixels, the upper left one is 0,0"
        ))),
    }
}

/// What there is after a signal.
fn interruption(flags: &RenderFlags, targets: &str, done: &Done) -> String {
    let percent = (done.share * 100.0).floor();
    let written = names(done.written.iter().map(|path| path.display()));
    if flags.file.sample_range.is_some() {
        return format!(
            "interrupted: {written} has {percent:.0} % of its samples: the same with --resume goes on"
        );
    }
    let goes_on = match &done.kept {
        Some(_) => "; the same with --resume goes on",
        None => "",
    };
    let were = if flags.outputs.len() > 1 { "were" } else { "was" };
    let partial = match done.written.len() {
        0 => String::new(),
        1 => format!("; {written} is the partial picture"),
        _ => format!("; {written} are the partial picture"),
    };
    format!(
        "interrupted: {targets} {were} not written: {percent:.0} % of its samples are done{partial}{goes_on}"
    )
}

/// The scene with everything that the flags change.
fn load_scene(flags: &RenderFlags, notes: &mut Vec<String>) -> Result<Scene, Failure> {
    let options =
        flags.settings.load_options(flags.camera.choice(), flags.picture.are_lit(), &flags.textures);
    let loaded = load(&flags.scene, &options)?;
    notes.extend(loaded.warnings.iter().map(ToString::to_string));
    let mut scene = loaded.scene;
    let files = || flags.outputs.iter().filter(|output| !is_stdout(output));
    for path in &loaded.files_read {
        if let Some(output) = files().find(|output| same_file(path, output)) {
            return Err(Failure::Failed(format!(
                "cannot write the picture: {}: this is {}, which the scene is read from: choose another name",
                output.display(),
                path.display()
            )));
        }
        flags.report.verbosity().say(Verbosity::Verbose, &format!("read {}", path.display()));
    }
    flags.animation.apply(&mut scene);
    apply(&mut scene, &flags.picture, &flags.settings, &flags.camera)?;
    settle_orbit(&mut scene)?;
    config::tell(flags, &scene);
    Ok(scene)
}

/// Changes a scene as flags say.
pub(super) fn apply(
    scene: &mut Scene,
    picture: &PictureFlags,
    settings: &SettingsFlags,
    camera: &CameraFlags,
) -> Result<(), Failure> {
    if let Some(preset) = picture.preset {
        preset.apply(scene);
    }
    settings.apply(&mut scene.settings);
    settings.check(&scene.settings)?;
    if let Some(offset) = picture.translate {
        move_all(scene, offset);
    }
    picture.lights.apply(scene)?;
    camera.apply(scene, framed_camera)?;
    // The file was valid by itself: what is out of range now came with a flag.
    scene.validate().map_err(Failure::usage)
}

/// The camera that flattening gives a scene without one.
pub(super) fn framed_camera(scene: &Scene) -> Result<Camera, Failure> {
    let (_, notes) = SceneData::flatten(scene)?;
    let camera = |note: Note| match note {
        Note::FramedCamera { camera, .. } => Some(camera),
        _ => None,
    };
    // Where there is nothing, any camera sees it.
    Ok(notes.into_iter().find_map(camera).unwrap_or_default())
}

/// A turntable about nothing in particular goes around the middle of the scene.
fn settle_orbit(scene: &mut Scene) -> Result<(), Failure> {
    let is_open =
        |animation: &Animation| matches!(animation.camera, Some(CameraMotion::Orbit { around: None, .. }));
    if scene.camera.is_some_and(|camera| camera.look_at.is_some()) {
        return Ok(());
    }
    let Some(mut animation) = scene.animation.take_if(|animation| is_open(animation)) else { return Ok(()) };
    let (data, _) = SceneData::flatten(scene)?;
    let middle = data.world_bounds().center();
    if scene.camera.is_none() {
        scene.camera = Some(Camera { look_at: Some(middle), ..framed_camera(scene)? });
    }
    if let Some(CameraMotion::Orbit { around, .. }) = &mut animation.camera {
        *around = Some(middle);
    }
    scene.animation = Some(animation);
    Ok(())
}

/// Moves all geometry.
fn move_all(scene: &mut Scene, by: [f64; 3]) {
    if scene.move_far_geometry(by) {
        return;
    }
    let offset = Vec3::from(by.map(|x| x as f32));
    let motion = Arc::new(Move { transform: Transform::translation(offset), ..Move::default() });
    for instance in &mut scene.instances {
        if !instance.moves.is_empty() {
            // What moves is moved as it comes out of its motions.
            instance.moves.push(Arc::clone(&motion));
            continue;
        }
        let Transform { translate, matrix, .. } = &mut instance.world_from_object;
        match matrix {
            // The matrix comes after the translation.
            Some(rows) => rows.iter_mut().zip(<[f32; 3]>::from(offset)).for_each(|(row, by)| row[3] += by),
            None => *translate += offset,
        }
    }
    scene.spheres.iter_mut().for_each(|sphere| sphere.center += offset);
    scene.parallelograms.iter_mut().for_each(|parallelogram| parallelogram.corner += offset);
}

fn flatten(scene: &Scene, notes: &mut Vec<String>) -> Result<Arc<SceneData>, Failure> {
    interrupt::check()?;
    let (data, flatten_notes) = SceneData::flatten(scene)?;
    notes.extend(flatten_notes.iter().map(ToString::to_string));
    Ok(Arc::new(data))
}

fn show_notes(notes: &[String], verbosity: Verbosity) {
    let shown = if verbosity == Verbosity::Verbose { notes.len() } else { SHOWN_WARNINGS };
    for note in notes.iter().take(shown) {
        verbosity.say(Verbosity::Normal, &format!("eosphor: note: {note}"));
    }
    if notes.len() > shown {
        let rest = notes.len() - shown;
        verbosity.say(Verbosity::Normal, &format!("eosphor: note: {rest} more notes; -v shows all"));
    }
}

/// What the file is like and says of itself.
fn save_options(
    flags: &RenderFlags,
    formats: &[Format],
    scene: &Scene,
    data: &SceneData,
    seconds: &mut Seconds,
) -> SaveOptions {
    let mut options = SaveOptions::from(&scene.settings);
    options.layers = flags.file.layers().to_vec();
    options.alpha = flags.file.alpha.then_some(data.settings.background);
    options.exr_half = flags.file.exr_half;
    options.window = flags.file.region.map(|region| Window { region, whole: scene.settings.size.into() });
    options.jpeg_quality = flags.file.jpeg_quality.unwrap_or(options.jpeg_quality);
    if !flags.file.no_metadata && formats.iter().any(|format| format.has_metadata()) {
        options.metadata = Metadata {
            scene_hash: Some(timed(&mut seconds.write, || scene_hash(data, &options.develop))),
            // Frames are to be the same bytes however often it took to render them all.
            command_line: (!frames::are_asked_for(flags)).then(command_line),
        };
    }
    options
}

/// What is of use in a format.
fn options_of(options: &SaveOptions, format: Format) -> SaveOptions {
    let mut options = options.clone();
    if !format.has_layers() {
        options.layers.clear();
    }
    if !format.has_alpha() {
        options.alpha = None;
    }
    if !format.has_metadata() {
        options.metadata = Metadata::default();
    }
    options
}

/// Builds the hierarchy, renders and writes.
fn trace(
    flags: &RenderFlags,
    backend: &dyn Backend,
    data: Arc<SceneData>,
    most_rows: u32,
    outputs: &[(Target, SaveOptions)],
    seconds: &mut Seconds,
) -> Result<(Done, HierarchyStatistics), Failure> {
    interrupt::check()?;
    let verbosity = flags.report.verbosity();
    outputs.iter().try_for_each(|(target, _)| target.make_folder())?;
    // Beside the first file.
    let file = outputs.iter().find_map(|(target, options)| Some((target.file()?, options)));
    let checkpoint = match file {
        Some((output, options)) => open_checkpoint(flags, output, &data, options)?,
        None => Checkpoint::nowhere(Arc::clone(&data)),
    };
    let prepare = || prepare(backend, Arc::clone(&data), flags.file.region);
    let prepared = timed(&mut seconds.build, prepare)?;
    let features = match outputs.iter().any(|(_, options)| options.needs_features()) {
        false => None,
        true => Some(timed(&mut seconds.build, || layers(flags, data, &*prepared))?),
    };
    interrupt::check()?;
    let job = PictureJob {
        prepared: &*prepared,
        features,
        outputs,
        count_work: flags.report.stats,
        most_rows,
        checkpoint_interval: flags.keep.interval(),
        samples: checkpoint.samples(),
        is_share: flags.file.sample_range.is_some(),
        verbosity,
    };
    let done = job.run(checkpoint, ProgressView::new(verbosity), seconds)?;
    Ok((done, prepared.hierarchy_statistics()))
}

/// Builds the hierarchy for a picture, or a part of it.
pub(super) fn prepare(
    backend: &dyn Backend,
    data: Arc<SceneData>,
    region: Option<Region>,
) -> Result<Box<dyn PreparedScene>, Failure> {
    let whole = backend.prepare(data)?;
    Ok(match region {
        Some(region) => Box::new(PreparedRegion::new(whole, region)?),
        None => whole,
    })
}

/// What makes the layers and the alpha of what is rendered.
pub(super) fn layers(
    flags: &RenderFlags,
    data: Arc<SceneData>,
    prepared: &dyn PreparedScene,
) -> Result<FeaturePass, Failure> {
    let pass = feature_pass(&flags.device, flags.picture.accel, data, prepared.hierarchy())?;
    match flags.file.region {
        Some(region) => Ok(pass.of_region(region)?),
        None => Ok(pass),
    }
}

/// What an earlier run has done, where it is to be gone on with.
fn open_checkpoint(
    flags: &RenderFlags,
    output: &Path,
    data: &Arc<SceneData>,
    options: &SaveOptions,
) -> Result<Checkpoint, Failure> {
    let share = flags.file.sample_range.as_ref().map(|SampleRange(samples)| SampleShare {
        samples: samples.clone(),
        all: data.settings.samples,
        scene: scene_hash(data, &options.develop),
        options: options.clone(),
    });
    let path = match &share {
        Some(share) => sample_share_path(output, &share.samples),
        None => checkpoint_path(output),
    };
    let (resume, interval) = (flags.keep.resume, flags.keep.interval());
    let checkpoint = Checkpoint::open(&path, (Arc::clone(data), flags.file.region), share, interval, resume)
        .map_err(Failure::because)?;
    let name = path.display();
    let note = match resume {
        true if checkpoint.is_kept() => {
            let whole = || Region::whole((data.settings.width, data.settings.height));
            let pixels = flags.file.region.unwrap_or_else(whole).pixels();
            let all = pixels * checkpoint.samples().len() as u64;
            let percent = (1000.0 * ratio(checkpoint.samples_done() as f64, all as f64)).floor() / 10.0;
            Some(format!("{percent} % of the samples are done already"))
        }
        true => Some(format!(
            "{name} is not there, or has nothing yet: the picture is rendered from its beginning"
        )),
        false if checkpoint.has_other() && flags.file.sample_range.is_none() => {
            Some(format!("{name} is of a render that ended early: --resume would go on with it"))
        }
        false => None,
    };
    if let Some(note) = note {
        flags.report.verbosity().say(Verbosity::Normal, &format!("eosphor: note: {note}"));
    }
    Ok(checkpoint)
}

fn report(
    (flags, outputs): (&RenderFlags, &[(Target, SaveOptions)]),
    [width, height]: [u32; 2],
    done: &Done,
    hierarchy: HierarchyStatistics,
    backend: String,
    seconds: Seconds,
    notes: Vec<String>,
) -> Report {
    let total_rays = done.statistics.total_rays();
    // A partial picture, or a share, has another name.
    let files: Vec<String> = match done.complete && flags.file.sample_range.is_none() {
        true => outputs.iter().map(|(target, _)| target.to_string()).collect(),
        false => done.written.iter().map(|path| path.display().to_string()).collect(),
    };
    Report {
        output: files.first().cloned().unwrap_or_default(),
        outputs: files,
        width,
        height,
        complete: done.complete,
        backend,
        rays: done.statistics,
        total_rays,
        resumed: done.resumed,
        rays_per_pixel: ratio(total_rays as f64, width as f64 * height as f64 * (1.0 - done.resumed)),
        work: flags.report.stats.then(|| Work::of(&done.statistics)),
        speed: Speed::of(total_rays, &seconds),
        seconds,
        hierarchy,
        notes,
    }
}
