//! How much of a still is asked for at a time.

use std::ops::Range;

/// A piece may have as many times the samples of the one before it, where that took little of the time for a piece,
const GROWTH: f64 = 8.0;
/// and where it took next to nothing.
const FAST_GROWTH: f64 = 64.0;
/// Next to nothing, over the time for a piece.
const FAST: f64 = 1.0 / 64.0;

/// Strips are as high as tiles, or some of them, or else as some blocks of pixels, where they may be.
const TILE: u32 = 32;
const BLOCK: u32 = 8;

/// Cuts a still into pieces that take about the same time: strips of rows with all their samples, or, where that would be too
/// much, some of the samples of a strip that is just large enough to keep a device busy. It learns from the time that pieces
/// took.
#[derive(Clone, Debug)]
pub struct StripPlan {
    width: u32,
    height: u32,
    most_rows: u32,
    fewest_rows: u32,
    /// Seconds for a piece.
    target: f64,
    /// Samples of the next piece, of all its pixels.
    units: f64,
}

impl StripPlan {
    /// For a picture of this size, in strips of at most `most_rows`, on a device that `pixels_at_a_time` keep busy
    /// ([`eosphor_render::PreparedScene::pixels_at_a_time`]), with pieces of so many seconds.
    pub fn new(
        (width, height): (u32, u32),
        most_rows: u32,
        pixels_at_a_time: u64,
        seconds: f64,
    ) -> StripPlan {
        let rows = pixels_at_a_time.div_ceil(u64::from(width.max(1))).min(u64::from(height)) as u32;
        // Whole blocks of pixels, which rays are traced by.
        let rows = rows.next_multiple_of(if rows > TILE { TILE } else { BLOCK });
        let most_rows = most_rows.clamp(1, height.max(1));
        let fewest_rows = rows.clamp(1, most_rows);
        let units = f64::from(fewest_rows) * f64::from(width);
        StripPlan { width, height, most_rows, fewest_rows, target: seconds, units }
    }

    /// The next strip, from this row on and before `end`, of whose pixels so many samples are to be taken.
    pub fn rows(&self, first: u32, end: u32, samples: u32) -> Range<u32> {
        let (end, wanted) =
            (end.min(self.height), self.units / f64::from(samples.max(1)) / f64::from(self.width));
        let rows = wanted as u32;
        let rows = if rows > TILE { rows / TILE * TILE } else { rows };
        let rows = rows.clamp(self.fewest_rows, self.most_rows);
        let left = end - first;
        // No strip at the end that would keep few busy.
        let rows =
            if left < rows.saturating_add(self.fewest_rows) && left <= self.most_rows { left } else { rows };
        first..first + rows.min(left)
    }

    /// How many samples per pixel the next piece has, of a strip of `pixels` pixels with `left` samples each to be done.
    pub fn samples(&self, pixels: u64, left: u32) -> u32 {
        let most = (self.units / pixels.max(1) as f64).max(1.0) as u32;
        // All pieces alike.
        left.div_ceil(left.div_ceil(most.max(1)).max(1))
    }

    /// Learns that so many samples, of all pixels together, took this long.
    pub fn learn(&mut self, samples: u64, seconds: f64) {
        let growth = if seconds < FAST * self.target { FAST_GROWTH } else { GROWTH };
        let wanted = samples as f64 * (self.target / seconds.max(1e-9));
        self.units = wanted.clamp(1.0, self.units.max(samples as f64) * growth);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All pieces of a picture on a device that takes so many samples a second: rows and samples.
    fn pieces(plan: &mut StripPlan, samples: u32, rate: f64) -> Vec<(Range<u32>, Range<u32>)> {
        let (mut all, mut row) = (Vec::new(), 0);
        while row < plan.height {
            let rows = plan.rows(row, plan.height, samples);
            let (pixels, mut sample) = (rows.len() as u64 * u64::from(plan.width), 0);
            while sample < samples {
                let next = sample + plan.samples(pixels, samples - sample);
                let units = pixels * u64::from(next - sample);
                plan.learn(units, units as f64 / rate);
                all.push((rows.clone(), sample..next));
                sample = next;
            }
            row = rows.end;
        }
        all
    }

    #[test]
    fn pieces_are_the_picture_and_take_as_long_as_they_should() {
        for (size, samples, rate) in [
            ((1920, 1080), 1, 1e6),
            ((1920, 1080), 4096, 1e6),
            ((16, 12), 65_536, 1e5),
            ((65_535, 70), 3, 1e9),
            ((1, 1), 1, 1.0),
            ((800, 800), 64, 1e12),
            ((100, 1000), 9, 1e-3),
        ] {
            let mut plan = StripPlan::new(size, 1 << 10, 4096, 2.0);
            let all = pieces(&mut plan, samples, rate);
            let mut next = (0, 0);
            for (rows, of_pixel) in &all {
                assert_eq!((rows.start, of_pixel.start), next);
                assert!(!rows.is_empty() && !of_pixel.is_empty());
                let units = rows.len() as f64 * f64::from(size.0) * of_pixel.len() as f64;
                let least = units / of_pixel.len() as f64;
                assert!(
                    units / rate <= 2.5
                        || of_pixel.len() == 1 && least <= 4096.0f64.max(size.0.into()) * 33.0
                );
                next = if of_pixel.end == samples { (rows.end, 0) } else { (rows.start, of_pixel.end) };
            }
            assert_eq!(next, (size.1, 0));
        }
    }

    #[test]
    fn fast_pictures_have_few_pieces() {
        let mut plan = StripPlan::new((800, 800), 1 << 12, 1 << 20, 4.0);
        assert!(pieces(&mut plan, 64, 4e10).len() <= 2);
        let mut plan = StripPlan::new((1920, 1080), 1 << 12, 4096, 4.0);
        assert!(pieces(&mut plan, 16, 5e6).len() <= 8);
    }

    #[test]
    fn strips_keep_within_their_bounds() {
        let plan = StripPlan::new((100, 1000), 7, 1 << 20, 4.0);
        assert_eq!(plan.rows(0, 1000, 1), 0..7);
        assert_eq!(plan.rows(996, 1000, 1), 996..1000);
        assert_eq!(plan.rows(10, 12, 1), 10..12);
    }
}
