//! The resolution and JPEG quality of frames while the camera moves: what is rendered, encoded and sent in time.

use std::time::Duration;

/// The time that a moving frame may take to be rendered and encoded.
pub(crate) const FRAME: Duration = Duration::from_millis(33);

/// The time that the bytes of a moving frame may take on the line: those of one are there when the next is rendered, and none
/// waits.
pub(crate) const LINE: Duration = FRAME;

/// The time that a piece of a picture at rest may take on the line: a camera that moves again waits for two of them at most.
const PIECE: Duration = Duration::from_millis(50);

/// Bytes of a piece: at least and at most, and while nothing is known of the line.
const PIECE_BYTES: [f64; 2] = [16_384.0, 1_048_576.0];
const FIRST_PIECE_BYTES: f64 = 65_536.0;

/// Less time than this was measured by accident.
const LEAST_TIME: Duration = Duration::from_millis(1);

/// How much of what was known of the line counts after another frame: a quarter of a second is remembered.
pub(crate) const MEMORY: f64 = 0.85;

/// No side is shorter than this share of the one at rest.
pub(crate) const LEAST_SCALE: f64 = 0.25;

/// The time in seconds that a JPEG may take on a line that is quick enough for JPEGs.
pub(crate) const LINE_OF_JPEG: f64 = 0.011;

/// After so many JPEGs in a row that took longer, the line is too slow for them.
const SLOW_JPEGS: u32 = 8;

/// JPEG qualities of moving frames.
const QUALITIES: std::ops::RangeInclusive<f64> = 35.0..=85.0;

/// What a page's frames cost lately, and what follows for the next one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quality {
    /// Share of a side.
    scale: f64,
    /// Of JPEGs.
    jpeg: f64,
    /// JPEGs in a row that took long on the line.
    slow_jpegs: u32,
    /// Bytes that went over the line lately, and the seconds that they took; newer ones count for more.
    passed: [f64; 2],
}

impl Default for Quality {
    fn default() -> Quality {
        Quality { scale: 0.5, jpeg: 80.0, slow_jpegs: 0, passed: [0.0; 2] }
    }
}

impl Quality {
    /// The size of the next frame, for this one at rest.
    pub(crate) fn size(&self, full: [u32; 2]) -> [u32; 2] {
        full.map(|side| ((f64::from(side) * self.scale).round() as u32).clamp(1, side))
    }

    /// The JPEG quality of the next frame.
    pub(crate) fn jpeg(&self) -> u8 {
        self.jpeg.round() as u8
    }

    /// Whether the line is too slow for JPEGs.
    pub(crate) fn is_too_slow_for_jpegs(&self) -> bool {
        self.slow_jpegs >= SLOW_JPEGS
    }

    /// That of a page which has had no frames, on the line that is known.
    pub(crate) fn restarted(&self) -> Quality {
        Quality { passed: self.passed, ..Quality::default() }
    }

    /// Share of a side that the next frame has.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// Bytes a second that the line takes; `None`: that is not known yet.
    pub(crate) fn line(&self) -> Option<f64> {
        let [bytes, seconds] = self.passed;
        (seconds > 0.0).then(|| bytes / seconds)
    }

    /// Bytes of a piece of a picture at rest.
    pub(crate) fn piece_bytes(&self) -> usize {
        let bytes = self.line().map_or(FIRST_PIECE_BYTES, |line| line * PIECE.as_secs_f64());
        bytes.clamp(PIECE_BYTES[0], PIECE_BYTES[1]) as usize
    }

    /// Learns from a frame that took so long to be rendered, and has so many bytes.
    pub(crate) fn rendered(&mut self, took: Duration, bytes: usize) {
        let of_time = FRAME.as_secs_f64() / took.as_secs_f64().max(1e-4);
        let of_line = self.line().map_or(2.0, |line| line * LINE.as_secs_f64() / bytes.max(1) as f64);
        let is_slow = self.line().is_some_and(|line| bytes as f64 / line > LINE_OF_JPEG);
        self.slow_jpegs = if is_slow { self.slow_jpegs.saturating_add(1) } else { 0 };
        // First the quality pays for a slow line, then the resolution.
        let quality_pays = self.jpeg > *QUALITIES.start();
        if of_line < 1.0 && quality_pays {
            self.jpeg = (self.jpeg * of_line.max(0.8)).max(*QUALITIES.start());
        } else if of_line > 1.3 {
            self.jpeg = (self.jpeg + 2.0).min(*QUALITIES.end());
        }
        let pixels = of_time.min(if quality_pays { of_line.max(1.0) } else { of_line });
        // Up slowly and down quickly; a little more or less is not worth a change that can be seen.
        let factor = pixels.sqrt().clamp(0.6, 1.1);
        if !(0.95..1.05).contains(&factor) {
            self.scale = (self.scale * factor).clamp(LEAST_SCALE, 1.0);
        }
    }

    /// Learns from a frame of so many bytes that took so long on the line.
    ///
    /// Of the sums, not of each frame's rate: what was held up somewhere and came at once would count as a line without limits.
    pub(crate) fn passed(&mut self, bytes: usize, took: Duration) {
        let new = [bytes as f64, took.max(LEAST_TIME).as_secs_f64()];
        self.passed = [0, 1].map(|k| MEMORY * self.passed[k] + new[k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_frames_become_small_and_fast_ones_whole() {
        let mut quality = Quality::default();
        for _ in 0..50 {
            quality.rendered(Duration::from_millis(200), 10_000);
        }
        assert_eq!(quality.size([640, 360]), [160, 90]);
        for _ in 0..50 {
            quality.rendered(Duration::from_millis(5), 10_000);
        }
        assert_eq!((quality.size([640, 360]), quality.jpeg()), ([640, 360], 85));
        assert_eq!(quality.size([1, 1]), [1, 1]);
    }

    /// What frames cost that have so many bytes for each pixel of a quality of 100.
    fn bytes(quality: &Quality, full: [u32; 2], per_pixel: f64) -> usize {
        let size = quality.size(full);
        (f64::from(size[0] * size[1]) * per_pixel * f64::from(quality.jpeg()) / 100.0) as usize
    }

    #[test]
    fn a_slow_line_costs_quality_first() {
        let mut quality = Quality::default();
        // 100 kB a second.
        quality.passed(10_000, Duration::from_millis(100));
        quality.rendered(Duration::from_millis(33), 20_000);
        assert!(quality.jpeg() < 80 && quality.size([100, 100]) == [50, 50]);
        for _ in 0..50 {
            quality.rendered(Duration::from_millis(33), 20_000);
        }
        assert_eq!((quality.jpeg(), quality.size([100, 100])), (35, [25, 25]));
    }

    #[test]
    fn frames_fill_the_line_and_come_to_rest() {
        // 10 Mbit/s.
        let line = 1.25e6;
        for (full, per_pixel) in [([640, 360], 0.2), ([1920, 1080], 0.2), ([3840, 2160], 0.2)] {
            let mut quality = Quality::default();
            let mut sizes = Vec::new();
            for _ in 0..300 {
                let bytes = bytes(&quality, full, per_pixel);
                quality.passed(bytes, Duration::from_secs_f64(bytes as f64 / line));
                quality.rendered(Duration::from_millis(5), bytes);
                sizes.push((quality.size(full), quality.jpeg()));
            }
            let (last, seconds) = (sizes[299], bytes(&quality, full, per_pixel) as f64 / line);
            assert!(sizes[200..].iter().all(|size| *size == last), "{full:?}: {:?}", &sizes[200..]);
            let is_whole = last == (full, 85);
            assert!(seconds < 0.04 && (is_whole || seconds > 0.02), "{full:?}: {last:?}, {seconds} s");
        }
    }

    #[test]
    fn a_frame_that_was_held_up_and_one_that_came_at_once_are_a_line_as_before() {
        let mut quality = Quality::default();
        for k in 0..100 {
            let ms = [33, 33, 66, 0][k % 4];
            quality.passed(33_000, Duration::from_millis(ms));
        }
        assert!((quality.line().unwrap() / 1e6 - 1.0).abs() < 0.25, "{:?}", quality.line());
    }
}
