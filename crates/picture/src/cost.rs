//! What the camera rays cost, as a picture in false colours.

use eosphor_core::math::Vec3;
use eosphor_core::math::elementary64::srgb_to_linear;
use eosphor_render::{CameraWork, Film};

/// The colour map "inferno" of matplotlib, at equal steps, as sRGB: equal steps in cost look equally large, and dark is
/// cheap, also for those who do not see colours (van der Walt and Smith, 2015).
const INFERNO: [u32; 9] =
    [0x000004, 0x210c4a, 0x56106e, 0x89226a, 0xbb3754, 0xe35932, 0xf98c0a, 0xf9c932, 0xfcffa4];

/// Of pixels, this share may cost more than the brightest colour says, unless its meaning is given.
const CUT_SHARE: f64 = 0.001;

/// A picture of what the camera rays of each pixel cost.
#[derive(Clone, Debug)]
pub struct CostMap {
    /// The map as linear colours, one for each pixel.
    pub film: Film,
    /// Nodes and tests that the brightest colour stands for; pixels that cost more have it too.
    pub brightest: u32,
    /// The mean over the pixels.
    pub mean: f64,
    /// Nodes visited and primitives tested for the most expensive pixel.
    pub largest: u32,
}

impl CostMap {
    /// Makes the map of a picture of this width from the work on each pixel, row after row. The brightest colour stands
    /// for `brightest` nodes and tests, or, where it is not given, for what one pixel of a thousand exceeds.
    ///
    /// # Panics
    ///
    /// Where the pixels do not fill rows.
    pub fn new(work: &[CameraWork], width: u32, brightest: Option<u32>) -> CostMap {
        assert!(work.len().is_multiple_of(width.max(1) as usize), "pixels fill rows");
        let cost = |work: &CameraWork| work.nodes.saturating_add(work.tests);
        let mut sorted: Vec<u32> = work.iter().map(cost).collect();
        let mean = sorted.iter().map(|&c| c as f64).sum::<f64>() / (sorted.len().max(1)) as f64;
        let largest = sorted.iter().copied().max().unwrap_or(0);
        let brightest = brightest.unwrap_or_else(|| {
            let above = (sorted.len() as f64 * CUT_SHARE) as usize;
            let at = sorted.len().saturating_sub(1 + above);
            if sorted.is_empty() { 0 } else { *sorted.select_nth_unstable(at).1 }
        });
        let brightest = brightest.max(1);
        let pixels = work.iter().map(|w| color(cost(w) as f64 / brightest as f64)).collect();
        let height = work.len() as u32 / width.max(1);
        CostMap { film: Film { width, height, pixels }, brightest, mean, largest }
    }
}

/// The colour of a share from 0 to 1.
fn color(share: f64) -> Vec3 {
    let place = share.clamp(0.0, 1.0) * (INFERNO.len() - 1) as f64;
    let step = (place as usize).min(INFERNO.len() - 2);
    let channel = |shift: u32| {
        let of = |rgb: u32| ((rgb >> shift) & 0xff) as f64 / 255.0;
        let (a, b) = (of(INFERNO[step]), of(INFERNO[step + 1]));
        srgb_to_linear(a + (b - a) * (place - step as f64)) as f32
    };
    Vec3 { x: channel(16), y: channel(8), z: channel(0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{DevelopSettings, Developed};

    fn work(nodes: u32, tests: u32) -> CameraWork {
        CameraWork { nodes, tests }
    }

    #[test]
    fn dark_is_cheap_and_the_brightest_is_what_was_asked() {
        let map = CostMap::new(&[work(0, 0), work(4, 4), work(10, 6), work(90, 0)], 2, Some(16));
        assert_eq!((map.film.width, map.film.height, map.brightest, map.largest), (2, 2, 16, 90));
        assert_eq!(map.mean, (8.0 + 16.0 + 90.0) / 4.0);
        let bytes = Developed::new(&map.film, &DevelopSettings::default()).rgb;
        assert_eq!(bytes[0..3], [0x00, 0x00, 0x04]);
        assert_eq!(bytes[3..6], [0xbb, 0x37, 0x54]);
        assert_eq!(bytes[6..9], [0xfc, 0xff, 0xa4]);
        assert_eq!(bytes[9..12], bytes[6..9]);
    }

    #[test]
    fn one_pixel_of_a_thousand_is_cut() {
        let mut pixels = vec![work(10, 10); 2000];
        pixels[7] = work(5000, 0);
        pixels[9] = work(4000, 0);
        let map = CostMap::new(&pixels, 100, None);
        assert_eq!((map.brightest, map.largest), (20, 5000));
        assert_eq!(CostMap::new(&[], 0, None).brightest, 1);
        assert_eq!(CostMap::new(&[work(0, 0)], 1, None).brightest, 1);
    }
}
