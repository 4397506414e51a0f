//! Writes a report of runs that were never measured, to look at: `cargo run -p eosphor-lab --example sample_report FOLDER`.

#[path = "../tests/sample.rs"]
mod sample;

use eosphor_lab::{ReportPicture, write_report};
use std::path::PathBuf;

fn main() {
    let folder = PathBuf::from(std::env::args_os().nth(1).unwrap_or_else(|| "sample-report".into()));
    let mut runs = sample::all_cases();
    if std::env::args().any(|argument| argument == "two") {
        runs.push(sample::of_another_machine());
    }
    // Pictures of one pixel: red and blue.
    let red = include_bytes!("red.png").to_vec();
    let blue = include_bytes!("blue.png").to_vec();
    let pictures = [ReportPicture {
        experiment: "samples".into(),
        title: "A chair.".into(),
        caption: "A: 16 samples for each pixel; B: 64.".into(),
        a_png: red.clone(),
        b_png: Some(blue),
        heat_png: Some(red),
    }];
    match write_report(&runs, &pictures, &folder) {
        Ok(paths) => println!("{} files in {}", paths.len(), folder.display()),
        Err(error) => eprintln!("{error}"),
    }
}
