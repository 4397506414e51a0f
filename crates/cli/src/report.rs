//! What a render did: a table for people, JSON for programs.

use crate::text::{bytes, grouped, ratio};
use eosphor::{HierarchyStatistics, RayStatistics};
use serde::Serialize;
use std::fmt::Write;
use std::time::Instant;

/// What a render did.
#[derive(Serialize)]
pub(crate) struct Report {
    pub(crate) output: String,
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// False after Ctrl-C.
    pub(crate) complete: bool,
    /// The share of the samples that an earlier run had done, 0 to 1. Rays are those of this run.
    pub(crate) resumed: f64,
    pub(crate) backend: String,
    pub(crate) rays: RayStatistics,
    pub(crate) total_rays: u64,
    pub(crate) rays_per_pixel: f64,
    /// `None` where they were not counted.
    pub(crate) work_per_ray: Option<WorkPerRay>,
    pub(crate) speed: Speed,
    pub(crate) seconds: Seconds,
    pub(crate) hierarchy: HierarchyStatistics,
    /// Warnings of loading and notes of preparing.
    pub(crate) notes: Vec<String>,
}

/// Mean work on a ray.
#[derive(Serialize)]
pub(crate) struct WorkPerRay {
    pub(crate) nodes: f64,
    pub(crate) tests: f64,
}

/// How fast rays were traced, building and files left out.
#[derive(Serialize)]
pub(crate) struct Speed {
    pub(crate) mrays_per_second: f64,
    /// `None` where the system does not say.
    pub(crate) mrays_per_cpu_second: Option<f64>,
}

/// Wall-clock time by phase, and CPU time of the whole program so far.
#[derive(Default, Serialize)]
pub(crate) struct Seconds {
    pub(crate) load: f64,
    pub(crate) flatten: f64,
    pub(crate) build: f64,
    pub(crate) render: f64,
    /// `None` where the file has no layers.
    pub(crate) layers: Option<f64>,
    pub(crate) write: f64,
    pub(crate) total: f64,
    pub(crate) render_cpu: Option<f64>,
    pub(crate) total_cpu: Option<f64>,
}

/// Calls `work` and adds the seconds that it took.
pub(crate) fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    *seconds += start.elapsed().as_secs_f64();
    done
}

impl WorkPerRay {
    pub(crate) fn of(rays: &RayStatistics) -> WorkPerRay {
        let mean = |number: u64| ratio(number as f64, rays.total_rays() as f64);
        WorkPerRay { nodes: mean(rays.nodes_visited), tests: mean(rays.primitive_tests) }
    }
}

impl Speed {
    pub(crate) fn of(rays: u64, seconds: &Seconds) -> Speed {
        let rate = |seconds| ratio(rays as f64 * 1e-6, seconds);
        Speed { mrays_per_second: rate(seconds.render), mrays_per_cpu_second: seconds.render_cpu.map(rate) }
    }
}

impl Report {
    /// A table of about 20 lines.
    pub(crate) fn table(&self) -> String {
        let mut text = String::new();
        let _ = writeln!(text, "{}: {} x {} on {}", self.output, self.width, self.height, self.backend);
        self.ray_table(&mut text);
        if let Some(work) = &self.work_per_ray {
            row(&mut text, "nodes a ray", &format!("{:.2}", work.nodes));
            row(&mut text, "tests a ray", &format!("{:.2}", work.tests));
        }
        let speed = format!("{:.2} Mrays/s", self.speed.mrays_per_second);
        let cpu = self.speed.mrays_per_cpu_second.map(|rate| format!(", {rate:.2} Mrays per CPU second"));
        row(&mut text, "speed", &(speed + &cpu.unwrap_or_default()));
        self.time_table(&mut text);
        for (name, value) in hierarchy_rows(&self.hierarchy) {
            row(&mut text, name, &value);
        }
        // The last line's end is written with the table.
        text.truncate(text.trim_end().len());
        text
    }

    fn ray_table(&self, text: &mut String) {
        let RayStatistics { camera, reflected, refracted, glossy, shadow, .. } = self.rays;
        let pixels = self.width as f64 * self.height as f64 * (1.0 - self.resumed);
        let _ = writeln!(text, "{:<16} {:>16} {:>12}", "rays", "number", "a pixel");
        let kinds = [
            ("  camera", camera),
            ("  reflected", reflected),
            ("  refracted", refracted),
            ("  glossy", glossy),
            ("  shadow", shadow),
            ("  all", self.total_rays),
        ];
        for (name, number) in kinds {
            let _ =
                writeln!(text, "{name:<16} {:>16} {:>12.2}", grouped(number), ratio(number as f64, pixels));
        }
    }

    fn time_table(&self, text: &mut String) {
        let Seconds { load, flatten, build, render, layers, write, total, render_cpu, total_cpu } =
            self.seconds;
        let _ = writeln!(text, "{:<16} {:>16} {:>12}", "time", "seconds", "CPU");
        let phases = [
            ("  load", Some(load), None),
            ("  flatten", Some(flatten), None),
            ("  build", Some(build), None),
            ("  render", Some(render), render_cpu),
            ("  layers", layers, None),
            ("  write", Some(write), None),
            ("  all", Some(total), total_cpu),
        ];
        for (name, wall, cpu) in phases {
            let Some(wall) = wall else { continue };
            let cpu = cpu.map(|seconds| format!("{seconds:.3}")).unwrap_or_default();
            let line = format!("{name:<16} {wall:>16.3} {cpu:>12}");
            let _ = writeln!(text, "{}", line.trim_end());
        }
    }
}

/// The hierarchy in numbers, as rows of a table.
pub(crate) fn hierarchy_rows(h: &HierarchyStatistics) -> Vec<(&'static str, String)> {
    vec![
        ("hierarchy", format!("{}, built in {:.3} s", h.structure, h.build_seconds)),
        ("  primitives", grouped(h.primitives)),
        ("  nodes", format!("{}, of which {} leaves", grouped(h.nodes), grouped(h.leaves))),
        ("  leaf depth", format!("{:.2} on average, {} at most", h.mean_leaf_depth, h.max_leaf_depth)),
        (
            "  leaf size",
            format!("{:.2} on average, {} at most", h.mean_leaf_primitives, h.max_leaf_primitives),
        ),
        ("  SAH cost", format!("{:.2}", h.sah_cost)),
        ("  memory", bytes(h.bytes)),
    ]
}

fn row(text: &mut String, name: &str, value: &str) {
    let _ = writeln!(text, "{name:<16} {value}");
}
