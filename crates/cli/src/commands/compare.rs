//! `eosphor compare A B`.

use crate::arguments::CompareFlags;
use crate::backend::start_threads;
use crate::failure::Failure;
use crate::streams;
use crate::text::grouped;
use eosphor::compare::{Comparison, compare as compare_pictures, difference_image};
use eosphor::job::{check_output, make_folder, same_file};
use eosphor::{Format, Picture, SaveOptions, save_developed};
use serde::Serialize;
use std::fmt::Write;

pub(crate) fn compare(flags: &CompareFlags) -> Result<(), Failure> {
    start_threads(0)?;
    if let Some(path) = &flags.diff {
        check_output(path).map_err(Failure::of_output)?;
        if Format::of(path).map_err(Failure::of_output)?.is_linear() {
            return Err(Failure::Usage(
                "--diff has bytes, not linear colours: use a name that ends in .png".into(),
            ));
        }
        if let Some(input) = [&flags.a, &flags.b].into_iter().find(|input| same_file(input, path)) {
            let (path, input) = (path.display(), input.display());
            return Err(Failure::Failed(format!(
                "cannot write the difference: {path}: this is {input}, which is compared: choose another name"
            )));
        }
    }
    let (a, b) = (Picture::read(&flags.a)?, Picture::read(&flags.b)?);
    let between = |error| {
        let (a, b) = (flags.a.display(), flags.b.display());
        Failure::Failed(format!("cannot compare: {a} and {b}: {error}"))
    };
    let comparison = compare_pictures(&a, &b).map_err(between)?;
    let amplified = match &flags.diff {
        Some(path) => {
            let (image, factor) = difference_image(&a, &b).map_err(between)?;
            make_folder(path)?;
            save_developed(&image, path, &SaveOptions::default())?;
            Some(factor)
        }
        None => None,
    };
    match flags.json {
        true => streams::json(&Json { comparison: &comparison, difference_amplified: amplified })?,
        false => streams::result(&describe(&comparison, amplified))?,
    }
    if comparison.identical { Ok(()) } else { Err(Failure::Different) }
}

#[derive(Serialize)]
struct Json<'a> {
    #[serde(flatten)]
    comparison: &'a Comparison,
    /// Factor of the difference image.
    #[serde(skip_serializing_if = "Option::is_none")]
    difference_amplified: Option<f64>,
}

fn describe(comparison: &Comparison, amplified: Option<f64>) -> String {
    let Some(first) = &comparison.first else { return "identical\n".into() };
    let values = |values: &[f32]| values.iter().map(f32::to_string).collect::<Vec<_>>().join(" ");
    let mut text = format!("different: first at ({}, {}): ", first.x, first.y);
    let _ = writeln!(text, "{} and {}", values(&first.a), values(&first.b));
    let pixels = comparison.width as u64 * comparison.height as u64;
    let share = comparison.differing_pixels as f64 / pixels as f64 * 100.0;
    let (some, all) = (grouped(comparison.differing_pixels), grouped(pixels));
    let _ = writeln!(text, "pixels that differ   {some} of {all} ({share:.3} %)");
    let _ = writeln!(text, "largest difference   {}", comparison.max_difference);
    let _ = writeln!(text, "RMSE                 {:.6}", comparison.rmse);
    let _ = writeln!(text, "PSNR                 {:.2} dB", comparison.psnr);
    if let Some(flip) = comparison.flip {
        let _ = writeln!(text, "FLIP                 {flip:.6}");
    }
    if let Some(factor) = amplified {
        let _ = writeln!(text, "difference image     amplified {factor:.1} times");
    }
    text
}
