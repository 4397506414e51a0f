//! What a video is.

use super::{FrameRate, SEGMENT_FRAMES, misuse};
use serde::{Deserialize, Serialize};
use std::io::Error;
use std::num::NonZeroUsize;
use std::ops::Range;

/// Raised whenever the files of the folder, the colours or the encoder change, so that no video is joined from parts
/// that do not fit.
const FORMAT: u32 = 1;

/// The most frames of a video: four days at 24 frames a second.
pub const MAX_FRAMES: u32 = 10_000_000;

/// The smallest side that the encoder takes.
const SMALLEST: u32 = 16;

/// The longer and the shorter side of the largest picture that the encoder takes.
const LARGEST: (u32, u32) = (3840, 2160);

/// How a video is encoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VideoOptions {
    /// 1 to 100. Every frame gets it, whatever bytes it takes. At 90, the default, smooth shading shows no blocks; 80
    /// takes about half the bytes.
    pub quality: u8,
    /// Segments that are encoded at the same time. The file's bytes do not depend on it.
    pub threads: NonZeroUsize,
}

impl Default for VideoOptions {
    fn default() -> VideoOptions {
        VideoOptions { quality: 90, threads: NonZeroUsize::MIN }
    }
}

/// The size of a video of pictures of this size: colours are stored for 2 × 2 pixels, so odd sides have their last
/// column or row twice.
pub fn padded_size((width, height): (u32, u32)) -> (u32, u32) {
    let even = |side: u32| side.saturating_add(side % 2);
    (even(width), even(height))
}

/// Whether the encoder takes pictures of this size.
///
/// # Errors
/// What it takes.
pub fn check_video_size((width, height): (u32, u32)) -> Result<(), String> {
    let (longer, shorter) = (width.max(height), width.min(height));
    // What counts is the size with padding: 15 pixels become 16.
    if padded_size((shorter, shorter)).0 < SMALLEST || longer > LARGEST.0 || shorter > LARGEST.1 {
        return Err(format!(
            "{width} x {height} pixels: the encoder takes {SMALLEST} x {SMALLEST} to {} x {}; choose a size between",
            LARGEST.0, LARGEST.1
        ));
    }
    Ok(())
}

/// The quantisation parameter of H.264: 6 more are half the precision.
pub(super) fn quantiser(quality: u8) -> Result<u8, Error> {
    // The encoder knows no finer one than 12.
    match quality {
        1..=100 => Ok(51 - ((quality as u32 - 1) * 39 / 99) as u8),
        _ => Err(misuse(format!("video quality {quality}: it must be 1 to 100"))),
    }
}

/// All that the bytes of the file depend on besides the frames; kept in the folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Settings {
    format: u32,
    pub(super) width: u32,
    pub(super) height: u32,
    /// Frames a second: numerator and denominator.
    rate: (u32, u32),
    pub(super) frames: u32,
    quality: u8,
    segment_frames: u32,
}

impl Settings {
    pub(super) fn new(
        (width, height): (u32, u32),
        rate: FrameRate,
        frames: u32,
        quality: u8,
    ) -> Result<Settings, Error> {
        check_video_size((width, height)).map_err(misuse)?;
        if !(1..=MAX_FRAMES).contains(&frames) {
            return Err(misuse(format!("{frames} frames: a video has 1 to {MAX_FRAMES}")));
        }
        quantiser(quality)?;
        let rate = (rate.numerator(), rate.denominator());
        Ok(Settings { format: FORMAT, width, height, rate, frames, quality, segment_frames: SEGMENT_FRAMES })
    }

    pub(super) fn rate(&self) -> Result<FrameRate, Error> {
        FrameRate::new(self.rate.0, self.rate.1).map_err(|error| misuse(error.to_string()))
    }

    pub(super) fn quantiser(&self) -> Result<u8, Error> {
        quantiser(self.quality)
    }

    pub(super) fn segments(&self) -> u32 {
        self.frames.div_ceil(SEGMENT_FRAMES)
    }

    /// The frames of a segment; the last one may have fewer.
    pub(super) fn frames_of(&self, segment: u32) -> Range<u32> {
        let first = segment * SEGMENT_FRAMES;
        first..self.frames.min(first + SEGMENT_FRAMES)
    }

    /// How `other` differs, in words.
    pub(super) fn difference(&self, other: &Settings) -> Option<String> {
        let differs = |name: &str, a: &dyn ToString, b: &dyn ToString| {
            let (a, b) = (a.to_string(), b.to_string());
            (a != b).then(|| format!("{name} {a} instead of {b}"))
        };
        let size = |s: &Settings| format!("{} x {}", s.width, s.height);
        let rate = |s: &Settings| match s.rate {
            (frames, 1) => frames.to_string(),
            (frames, seconds) => format!("{frames}/{seconds}"),
        };
        let format = |s: &Settings| format!("{}.{}", s.format, s.segment_frames);
        differs("the program's video format", &format(self), &format(other))
            .or_else(|| differs("size", &size(self), &size(other)))
            .or_else(|| differs("frames a second", &rate(self), &rate(other)))
            .or_else(|| differs("number of frames", &self.frames, &other.frames))
            .or_else(|| differs("quality", &self.quality, &other.quality))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn qualities_span_the_encoder() {
        assert_eq!([1, 80, 100].map(|q| quantiser(q).unwrap()), [51, 20, 12]);
        assert!(quantiser(0).is_err() && quantiser(101).is_err());
        assert!((1..100).all(|q| quantiser(q + 1).unwrap() <= quantiser(q).unwrap()));
    }

    #[test]
    fn what_cannot_be_a_video_is_refused() {
        let rate = FrameRate::new(24, 1).unwrap();
        let new = |size, frames| Settings::new(size, rate, frames, 80);
        for size in [(16, 15), (3840, 2160), (2160, 3840)] {
            assert!(new(size, 1).is_ok());
        }
        for size in
            [(0, 99), (99, 0), (14, 99), (3841, 2160), (3840, 2161), (2161, 2161), (u32::MAX, u32::MAX)]
        {
            assert!(new(size, 1).is_err(), "{size:?}");
        }
        assert!(new((16, 16), 0).is_err() && new((16, 16), u32::MAX).is_err());
    }

    #[test]
    fn segments_cover_all_frames_once() {
        for frames in [1, 29, 30, 31, 60, 61] {
            let settings = Settings::new((16, 16), FrameRate::new(24, 1).unwrap(), frames, 80).unwrap();
            let covered: Vec<u32> = (0..settings.segments()).flat_map(|s| settings.frames_of(s)).collect();
            assert_eq!(covered, Vec::from_iter(0..frames));
        }
    }
}
