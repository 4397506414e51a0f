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

/// The noise of each repetition: the root mean square of the difference of two pictures with seeds of their own, over the root of
/// two. The errors of both are independent and equally large, so that is the standard deviation of one, and no picture has to be
/// thought true.
pub(crate) fn bench_noise(flags: &BenchNoiseFlags) -> Result<(), Failure> {
    limit_threads(&flags.device)?;
    let options = flags.settings.load_options(flags.camera.choice(), &flags.picture, &flags.textures);
    let mut scene = load(&flags.scene, &options)?.scene;
    apply(&mut scene, &flags.picture, &flags.settings, &flags.camera, &flags.textures)?;
    flags.device.check_paths()?;
    let backend = backend_for(&flags.device, flags.picture.accel, false, Verbosity::Normal)?;
    let (cancel, watch) = (AtomicBool::new(false), |_| ());
    let control = RenderControl { on_progress: &watch, cancel: &cancel, count_work: false, frame: None };
    let samples = scene.settings.samples;
    // How many pictures are averaged, so that no two samples know of each other.
    let averaged = if flags.independent { samples } else { 1 };
    scene.settings.samples = samples / averaged;
    let mut seed = scene.settings.seed;
    let mut picture = || -> Result<Vec<f64>, Failure> {
        let mut sum: Vec<f64> = Vec::new();
        for _ in 0..averaged {
            scene.settings.seed = seed;
            seed = seed.wrapping_add(1);
            let prepared = backend.prepare(Arc::new(SceneData::flatten(&scene)?.0))?;
            let film = prepared.render(&control)?.film;
            sum.resize(3 * film.pixels.len(), 0.0);
            let channels = film.pixels.iter().flat_map(|color| [color.x, color.y, color.z]);
            sum.iter_mut().zip(channels).for_each(|(sum, channel)| *sum += f64::from(channel));
        }
        sum.iter_mut().for_each(|sum| *sum /= f64::from(averaged));
        Ok(sum)
    };
    let mut values = Vec::with_capacity(flags.repeats);
    for _ in 0..flags.repeats {
        let [one, other] = [picture()?, picture()?];
        let squares = one.iter().zip(&other).map(|(a, b)| (a - b).powi(2));
        values.push((squares.sum::<f64>() / one.len().max(1) as f64 / 2.0).sqrt());
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
    streams::result(&format!("{}; {samples} samples a pixel\n{text}", backend.describe()))
}
