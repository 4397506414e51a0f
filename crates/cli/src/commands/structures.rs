//! `eosphor info --accel all SCENE`: every structure over one scene.

use crate::arguments::InfoFlags;
use crate::backend::{builder_for, cpu_backend};
use crate::failure::Failure;
use crate::streams;
use crate::text::grouped;
use eosphor::{Accel, CameraSpeed, Hierarchy, HierarchyStatistics, SceneData};
use serde::Serialize;
use std::fmt::Write;
use std::time::Duration;

/// Camera rays are traced for so long, by each structure.
const TRACING: Duration = Duration::from_millis(500);

#[derive(Serialize)]
struct Row {
    accel: Accel,
    statistics: HierarchyStatistics,
    /// On one thread.
    camera_rays: CameraSpeed,
}

pub(super) fn structures(flags: &InfoFlags, data: &SceneData) -> Result<(), Failure> {
    let mut rows = Vec::new();
    for &accel in Accel::ALL {
        let backend = cpu_backend(&flags.device, Some(accel))?;
        let hierarchy = Hierarchy::build(accel, builder_for(&flags.device), data);
        let camera_rays = backend.camera_speed(data, &hierarchy, TRACING);
        rows.push(Row { accel, statistics: hierarchy.statistics(), camera_rays });
    }
    if flags.json { streams::json(&rows) } else { streams::result(&table(&rows)) }
}

/// Titles of the columns.
const TITLES: [&str; 13] = [
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
        "nodes/ray, tests/ray and Mrays/s are of camera rays on one thread; depth and leaf size are means\n",
    );
    text
}

impl Row {
    fn cells(&self) -> [String; TITLES.len()] {
        let Row { accel, statistics: s, camera_rays: rays } = self;
        [
            accel.to_string(),
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
            format!("{:.3}", rays.mrays_per_second),
        ]
    }
}
