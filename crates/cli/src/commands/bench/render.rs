//! `eosphor bench render SCENE`: how long a picture takes once the scene is on the device.

use super::{answered, lines, median};
use crate::arguments::BenchRenderFlags;
use crate::backend::{backend_for, limit_threads};
use crate::commands::scene::apply;
use crate::failure::Failure;
use crate::streams::{self, Verbosity};
use crate::text::grouped;
use eosphor::{
    BackendError, DevelopSettings, Developed, Film, PreparedScene, RenderControl, SceneData, StageWork, load,
};
use eosphor_lab::{Stopwatch, Times};
use serde::Serialize;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

#[derive(Serialize)]
struct Report {
    backend: String,
    triangles: usize,
    width: u32,
    height: u32,
    rays: u64,
    /// The hierarchy, and on a GPU the way there.
    prepare_milliseconds: f64,
    /// The times are until the picture is bytes, not until its film is there.
    developed: bool,
    /// Median over the repetitions: of the whole picture, on a GPU with the way back.
    milliseconds: f64,
    shortest_milliseconds: f64,
    mrays_per_second: f64,
    /// What the stages of one more picture took, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    phases: Option<Vec<Phase>>,
}

/// A stage of the picture: all launches of a kernel, each of which was waited for.
#[derive(Serialize)]
struct Phase {
    kernel: &'static str,
    launches: u64,
    milliseconds: f64,
    /// Rays, points or pixels.
    items: u64,
    /// Of the threads of warps that had an item, those that had one: of 32.
    lanes: f64,
    /// Of queues and sums, at most.
    bytes: u64,
}

impl From<StageWork> for Phase {
    fn from(work: StageWork) -> Phase {
        let StageWork { kernel, launches, milliseconds, items, lanes, bytes } = work;
        Phase {
            kernel,
            launches,
            milliseconds,
            items,
            lanes: 32.0 * items as f64 / lanes.max(1) as f64,
            bytes,
        }
    }
}

pub(crate) fn bench_render(flags: &BenchRenderFlags) -> Result<(), Failure> {
    flags.check()?;
    limit_threads(&flags.device)?;
    let options = flags.settings.load_options(flags.camera.choice(), &flags.picture, &flags.textures);
    let mut scene = load(&flags.scene, &options)?.scene;
    apply(&mut scene, &flags.picture, &flags.settings, &flags.camera, &flags.textures)?;
    flags.device.check_paths()?;
    let backend = backend_for(&flags.device, flags.picture.accel, false, Verbosity::Normal)?;
    let data = Arc::new(SceneData::flatten(&scene)?.0);
    let triangles = data.triangles.len();
    let start = Instant::now();
    let prepared = backend.prepare(data)?;
    let prepare_milliseconds = start.elapsed().as_secs_f64() * 1e3;
    let (cancel, watch) = (AtomicBool::new(false), |_| ());
    let control = RenderControl { on_progress: &watch, cancel: &cancel, count_work: false, frame: None };
    let develop = flags.developed.then(|| DevelopSettings::from(&scene.settings));
    let (mut rays, mut answer) = (0, blake3::Hasher::new());
    let mut times = Times::default();
    for repeat in 0..flags.warm_up + flags.repeats {
        let watch = Stopwatch::start();
        let (picture, traced) = Picture::render(&*prepared, develop.as_ref(), &control)?;
        if repeat >= flags.warm_up {
            watch.stop(&mut times);
        }
        rays = traced;
        if flags.lines && repeat + 1 == flags.warm_up + flags.repeats {
            picture.hash(&mut answer);
        }
    }
    if flags.lines {
        return streams::result(&lines(&[answered("picture", &times, rays, answer.finalize())])?);
    }
    let phases = || Ok::<_, Failure>(prepared.stages(&control)?.into_iter().map(Phase::from).collect());
    let phases = flags.phases.then(phases).transpose()?;
    let shortest_milliseconds = times.wall.iter().copied().fold(f64::INFINITY, f64::min);
    let milliseconds = median(&times.wall);
    let [width, height] = scene.settings.size;
    let report = Report {
        backend: backend.describe(),
        triangles,
        width,
        height,
        rays,
        prepare_milliseconds,
        developed: flags.developed,
        milliseconds,
        shortest_milliseconds,
        mrays_per_second: rays as f64 * 1e-3 / milliseconds.max(1e-9),
        phases,
    };
    if flags.json { streams::json(&report) } else { streams::result(&report.table()) }
}

/// What is waited for.
enum Picture {
    Film(Film),
    Bytes(Developed),
}

impl Picture {
    /// The bytes where it is said how they are developed, and the number of rays that it took.
    fn render(
        prepared: &dyn PreparedScene,
        develop: Option<&DevelopSettings>,
        control: &RenderControl,
    ) -> Result<(Picture, u64), BackendError> {
        Ok(match develop {
            None => {
                let rendered = prepared.render(control)?;
                (Picture::Film(rendered.film), rendered.statistics.total_rays())
            }
            Some(develop) => {
                let rendered = prepared.render_developed(develop, control)?;
                let rays = rendered.statistics.total_rays();
                (Picture::Bytes(rendered.developed()), rays)
            }
        })
    }

    /// All bits of it, in order.
    fn hash(&self, hasher: &mut blake3::Hasher) {
        match self {
            Picture::Film(film) => {
                let channels = film.pixels.iter().flat_map(|color| [color.x, color.y, color.z]);
                channels.for_each(|channel| {
                    hasher.update(&channel.to_bits().to_le_bytes());
                });
            }
            Picture::Bytes(picture) => {
                hasher.update(&picture.rgb);
            }
        }
    }
}

impl Report {
    fn table(&self) -> String {
        let measured = if self.developed { "developed" } else { "render" };
        let mut table = format!(
            "{}; {} triangles\n\
             picture   {} x {}, {} rays\n\
             prepare   {:.1} ms\n\
             {measured:<9} {:.3} ms, {:.3} at best\n\
             speed     {:.1} Mrays/s\n",
            self.backend,
            grouped(self.triangles as u64),
            self.width,
            self.height,
            grouped(self.rays),
            self.prepare_milliseconds,
            self.milliseconds,
            self.shortest_milliseconds,
            self.mrays_per_second
        );
        if let Some(phases) = &self.phases {
            table += &format!(
                "\n{:<28} {:>8} {:>10} {:>14} {:>6} {:>10}\n",
                "kernel", "launches", "ms", "items", "lanes", "GB"
            );
            for Phase { kernel, launches, milliseconds, items, lanes, bytes } in phases {
                let (items, gigabytes) = (grouped(*items), *bytes as f64 * 1e-9);
                table += &format!(
                    "{kernel:<28} {launches:>8} {milliseconds:>10.3} {items:>14} {lanes:>6.1} {gigabytes:>10.3}\n"
                );
            }
            let all: f64 = phases.iter().map(|phase| phase.milliseconds).sum();
            table += &format!(
                "{:<28} {:>8} {all:>10.3}\n",
                "all",
                phases.iter().map(|phase| phase.launches).sum::<u64>()
            );
        }
        table
    }
}
