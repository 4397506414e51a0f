//! How much of a picture is in memory at a time, and whether that fits. An allocation that does not would end the program
//! without a word.

use super::JobError;
use eosphor_render::{Bands, CameraWork, PixelFeatures};
use std::fs;

/// Linear film and developed bytes of a pixel; JPEG has these twice.
const BYTES_A_PIXEL: u64 = 12 + 3 + 3;

/// What stills add to that: sums of samples, as they are and as some more come to be added.
const SUM_BYTES_A_PIXEL: u64 = 24 + 24;

/// Frames come from other ranks as bytes first, of which rows are made.
const BYTES_A_FRAME_PIXEL: u64 = BYTES_A_PIXEL + 12 + 12;

/// Most pixels of a band of a picture without layers.
const MAX_BAND_PIXELS: u64 = 1 << 22;

/// What layers add to that.
const LAYER_BYTES_A_PIXEL: u64 = (size_of::<PixelFeatures>() + size_of::<CameraWork>()) as u64;

/// The bands that a picture is rendered in: of so many rows, where asked for, else such that their size is about the same
/// with layers as without. Fails where the memory that is free is too small for one.
pub(super) fn bands((width, height): (u32, u32), layers: bool, rows: Option<u32>) -> Result<Bands, JobError> {
    let without_layers = BYTES_A_PIXEL + SUM_BYTES_A_PIXEL;
    let bytes_a_pixel = without_layers + if layers { LAYER_BYTES_A_PIXEL } else { 0 };
    let pixels = MAX_BAND_PIXELS * without_layers / bytes_a_pixel;
    let bands = match rows {
        Some(rows) => Bands::of_rows(height, rows),
        None => Bands::of_pixels(width, height, pixels as u32),
    };
    let needed = width as u64 * bands.rows() as u64 * bytes_a_pixel;
    match available() {
        Some(free) => check_fits_in(free, needed).map(|()| bands),
        None => Ok(bands),
    }
}

/// How many frames are in work at a time: as many as wanted, as far as half of the memory that is free holds them. Fails where
/// it is too small for one.
pub(super) fn frames((width, height): (u32, u32), wanted: usize) -> Result<usize, JobError> {
    match available() {
        Some(free) => frames_in(free, (width, height), wanted),
        None => Ok(wanted),
    }
}

/// Bytes that the textures of a scene may take where nobody says it ([`eosphor_scene::LoadOptions::texture_memory_bytes`]):
/// half of what is free. `None` where the system does not say what is.
pub fn memory_for_textures() -> Option<u64> {
    available().map(|free| free / 2)
}

fn frames_in(free: u64, (width, height): (u32, u32), wanted: usize) -> Result<usize, JobError> {
    let pixels = u64::from(width) * u64::from(height);
    check_fits_in(free, pixels * BYTES_A_PIXEL)?;
    Ok((free / 2 / (pixels * BYTES_A_FRAME_PIXEL).max(1)).clamp(1, wanted.max(1) as u64) as usize)
}

fn check_fits_in(free: u64, needed: u64) -> Result<(), JobError> {
    if needed <= free {
        return Ok(());
    }
    Err(JobError::Memory { needed, free })
}

/// A number of bytes for people, with a unit of a power of 1000: `51.5 GB`.
pub fn bytes_in_words(number: u64) -> String {
    const UNITS: [&str; 5] = ["bytes", "kB", "MB", "GB", "TB"];
    let (mut value, mut unit) = (number as f64, 0);
    while value >= 999.5 && unit + 1 < UNITS.len() {
        value /= 1000.0;
        unit += 1;
    }
    if unit == 0 { format!("{number} bytes") } else { format!("{value:.1} {}", UNITS[unit]) }
}

/// What the system says is free, and no more than the control group may use; `None` where neither says.
fn available() -> Option<u64> {
    let system = fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
        Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
    });
    let of_group = |file: &str| fs::read_to_string(format!("/sys/fs/cgroup/{file}")).ok();
    let number = |text: String| text.trim().parse::<u64>().ok();
    // "max" where there is no limit. What is in use counts file caches, which the group gives back.
    let group = of_group("memory.max").and_then(number).map(|most| {
        let used = of_group("memory.current").and_then(number).unwrap_or(0);
        let caches = of_group("memory.stat").and_then(|text| {
            text.lines().find_map(|line| line.strip_prefix("inactive_file ")?.trim().parse::<u64>().ok())
        });
        most.saturating_sub(used.saturating_sub(caches.unwrap_or(0)))
    });
    system.into_iter().chain(group).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_picture_takes_no_more_than_others() {
        for layers in [false, true] {
            let bands = bands((65_535, 65_535), layers, None).unwrap();
            let bytes = 65_535 * bands.rows() as u64 * if layers { 66 + 56 } else { 66 };
            assert!((1 << 27..400 << 20).contains(&bytes), "{bytes}");
        }
        assert_eq!(bands((1920, 1080), true, None).unwrap().count(), 1);
        assert_eq!(bands((100, 50), false, Some(20)).unwrap().count(), 3);
    }

    #[test]
    fn bytes_for_people() {
        let words = [0, 999, 1000, 51_540_000_000].map(bytes_in_words);
        assert_eq!(words, ["0 bytes", "999 bytes", "1.0 kB", "51.5 GB"]);
    }

    #[test]
    fn what_does_not_fit_is_one_line() {
        let line = check_fits_in(1 << 20, 1 << 27).unwrap_err().to_string();
        assert!(line.contains("needs 134.2 MB, and 1.0 MB are free"), "{line}");
        assert!(check_fits_in(1 << 27, 1 << 27).is_ok());
    }

    #[test]
    fn no_more_frames_are_in_work_than_half_of_the_memory_holds() {
        let frame = 1920 * 1080 * 42;
        assert_eq!(frames_in(100 * frame, (1920, 1080), 27).unwrap(), 27);
        assert_eq!(frames_in(20 * frame, (1920, 1080), 27).unwrap(), 10);
        assert_eq!(frames_in(frame, (1920, 1080), 27).unwrap(), 1);
        assert!(frames_in(frame / 3, (1920, 1080), 27).is_err());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn linux_says_what_is_free() {
        assert!(available().is_some_and(|free| free > 1 << 20));
    }
}
