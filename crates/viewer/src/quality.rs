//! The resolution and JPEG quality of frames while the camera moves: what is rendered, encoded and sent in time.

use std::time::{Duration, Instant};

/// The time that a moving frame may take to be rendered and encoded.
const FRAME: Duration = Duration::from_millis(33);

/// The time that the bytes of a moving frame may take on the line.
const LINE: Duration = Duration::from_millis(50);

/// No side is shorter than this share of the one at rest.
const LEAST_SCALE: f64 = 0.25;

/// JPEG qualities of moving frames.
const QUALITIES: std::ops::RangeInclusive<f64> = 35.0..=85.0;

/// What a page's frames cost lately, and what follows for the next one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quality {
    /// Share of a side.
    scale: f64,
    /// Of JPEGs.
    jpeg: f64,
    /// Bytes a second that the line took lately, where it was the limit.
    line: Option<f64>,
}

impl Default for Quality {
    fn default() -> Quality {
        Quality { scale: 0.5, jpeg: 80.0, line: None }
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

    /// Learns from a frame that took so long and has so many bytes.
    pub(crate) fn rendered(&mut self, took: Duration, bytes: usize) {
        let of_time = FRAME.as_secs_f64() / took.as_secs_f64().max(1e-4);
        let of_line = self.line.map_or(2.0, |line| line * LINE.as_secs_f64() / bytes.max(1) as f64);
        // First the quality pays for a slow line, then the resolution.
        if of_line < 1.0 && self.jpeg > *QUALITIES.start() {
            self.jpeg = (self.jpeg * of_line.max(0.8)).max(*QUALITIES.start());
        } else if of_line > 1.3 {
            self.jpeg = (self.jpeg + 2.0).min(*QUALITIES.end());
        }
        let line_counts = self.jpeg <= *QUALITIES.start();
        let pixels = if line_counts { of_time.min(of_line) } else { of_time };
        // Up slowly and down quickly; a little more or less is not worth a change that can be seen.
        let factor = pixels.sqrt().clamp(0.6, 1.1);
        if !(0.95..1.05).contains(&factor) {
            self.scale = (self.scale * factor).clamp(LEAST_SCALE, 1.0);
        }
    }

    /// Learns from a frame of so many bytes that was sent then and has arrived now.
    pub(crate) fn arrived(&mut self, bytes: usize, sent: Instant, now: Instant) {
        let seconds = now.duration_since(sent).as_secs_f64();
        let rate = bytes as f64 / seconds.max(1e-3);
        self.line = Some(self.line.map_or(rate, |line| 0.7 * line + 0.3 * rate));
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

    #[test]
    fn a_slow_line_costs_quality_first() {
        let (mut quality, start) = (Quality::default(), Instant::now());
        // 100 kB a second.
        quality.arrived(10_000, start, start + Duration::from_millis(100));
        quality.rendered(Duration::from_millis(33), 20_000);
        assert!(quality.jpeg() < 80 && quality.size([100, 100]) == [50, 50]);
        for _ in 0..50 {
            quality.rendered(Duration::from_millis(33), 20_000);
        }
        assert_eq!((quality.jpeg(), quality.size([100, 100])), (35, [25, 25]));
    }
}
