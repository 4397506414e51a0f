//! `eosphor info --accel all SCENE`: every structure over one scene; `--accel builders`: every builder.

use crate::arguments::InfoFlags;
use crate::backend::{check_ranges, cpu_backend, hierarchy_options};
use crate::failure::Failure;
use crate::streams;
use crate::text::grouped;
use eosphor::{
    Accel, Builder, CameraSpeed, HierarchyOptions, HierarchyStatistics, Quality, SceneData, build_hierarchy,
};
use serde::Serialize;
use std::fmt::Write;
use std::time::Duration;

/// Camera rays are traced for so long, by each structure.
const TRACING: Duration = Duration::from_millis(500);

#[derive(Serialize)]
struct Row {
    accel: Accel,
    /// The builder, where the structure is a bounding volume hierarchy.
    builder: Option<&'static str>,
    statistics: HierarchyStatistics,
    /// On one thread.
    camera_rays: CameraSpeed,
}

/// `by_builder`: bounding volume hierarchies alone, by every builder.
pub(super) fn structures(flags: &InfoFlags, data: &SceneData, by_builder: bool) -> Result<(), Failure> {
    check_ranges(&flags.device)?;
    let is_built = |accel: &&Accel| matches!(accel, Accel::Bvh | Accel::Bvh8);
    let chosen: Vec<(Accel, HierarchyOptions)> = if by_builder {
        let with = HierarchyOptions::with_builder;
        let with_all = |&accel: &Accel| Builder::ALL.map(|builder| (accel, with(builder)));
        Accel::ALL.iter().filter(is_built).flat_map(with_all).collect()
    } else {
        Accel::ALL.iter().map(|&accel| (accel, hierarchy_options(&flags.device))).collect()
    };
    let mut rows = Vec::new();
    for (accel, options) in chosen {
        let backend = cpu_backend(&flags.device, Some(accel))?;
        let hierarchy = build_hierarchy(accel, &options, data)?;
        let camera_rays = backend.camera_speed(data, &hierarchy, TRACING);
        let builder =
            is_built(&&accel).then(|| options.builder.unwrap_or(Quality::default().options().builder).name());
        rows.push(Row { accel, builder, statistics: hierarchy.statistics(), camera_rays });
    }
    if flags.json { streams::json(&rows) } else { streams::result(&table(&rows)) }
}

/// Titles of the columns.
const TITLES: [&str; 14] = [
    "hierarchy",
    "build s",
    "nodes",
    "leaves",
    "depth",
    "max",
    "leaf size",
    "max",
    "SAH cost",
    "MB",
    "nodes/ray",
    "tests/ray",
    "Mrays/s",
    "diffuse",
];

fn table(rows: &[Row]) -> String {
    let mut cells = vec![TITLES.map(String::from)];
    cells.extend(rows.iter().map(Row::cells));
    let width = |column: usize| cells.iter().map(|row| row[column].len()).max().unwrap_or(0);
    let widths: [usize; TITLES.len()] = std::array::from_fn(width);
    let mut text = String::new();
    for row in &cells {
        let _ = write!(text, "{:<1$}", row[0], widths[0]);
        for (cell, width) in row.iter().zip(widths).skip(1) {
            let _ = write!(text, "  {cell:>width$}");
        }
        text.push('\n');
    }
    text.push_str(
        "nodes/ray, tests/ray and Mrays/s are of camera rays on one thread, diffuse is Mrays/s of rays from what \
         they hit; depth and leaf size are means\n",
    );
    text
}

impl Row {
    fn cells(&self) -> [String; TITLES.len()] {
        let Row { accel, builder, statistics: s, camera_rays: rays } = self;
        [
            builder.map_or(accel.to_string(), |builder| format!("{accel} {builder}")),
            format!("{:.3}", s.build_seconds),
            grouped(s.nodes),
            grouped(s.leaves),
            format!("{:.2}", s.mean_leaf_depth),
            s.max_leaf_depth.to_string(),
            format!("{:.2}", s.mean_leaf_primitives),
            s.max_leaf_primitives.to_string(),
            format!("{:.2}", s.sah_cost),
            format!("{:.1}", s.bytes as f64 * 1e-6),
            format!("{:.2}", rays.nodes_a_ray),
            format!("{:.2}", rays.tests_a_ray),
            format!("{:.4}", rays.mrays_per_second),
            format!("{:.4}", rays.diffuse_mrays_per_second),
        ]
    }
}
