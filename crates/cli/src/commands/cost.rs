//! `eosphor render --show cost`: what the camera rays of each pixel cost, in false colours.

use crate::arguments::RenderFlags;
use crate::backend::cpu_options;
use crate::failure::Failure;
use crate::outputs::names;
use crate::report::hierarchy_rows;
use crate::streams::{self, Verbosity};
use crate::watcher::Watcher;
use eosphor::job::{CostPicture, Output};
use eosphor::{HierarchyStatistics, Scene};
use serde::Serialize;

/// Nodes and tests of a pixel's camera rays.
#[derive(Serialize)]
struct CostReport<'a> {
    /// What the brightest colour stands for.
    brightest: u32,
    mean: f64,
    largest: u32,
    hierarchy: &'a HierarchyStatistics,
}

pub(super) fn show_cost(
    flags: &RenderFlags,
    scene: &Scene,
    outputs: Vec<Output>,
    watcher: &Watcher,
) -> Result<(), Failure> {
    let written = names(&outputs);
    let cpu = cpu_options(&flags.device, flags.picture.accel);
    let accel = cpu.accel;
    let picture = CostPicture {
        outputs,
        file: flags.file_options(),
        brightest: flags.show_max,
        cpu,
        most_rows: flags.file.band_rows,
        ..CostPicture::new(scene)
    };
    let outcome = watcher.run(|control| picture.run(control))?;
    if !outcome.complete {
        return Err(Failure::Interrupted(format!(
            "interrupted: {written}: nothing was written: costs are shown of whole pictures"
        )));
    }
    let (brightest, mean, largest) = (outcome.brightest, outcome.mean, outcome.largest);
    if flags.report.json {
        streams::json(&CostReport { brightest, mean, largest, hierarchy: &outcome.hierarchy })?;
    }
    let verbosity = flags.report.verbosity();
    verbosity.say(
        Verbosity::Normal,
        &format!(
            "{written}: nodes and tests of the camera rays of each pixel, hierarchy {accel}: the brightest stands \
             for {brightest}; {mean:.2} on average, {largest} at most"
        ),
    );
    for (name, value) in hierarchy_rows(&outcome.hierarchy) {
        verbosity.say(Verbosity::Verbose, &format!("{name:<16} {value}"));
    }
    Ok(())
}
