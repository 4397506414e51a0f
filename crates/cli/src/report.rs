//! What a render did: a table for people, JSON for programs. docs/statistics.md says what the numbers mean.

use crate::text::{bytes, grouped, ratio};
use eosphor::job::StillSeconds;
use eosphor::{HierarchyStatistics, RayStatistics};
use serde::Serialize;
use std::fmt::Write;

/// What a render did.
#[derive(Serialize)]
pub(crate) struct Report {
    /// The first of the outputs.
    pub(crate) output: String,
    pub(crate) outputs: Vec<String>,
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
    /// `None` where it was not asked for.
    #[serde(flatten)]
    pub(crate) work: Option<Work>,
    pub(crate) speed: Speed,
    pub(crate) seconds: Seconds,
    pub(crate) hierarchy: HierarchyStatistics,
    /// Warnings of loading and notes of preparing.
    pub(crate) notes: Vec<String>,
}

/// What the searches of all rays did, and how long they took.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct Work {
    work_per_ray: WorkPerRay,
    work_per_search: WorkPerSearch,
    search_seconds: SearchSeconds,
}

/// Mean work on a ray.
#[derive(Clone, Copy, Serialize)]
struct WorkPerRay {
    searches: f64,
    nodes: f64,
    tests: f64,
    nanoseconds: f64,
}

/// Mean work on a search.
#[derive(Clone, Copy, Serialize)]
struct WorkPerSearch {
    nodes: f64,
    tests: f64,
    nanoseconds: f64,
}

/// Seconds of searches, of all threads added up.
#[derive(Clone, Copy, Serialize)]
struct SearchSeconds {
    traversal: f64,
    intersection: f64,
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

impl From<StillSeconds> for Seconds {
    fn from(still: StillSeconds) -> Seconds {
        let StillSeconds { flatten, build, render, layers, write, render_cpu } = still;
        Seconds { flatten, build, render, layers, write, render_cpu, ..Seconds::default() }
    }
}

impl Work {
    pub(crate) fn of(rays: &RayStatistics) -> Work {
        let (nodes, tests, nanoseconds) =
            (rays.nodes_visited, rays.primitive_tests, rays.times.all_nanoseconds());
        let a_ray = |number: u64| ratio(number as f64, rays.total_rays() as f64);
        let a_search = |number: u64| ratio(number as f64, rays.searches as f64);
        Work {
            work_per_ray: WorkPerRay {
                searches: a_ray(rays.searches),
                nodes: a_ray(nodes),
                tests: a_ray(tests),
                nanoseconds: a_ray(nanoseconds),
            },
            work_per_search: WorkPerSearch {
                nodes: a_search(nodes),
                tests: a_search(tests),
                nanoseconds: a_search(nanoseconds),
            },
            search_seconds: SearchSeconds {
                traversal: rays.times.traversal_nanoseconds as f64 * 1e-9,
                intersection: rays.times.intersection_nanoseconds as f64 * 1e-9,
            },
        }
    }

    /// Some lines.
    pub(crate) fn table(&self, text: &mut String) {
        let Work { work_per_ray: ray, work_per_search: search, search_seconds: seconds } = self;
        let _ = writeln!(text, "{:<16} {:>16} {:>12}", "work", "a ray", "a search");
        let _ = writeln!(text, "{:<16} {:>16.2}", "  searches", ray.searches);
        let rows = [
            ("  nodes", ray.nodes, search.nodes),
            ("  tests", ray.tests, search.tests),
            ("  nanoseconds", ray.nanoseconds, search.nanoseconds),
        ];
        for (name, ray, search) in rows {
            let _ = writeln!(text, "{name:<16} {ray:>16.2} {search:>12.2}");
        }
        let all = seconds.traversal + seconds.intersection;
        let _ = writeln!(text, "{:<16} {:>16} {:>12}", "searches", "seconds", "share");
        for (name, time) in [("  traversal", seconds.traversal), ("  intersection", seconds.intersection)] {
            let _ = writeln!(text, "{name:<16} {time:>16.3} {:>10.1} %", 100.0 * ratio(time, all));
        }
    }

    /// A line of a table of frames.
    pub(crate) fn cells(&self) -> [String; 6] {
        let Work { work_per_ray: ray, work_per_search: search, search_seconds: seconds } = self;
        [
            format!("{:.2}", ray.nodes),
            format!("{:.2}", ray.tests),
            format!("{:.2}", search.tests),
            format!("{:.2}", ray.nanoseconds),
            format!("{:.3}", seconds.traversal),
            format!("{:.3}", seconds.intersection),
        ]
    }
}

/// Titles of [`Work::cells`].
pub(crate) const WORK_TITLES: [&str; 6] =
    ["nodes/ray", "tests/ray", "tests/search", "ns/ray", "traversal s", "intersection s"];

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
        let _ = writeln!(
            text,
            "{}: {} x {} on {}",
            self.outputs.join(", "),
            self.width,
            self.height,
            self.backend
        );
        let pixels = self.width as f64 * self.height as f64 * (1.0 - self.resumed);
        ray_table(&mut text, &self.rays, pixels);
        if let Some(work) = &self.work {
            work.table(&mut text);
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

/// Rays by kind.
pub(crate) fn ray_table(text: &mut String, rays: &RayStatistics, pixels: f64) {
    let RayStatistics { camera, reflected, refracted, glossy, shadow, .. } = *rays;
    let _ = writeln!(text, "{:<16} {:>16} {:>12}", "rays", "number", "a pixel");
    let kinds = [
        ("  camera", camera),
        ("  reflected", reflected),
        ("  refracted", refracted),
        ("  glossy", glossy),
        ("  shadow", shadow),
        ("  all", rays.total_rays()),
    ];
    for (name, number) in kinds {
        let _ = writeln!(text, "{name:<16} {:>16} {:>12.2}", grouped(number), ratio(number as f64, pixels));
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

pub(crate) fn row(text: &mut String, name: &str, value: &str) {
    let _ = writeln!(text, "{name:<16} {value}");
}
