//! From frames to files and back.

mod file;
mod live;
mod resume;
mod tools;

use super::*;
use crate::output::{Developed, OutputError};
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// A smooth, colourful picture in which everything moves.
fn frame(number: u32, (width, height): (u32, u32)) -> Developed {
    let mut rgb = Vec::with_capacity((width * height * 3) as usize);
    let wave = |x: f64| (127.5 + 110.0 * x.sin()) as u8;
    let time = number as f64 * 0.15;
    for y in 0..height {
        for x in 0..width {
            let (x, y) = (x as f64 * 0.05, y as f64 * 0.04);
            rgb.extend_from_slice(&[wave(x + time), wave(y - 0.7 * time), wave(0.6 * x + y + 1.3 * time)]);
        }
    }
    Developed { width, height, rgb, alpha: Vec::new() }
}

fn options(threads: usize) -> VideoOptions {
    VideoOptions { threads: NonZeroUsize::new(threads).unwrap(), ..VideoOptions::default() }
}

fn rate() -> FrameRate {
    FrameRate::new(30_000, 1001).unwrap()
}

fn open(path: &Path, size: (u32, u32), frames: u32, threads: usize) -> VideoWriter {
    VideoWriter::open(path, size, rate(), frames, &options(threads)).unwrap()
}

/// The video of a run that nothing disturbs.
fn undisturbed(size: (u32, u32), frames: u32) -> Vec<u8> {
    let (folder, path) = in_folder();
    let video = open(&path, size, frames, 1);
    for number in 0..frames {
        video.write_frame(number, &frame(number, size)).unwrap();
    }
    video.finish().unwrap();
    assert_eq!(names(folder.path()), ["a.mp4"], "nothing is left but the video");
    fs::read(&path).unwrap()
}

fn in_folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mp4");
    (folder, path)
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = entries.collect();
    names.sort();
    names
}

/// Waits until all segments are encoded whose frames are there.
fn wait_for(video: &VideoWriter, encoded: u32) {
    let start = std::time::Instant::now();
    while video.encoded_frames() < encoded {
        assert!(start.elapsed().as_secs() < 60, "the encoder hangs");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

fn refused(result: Result<VideoWriter, OutputError>) -> String {
    match result {
        Ok(_) => panic!("it should have been refused"),
        Err(error) => error.to_string(),
    }
}
