//! `eosphor render SCENE -o OUT`.

use crate::arguments::RenderFlags;
use crate::backend::{backend_for, limit_threads};
use crate::failure::Failure;
use crate::files::same_file;
use crate::progress::ProgressView;
use crate::report::{Report, Seconds, Speed, WorkPerRay};
use crate::streams::{self, Verbosity};
use crate::{interrupt, memory};
use cpu_time::ProcessTime;
use eosphor::math::Vec3;
use eosphor::{Backend, Camera, HierarchyStatistics, LoadOptions, RenderControl, Rendered, SaveOptions};
use eosphor::{Scene, SceneData, Transform, check_writable, load, save};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Warnings that are shown without `-v`.
const SHOWN_WARNINGS: usize = 10;

pub(crate) fn render(flags: &RenderFlags) -> Result<(), Failure> {
    // What can be known to fail does so before minutes of rendering.
    check_writable(&flags.output)?;
    limit_threads(&flags.device)?;
    let backend = backend_for(&flags.device)?;
    let verbosity = flags.report.verbosity();
    interrupt::watch(verbosity)?;

    let start = Instant::now();
    let mut seconds = Seconds::default();
    let mut notes = Vec::new();
    let scene = timed(&mut seconds.load, || load_scene(flags, &mut notes))?;
    memory::check_fits(scene.settings.size)?;
    let data = timed(&mut seconds.flatten, || flatten(&scene, &mut notes))?;
    show_notes(&notes, verbosity);
    let (rendered, hierarchy, done) = trace(flags, &*backend, data, &mut seconds)?;
    if done == 0.0 && !rendered.complete {
        let output = flags.output.display();
        return Err(Failure::Interrupted(format!(
            "interrupted: {output}: nothing was rendered, nothing written"
        )));
    }
    let options = SaveOptions { complete: rendered.complete, ..SaveOptions::from(&scene.settings) };
    timed(&mut seconds.write, || save(&rendered.film, &flags.output, &options))?;

    seconds.total = start.elapsed().as_secs_f64();
    seconds.total_cpu = ProcessTime::try_now().ok().map(|time| time.as_duration().as_secs_f64());
    let backend = backend.describe();
    let report = report(flags, &rendered, hierarchy, backend, seconds, notes);
    verbosity.say(Verbosity::Normal, &report.table());
    if flags.report.json {
        streams::json(&report)?;
    }
    match rendered.complete {
        true => Ok(()),
        false => Err(Failure::Interrupted(format!(
            "interrupted: {}: the picture is partial ({:.0} % of the pixels): render again for the whole one",
            report.output,
            (done * 100.0).floor(),
        ))),
    }
}

/// The scene with everything that the flags change.
fn load_scene(flags: &RenderFlags, notes: &mut Vec<String>) -> Result<Scene, Failure> {
    let loaded = load(&flags.scene, &LoadOptions::default())?;
    notes.extend(loaded.warnings.iter().map(ToString::to_string));
    let mut scene = loaded.scene;
    for path in &loaded.files_read {
        if same_file(path, &flags.output) {
            return Err(Failure::Failed(format!(
                "cannot write the picture: {}: this is {}, which the scene is read from: choose another name",
                flags.output.display(),
                path.display()
            )));
        }
        flags.report.verbosity().say(Verbosity::Verbose, &format!("read {}", path.display()));
    }
    if let Some(preset) = flags.preset {
        preset.apply(&mut scene);
    }
    flags.settings.apply(&mut scene.settings);
    if let Some(offset) = flags.translate {
        translate(&mut scene, offset);
    }
    flags.camera.apply(&mut scene, framed_camera)?;
    // The file was valid by itself: what is out of range now came with a flag.
    scene.validate().map_err(Failure::usage)?;
    Ok(scene)
}

/// The camera that flattening gives a scene without one; its field of view is the default.
fn framed_camera(scene: &Scene) -> Result<Camera, Failure> {
    let (data, _) = SceneData::flatten(scene)?;
    Ok(Camera { position: data.camera.eye, direction: data.camera.forward, ..Camera::default() })
}

/// Moves all geometry.
fn translate(scene: &mut Scene, offset: Vec3) {
    for instance in &mut scene.instances {
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

/// Builds the hierarchy and renders; also gives the share of the pixels that are done.
fn trace(
    flags: &RenderFlags,
    backend: &dyn Backend,
    data: Arc<SceneData>,
    seconds: &mut Seconds,
) -> Result<(Rendered, HierarchyStatistics, f64), Failure> {
    interrupt::check()?;
    let prepared = timed(&mut seconds.build, || backend.prepare(data))?;
    interrupt::check()?;
    let view = ProgressView::new(flags.report.verbosity());
    let control = RenderControl {
        on_progress: &|progress| view.update(progress),
        cancel: interrupt::flag(),
        count_work: flags.report.stats,
    };
    let cpu_before = ProcessTime::try_now().ok();
    let rendered = timed(&mut seconds.render, || prepared.render(&control))?;
    let cpu = |before: ProcessTime| before.try_elapsed().ok();
    seconds.render_cpu = cpu_before.and_then(cpu).map(|time| Duration::as_secs_f64(&time));
    Ok((rendered, prepared.hierarchy_statistics(), view.finish()))
}

/// Calls `work` and notes the seconds that it took.
fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    *seconds = start.elapsed().as_secs_f64();
    done
}

fn report(
    flags: &RenderFlags,
    rendered: &Rendered,
    hierarchy: HierarchyStatistics,
    backend: String,
    seconds: Seconds,
    notes: Vec<String>,
) -> Report {
    let Rendered { film, complete, statistics } = rendered;
    let total_rays = statistics.total_rays();
    Report {
        output: flags.output.display().to_string(),
        width: film.width,
        height: film.height,
        complete: *complete,
        backend,
        rays: *statistics,
        total_rays,
        rays_per_pixel: total_rays as f64 / (film.width as f64 * film.height as f64),
        work_per_ray: flags.report.stats.then(|| WorkPerRay::of(statistics)),
        speed: Speed::of(total_rays, &seconds),
        seconds,
        hierarchy,
        notes,
    }
}
