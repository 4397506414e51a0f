//! What the rays of an animation needed: of each frame and in total.

use crate::report::{WORK_TITLES, Work, hierarchy_rows, ray_table, row};
use crate::text::grouped;
use eosphor::job::FrameDone;
use eosphor::{HierarchyStatistics, RayStatistics};
use serde::Serialize;
use std::fmt::Write;

/// In total, and of each frame.
#[derive(Serialize)]
pub(super) struct FramesWork {
    rays: RayStatistics,
    #[serde(flatten)]
    work: Work,
    hierarchy: HierarchyStatistics,
    by_frame: Vec<FrameWork>,
}

#[derive(Serialize)]
struct FrameWork {
    frame: u32,
    total_rays: u64,
    rays: RayStatistics,
    #[serde(flatten)]
    work: Work,
}

impl FramesWork {
    pub(super) fn new(
        frames: &[FrameDone],
        rays: RayStatistics,
        hierarchy: HierarchyStatistics,
    ) -> FramesWork {
        let of_frame = |done: &FrameDone| FrameWork {
            frame: done.frame,
            total_rays: done.statistics.total_rays(),
            rays: done.statistics,
            work: Work::of(&done.statistics),
        };
        let by_frame = frames.iter().map(of_frame).collect();
        FramesWork { rays, work: Work::of(&rays), hierarchy, by_frame }
    }

    /// A line for each frame, and the tables of a still for all together.
    pub(super) fn table(&self, [width, height]: [u32; 2]) -> String {
        let mut text = String::new();
        line(&mut text, "frame", "rays", WORK_TITLES);
        for FrameWork { frame, total_rays, work, .. } in &self.by_frame {
            line(&mut text, &frame.to_string(), &grouped(*total_rays), work.cells().each_ref().map(|c| &**c));
        }
        let pixels = f64::from(width) * f64::from(height) * self.by_frame.len() as f64;
        ray_table(&mut text, &self.rays, pixels);
        self.work.table(&mut text);
        for (name, value) in hierarchy_rows(&self.hierarchy) {
            row(&mut text, name, &value);
        }
        text.truncate(text.trim_end().len());
        text
    }
}

fn line(text: &mut String, frame: &str, rays: &str, work: [&str; 6]) {
    let _ = write!(text, "{frame:>8} {rays:>16}");
    for cell in work {
        let _ = write!(text, " {cell:>14}");
    }
    text.push('\n');
}
