//! `eosphor bench noise SCENE`: how much of a picture is noise.

use super::lines;
use crate::arguments::BenchNoiseFlags;
use crate::backend::{backend_for, limit_threads};
use crate::commands::scene::apply;
use crate::failure::Failure;
use crate::streams::{self, Verbosity};
use eosphor::{RenderControl, SceneData, load};
use eosphor_lab::Quantity;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The noise of each repetition: the root of the mean square of half the difference of two pictures of other seeds, times the root of
/// two. Errors of both are independent and equally large, so that is their standard deviation, without a picture that is thought true.
pub(crate) fn bench_noise(flags: &BenchNoiseFlags) -> Result<(), Failure> {
    limit_threads(&flags.device)?;
    let options =
        flags.settings.load_options(flags.camera.choice(), flags.picture.are_lit(), &flags.textures);
    let mut scene = load(&flags.scene, &options)?.scene;
    apply(&mut scene, &flags.picture, &flags.settings, &flags.camera)?;
    let backend = backend_for(&flags.device, flags.picture.accel, false, Verbosity::Normal)?;
    let (cancel, watch) = (AtomicBool::new(false), |_| ());
    let control = RenderControl { on_progress: &watch, cancel: &cancel, count_work: false, frame: None };
    let (first, mut rays) = (scene.settings.seed, 0);
    let mut values = Vec::new();
    for repeat in 0..flags.repeats as u32 {
        let mut pictures = Vec::new();
        for of_pair in 0..2 {
            scene.settings.seed = first.wrapping_add(2 * repeat + of_pair);
            let prepared = backend.prepare(Arc::new(SceneData::flatten(&scene)?.0))?;
            let rendered = prepared.render(&control)?;
            rays = rendered.statistics.total_rays();
            let channels = rendered.film.pixels.iter().flat_map(|color| [color.x, color.y, color.z]);
            pictures.push(channels.map(f64::from).collect::<Vec<f64>>());
        }
        let squares = pictures[0].iter().zip(&pictures[1]).map(|(a, b)| (a - b).powi(2));
        values.push((squares.sum::<f64>() / pictures[0].len().max(1) as f64 / 2.0).sqrt());
    }
    if let Some(0.0) = values.iter().copied().reduce(f64::min) {
        let problem =
            "pictures of other seeds are the same: nothing in this scene and these settings is random";
        return Err(Failure::usage(problem));
    }
    if flags.lines {
        let noise =
            Quantity { quantity: "noise".into(), unit: "radiance".into(), values, ..Quantity::default() };
        return streams::result(&lines(&[noise])?);
    }
    let text: String = values.iter().map(|noise| format!("noise {noise:.6}\n")).collect();
    streams::result(&format!(
        "{}; {} samples a pixel, {rays} rays\n{text}",
        backend.describe(),
        scene.settings.samples
    ))
}
