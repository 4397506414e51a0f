//! How many frames a second [`VideoWriter`] takes when nothing is rendered: storing, encoding and joining.
//!
//!     cargo run --release -p eosphor-picture --example encode [frames]
//!
//! The encoder is about three times as fast where `nasm` was installed when it was built.

use eosphor_picture::output::{Developed, FrameRate, VideoOptions, VideoWriter};
use std::error::Error;
use std::num::NonZeroUsize;
use std::time::Instant;

const SIZE: (u32, u32) = (1920, 1080);

/// Discs that move over a gradient, with noise as of a few samples a pixel.
fn picture(number: u32) -> Developed {
    let (width, height) = SIZE;
    let time = number as f32 / 30.0;
    let mut random = number.wrapping_mul(0x9e37_79b9) | 1;
    let mut rgb = Vec::with_capacity((width * height * 3) as usize);
    let discs: Vec<(f32, f32, f32)> = (0..6)
        .map(|i| {
            let phase = i as f32;
            let (x, y) =
                ((time + phase).cos() * 600.0 + 960.0, (0.8 * time + 2.0 * phase).sin() * 350.0 + 540.0);
            (x, y, 60.0 + 25.0 * phase)
        })
        .collect();
    for y in 0..height {
        for x in 0..width {
            let (fx, fy) = (x as f32, y as f32);
            let inside = discs.iter().rposition(|d| (fx - d.0).powi(2) + (fy - d.1).powi(2) < d.2 * d.2);
            let [r, g, b] = match inside {
                Some(i) => [230 - 30 * i as u32, 60 + 30 * i as u32, 90 + (x / 8 + y / 8) % 2 * 60],
                None => [40 + x * 120 / width, 60 + y * 120 / height, 120],
            };
            random ^= random << 13;
            random ^= random >> 17;
            random ^= random << 5;
            let noise = random % 5;
            rgb.extend_from_slice(&[(r + noise) as u8, (g + noise) as u8, (b + noise) as u8]);
        }
    }
    Developed { width, height, rgb, alpha: Vec::new() }
}

fn main() -> Result<(), Box<dyn Error>> {
    let frames: u32 = std::env::args().nth(1).map_or(Ok(120), |text| text.parse())?;
    // A second and a half of pictures, back and forth, so that making them is no part of the time.
    let pictures: Vec<Developed> = (0..frames.min(45)).map(picture).collect();
    let folder = tempfile::tempdir()?;
    for threads in [1, 2] {
        let options =
            VideoOptions { threads: NonZeroUsize::new(threads).ok_or("no threads")?, ..Default::default() };
        let path = folder.path().join(format!("{threads}.mp4"));
        let start = Instant::now();
        let video = VideoWriter::open(&path, SIZE, FrameRate::new(30, 1)?, frames, &options)?;
        for number in 0..frames {
            let way = number as usize % (2 * pictures.len());
            video.write_frame(number, &pictures[way.min(2 * pictures.len() - 1 - way)])?;
        }
        let stored = start.elapsed().as_secs_f64();
        video.finish()?;
        let seconds = start.elapsed().as_secs_f64();
        let megabits = path.metadata()?.len() as f64 * 8e-6 / (frames as f64 / 30.0);
        println!(
            "{threads} encoder threads: {frames} frames of 1920 x 1080 in {seconds:.2} s, {:.1} frames a second \
             (stored after {stored:.2} s; {megabits:.1} Mbit/s at 30 frames a second)",
            frames as f64 / seconds
        );
    }
    let same = std::fs::read(folder.path().join("1.mp4"))? == std::fs::read(folder.path().join("2.mp4"))?;
    println!("the files are {}", if same { "identical" } else { "DIFFERENT" });
    let sum = crc32fast::hash(&std::fs::read(folder.path().join("1.mp4"))?);
    println!("CRC-32 {sum:08x}");
    Ok(())
}
