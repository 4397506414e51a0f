//! Sums that do not depend on their order.
//!
//! Contributions are turned into 64-bit fixed-point numbers and added as integers. Integer addition is associative, so
//! a pixel's sum is the same in whichever order samples, bounces and devices deliver it, and GPU atomics are
//! deterministic. A float sum would be tied to one order, that of a depth-first walk, which batches of rays do not
//! have.

use crate::math::Vec3;

/// Contributions are rounded down to multiples of this.
pub const RESOLUTION: f32 = 1.0 / 268_435_456.0;

/// Contributions above this are cut to it. A pixel holds 65,535 of the largest before its sum stays where it is (sums of
/// non-negative numbers that saturate are still free of order).
pub const MAX_RADIANCE: f32 = 1_048_576.0;

/// A sum of colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct ExactSum {
    /// Red, green and blue in units of [`RESOLUTION`].
    pub units: [u64; 3],
}

impl ExactSum {
    /// Adds a colour. NaN and negative components count as 0.
    #[inline(always)]
    pub fn add(&mut self, color: Vec3) {
        self.units[0] = self.units[0].saturating_add(units(color.x));
        self.units[1] = self.units[1].saturating_add(units(color.y));
        self.units[2] = self.units[2].saturating_add(units(color.z));
    }

    /// Adds what others have summed up.
    #[inline(always)]
    pub fn merge(&mut self, other: &ExactSum) {
        self.units[0] = self.units[0].saturating_add(other.units[0]);
        self.units[1] = self.units[1].saturating_add(other.units[1]);
        self.units[2] = self.units[2].saturating_add(other.units[2]);
    }

    /// The sum over `count` samples as a mean colour.
    #[inline(always)]
    pub fn mean(&self, count: u32) -> Vec3 {
        let scale = 1.0 / (count as f64 * (1.0 / RESOLUTION as f64));
        let channel = |u: u64| (u as f64 * scale) as f32;
        Vec3 { x: channel(self.units[0]), y: channel(self.units[1]), z: channel(self.units[2]) }
    }
}

#[inline(always)]
fn units(x: f32) -> u64 {
    let limited = if x > 0.0 { if x < MAX_RADIANCE { x } else { MAX_RADIANCE } } else { 0.0 };
    // Exact: a power of two, and below 2^48.
    (limited * (1.0 / RESOLUTION)) as i64 as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;

    #[test]
    fn order_does_not_matter() {
        let colors: Vec<Vec3> =
            (0..1000).map(|i| vec3(1.0 / (i + 1) as f32, i as f32 * 0.37, 1e-5)).collect();
        let (mut forward, mut backward) = (ExactSum::default(), ExactSum::default());
        colors.iter().for_each(|c| forward.add(*c));
        colors.iter().rev().for_each(|c| backward.add(*c));
        assert_eq!(forward, backward);
        let (mut odd, mut even) = (ExactSum::default(), ExactSum::default());
        colors.chunks(2).for_each(|pair| {
            even.add(pair[0]);
            odd.add(pair[1]);
        });
        odd.merge(&even);
        assert_eq!(odd, forward);
    }

    #[test]
    fn sums_that_are_full_stay_full() {
        let mut full = ExactSum { units: [u64::MAX - 1, 5, 0] };
        full.merge(&ExactSum { units: [7, 7, 7] });
        assert_eq!(full.units, [u64::MAX, 12, 7]);
    }

    #[test]
    fn mean_of_equal_colors_is_the_color() {
        let mut sum = ExactSum::default();
        (0..49).for_each(|_| sum.add(vec3(0.25, 1.0, 1000.5)));
        assert_eq!(sum.mean(49), vec3(0.25, 1.0, 1000.5));
    }

    #[test]
    fn what_is_no_light_counts_as_none() {
        let mut sum = ExactSum::default();
        sum.add(vec3(f32::NAN, -1.0, f32::NEG_INFINITY));
        assert_eq!(sum.mean(1), Vec3::ZERO);
        sum.add(vec3(f32::INFINITY, 0.0, 0.0));
        assert_eq!(sum.mean(1).x, MAX_RADIANCE);
    }
}
