//! `eosphor render --show cost`: what the camera rays of each pixel cost, in false colours.

use crate::arguments::RenderFlags;
use crate::backend::feature_pass;
use crate::failure::Failure;
use crate::interrupt;
use crate::report::hierarchy_rows;
use crate::streams::{self, Verbosity};
use crate::target::{Target, names};
use eosphor::{Bands, CostMap, CpuOptions, DevelopSettings, HierarchyStatistics, SaveOptions, SceneData};
use serde::Serialize;
use std::sync::Arc;
use std::sync::atomic::Ordering;

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
    data: Arc<SceneData>,
    bands: Bands,
    outputs: &[(Target, SaveOptions)],
) -> Result<(), Failure> {
    let width = data.settings.width;
    let pass = feature_pass(&flags.device, flags.picture.accel, data, None)?;
    let mut work = Vec::new();
    for rows in bands {
        work.extend(pass.rows(rows, None, interrupt::flag())?.work);
        if interrupt::flag().load(Ordering::Relaxed) {
            let written = names(outputs.iter().map(|(target, _)| target));
            return Err(Failure::Interrupted(format!(
                "interrupted: {written}: nothing was written: costs are shown of whole pictures"
            )));
        }
    }
    let map = CostMap::new(&work, width, flags.show_max);
    for (target, options) in outputs {
        // The colours are meant as they are: neither the scene's exposure nor its curve is for them.
        let options = SaveOptions { develop: DevelopSettings::default(), ..options.clone() };
        target.make_folder()?;
        let mut writer = target.open((map.film.width, map.film.height), &options)?;
        writer.write_rows(&map.film, None)?;
        writer.finish()?;
    }
    let hierarchy = pass.hierarchy_statistics();
    if flags.report.json {
        let CostMap { brightest, mean, largest, .. } = map;
        streams::json(&CostReport { brightest, mean, largest, hierarchy: &hierarchy })?;
    }
    let verbosity = flags.report.verbosity();
    let accel = flags.picture.accel.unwrap_or(CpuOptions::default().accel);
    let CostMap { brightest, mean, largest, .. } = map;
    let written = names(outputs.iter().map(|(target, _)| target));
    verbosity.say(
        Verbosity::Normal,
        &format!(
            "{written}: nodes and tests of the camera rays of each pixel, hierarchy {accel}: the brightest stands \
             for {brightest}; {mean:.2} on average, {largest} at most"
        ),
    );
    for (name, value) in hierarchy_rows(&hierarchy) {
        verbosity.say(Verbosity::Verbose, &format!("{name:<16} {value}"));
    }
    Ok(())
}
