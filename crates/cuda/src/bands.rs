//! Bands of rows: which device takes which, in launches short enough to watch and stop.

use crate::launch::WARP_ROWS;
use crate::pixel::Pixel;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

/// Seconds that a launch should take. Drivers of cards with a screen end kernels that run for several seconds.
const LAUNCH_SECONDS: f64 = 0.1;

/// Rays of a device's first launch, by a guess: a tenth of a second, or less.
const FIRST_RAYS: f64 = 67_108_864.0;

/// Most pixels of a launch where they are colours; where they are sums, which take twice the room; and where they are colours and
/// then bytes, which take a quarter more: enough to keep any device busy, and 100 MB.
const MOST_COLORS: u32 = 1 << 23;
const MOST_SUMS: u32 = MOST_COLORS / 2;
const MOST_DEVELOPED: u32 = MOST_COLORS / 5 * 4;

/// Among several devices, a band is at most the share of a device in what is left, over this.
const SHARES: u32 = 2;

/// How many times a launch's threads fill the device, at least. One that does not takes as long as its longest thread and
/// no less, so that to make it smaller would only make it slower.
const FEWEST_FILLINGS: u32 = 2;

/// Of the threads that share a pixel's samples, how many in 8 may have nothing to do in the last round.
const IDLE_EIGHTHS: u32 = 1;

/// Hands out rows of a picture to several devices.
pub(crate) struct Rows {
    next: AtomicU32,
    end: u32,
    devices: u32,
}

impl Rows {
    pub(crate) fn new(rows: Range<u32>, devices: u32) -> Rows {
        Rows { next: AtomicU32::new(rows.start), end: rows.end, devices }
    }

    /// The next rows, at most so many; `None` when there are no more. With several devices fewer towards the end, so that none
    /// has much to do when the others are done.
    pub(crate) fn take(&self, height: &BandHeight) -> Option<Range<u32>> {
        let taken = |start: u32| {
            (start < self.end).then(|| {
                let left = self.end - start;
                let share = left / (SHARES * self.devices) / WARP_ROWS * WARP_ROWS;
                let rows =
                    if self.devices == 1 { height.rows } else { height.rows.min(share.max(height.fewest)) };
                start + rows.min(left)
            })
        };
        let start = self.next.try_update(Ordering::Relaxed, Ordering::Relaxed, taken).ok()?;
        taken(start).map(|end| start..end)
    }
}

/// How many rows a device takes at a time. It starts small and learns from the time they took.
pub(crate) struct BandHeight {
    rows: u32,
    fewest: u32,
    most: u32,
}

impl BandHeight {
    /// For pictures of this width, whose pixels take so many rays, or as much work as those, on a device that runs so many
    /// pixels at a time.
    pub(crate) fn new<T: Pixel>(width: u32, rays_per_pixel: f64, pixels_at_a_time: u32) -> BandHeight {
        let rows = |pixels: f64| whole_warps(pixels / width as f64);
        let most = BandHeight::most::<T>(width);
        let fewest = rows(f64::from(FEWEST_FILLINGS) * f64::from(pixels_at_a_time)).min(most);
        BandHeight { rows: rows(FIRST_RAYS / rays_per_pixel).clamp(fewest, most), fewest, most }
    }

    #[cfg(test)]
    pub(crate) fn rows(&self) -> u32 {
        self.rows
    }

    /// The most rows that it will ever be, whatever the rays.
    pub(crate) fn most<T: Pixel>(width: u32) -> u32 {
        let pixels = match (T::IS_SUM, T::IS_DEVELOPED) {
            (true, _) => MOST_SUMS,
            (false, true) => MOST_DEVELOPED,
            (false, false) => MOST_COLORS,
        };
        whole_warps(pixels as f64 / width as f64)
    }

    /// Learns that `rows` rows took this long; what comes next may be harder, so it grows step by step.
    pub(crate) fn learn(&mut self, rows: u32, seconds: f64) {
        let growth = (LAUNCH_SECONDS / seconds.max(1e-9)).clamp(0.1, 4.0);
        self.rows = whole_warps(rows as f64 * growth).clamp(self.fewest, self.most);
    }
}

/// How many threads share the samples of a pixel, as a power of two: as many as have nearly the same number of them. Then
/// no thread takes long, and rays of a warp are as close together as can be.
pub(crate) fn sharing(samples: u32) -> u32 {
    let samples = u64::from(samples.max(1));
    let is_fair = |bits: &u32| {
        let places = samples.div_ceil(1 << bits) << bits;
        8 * (places - samples) <= u64::from(IDLE_EIGHTHS) * places
    };
    (0..=5).rev().find(is_fair).unwrap_or(0)
}

/// A number of rows that is a multiple of a warp's, rounded down, but not 0.
fn whole_warps(rows: f64) -> u32 {
    (rows as u32 / WARP_ROWS).max(1) * WARP_ROWS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pixel::Rgb;
    use eosphor_core::math::Vec3;
    use eosphor_core::sums::ExactSum;

    #[test]
    fn every_row_is_handed_out_once() {
        for (range, most) in [(0..1, 4), (3..7, 4), (0..1000, 12), (17..65_535, 65_532)] {
            for devices in [1, 2, 5] {
                let rows = Rows::new(range.clone(), devices);
                let height = BandHeight { rows: most, fewest: 4, most };
                let all: Vec<u32> = std::iter::from_fn(|| rows.take(&height)).flatten().collect();
                assert_eq!(all, range.clone().collect::<Vec<u32>>());
                assert_eq!(rows.take(&height), None);
            }
        }
    }

    #[test]
    fn bands_take_about_a_tenth_of_a_second() {
        // A millisecond a row.
        let mut height = BandHeight::new::<Vec3>(4096, 1.0, 1);
        for _ in 0..10 {
            height.learn(height.rows(), height.rows() as f64 * 1e-3);
        }
        assert_eq!(height.rows(), 100);
        // Then suddenly a second a row.
        for _ in 0..10 {
            height.learn(height.rows(), height.rows() as f64);
        }
        assert_eq!(height.rows(), WARP_ROWS);
    }

    #[test]
    fn bands_fill_the_device() {
        let mut height = BandHeight::new::<Vec3>(1000, 1e9, 10_000);
        assert_eq!(height.rows(), 20);
        height.learn(20, 10.0);
        assert_eq!(height.rows(), 20);
        assert_eq!(BandHeight::new::<Vec3>(1000, 1.0, u32::MAX).rows(), BandHeight::most::<Vec3>(1000));
    }

    #[test]
    fn threads_that_share_a_pixel_have_the_same_to_do() {
        let shared = |samples| 1 << sharing(samples);
        let expected =
            [(0, 1), (1, 1), (2, 2), (3, 1), (4, 4), (7, 8), (8, 8), (9, 2), (15, 16), (16, 16), (25, 4)];
        for (samples, threads) in
            expected.into_iter().chain([(31, 32), (32, 32), (33, 4), (64, 32), (100, 16)])
        {
            assert_eq!(shared(samples), threads, "{samples}");
        }
        assert_eq!(shared(u32::MAX), 32);
    }

    #[test]
    fn the_first_band_is_smaller_where_pixels_take_more() {
        let pixels = |rays| BandHeight::new::<Vec3>(1000, rays, 1).rows() * 1000;
        assert_eq!(pixels(1.0), BandHeight::most::<Vec3>(1000) * 1000);
        assert!((600_000..700_000).contains(&pixels(100.0)));
        assert_eq!([pixels(1e6), pixels(f64::INFINITY)], [4000; 2]);
    }

    #[test]
    fn bands_suit_any_width() {
        for width in [1, 7, 800, 65_535] {
            let mut height = BandHeight::new::<Vec3>(width, 1e9, 100_000);
            (0..20).for_each(|_| height.learn(height.rows(), 0.0));
            assert!(height.rows().is_multiple_of(WARP_ROWS) && height.rows() > 0);
            assert!(height.rows() as u64 * width as u64 <= MOST_COLORS as u64, "{width}");
            assert_eq!(height.rows(), BandHeight::most::<Vec3>(width));
            let (colors, sums) = (BandHeight::most::<Vec3>(width), BandHeight::most::<ExactSum>(width));
            assert!(sums > 0 && sums.is_multiple_of(WARP_ROWS) && (colors / 3..=colors / 2).contains(&sums));
            let developed = BandHeight::most::<Rgb>(width);
            assert!(developed.is_multiple_of(WARP_ROWS) && (sums..colors).contains(&developed), "{width}");
        }
    }
}
