//! Two variants, block by block: a ratio, its interval, and the probability of it by chance.

use super::bootstrap::median_interval;
use super::median;
use super::student::{two_sided_p, two_sided_t};
use serde::Serialize;

/// How often one variant's value is the other's, over blocks that hold both.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairedRatio {
    /// Of each block.
    pub of_blocks: Vec<f64>,
    /// Their median.
    pub ratio: f64,
    /// Where that lies with 95 %, by the bootstrap over blocks.
    pub interval: [f64; 2],
    /// Where the geometric mean lies with 95 %, by Student's distribution of the logarithms.
    pub student_interval: [f64; 2],
    /// How probable a mean so far from 1, to either side, is by chance (Student's test of the logarithms).
    pub p: f64,
}

/// The ratio of positive values of two variants in the same blocks. `None` of fewer than two blocks, and of values that no ratio
/// can be formed of.
pub fn paired_ratio(these: &[f64], those: &[f64], key: u64) -> Option<PairedRatio> {
    let is_usable = |values: &[f64]| values.iter().all(|value| value.is_finite() && *value > 0.0);
    if these.len() != those.len() || these.len() < 2 || !is_usable(these) || !is_usable(those) {
        return None;
    }
    let of_blocks: Vec<f64> = these.iter().zip(those).map(|(this, that)| this / that).collect();
    let logarithms: Vec<f64> = of_blocks.iter().map(|ratio| ratio.ln()).collect();
    let count = logarithms.len() as f64;
    let mean = logarithms.iter().sum::<f64>() / count;
    let variance = logarithms.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let error = (variance / count).sqrt();
    // Equal ratios have no error: they are 1 for certain, or they are not.
    let p = if mean == 0.0 { 1.0 } else { two_sided_p(mean / error, count - 1.0) };
    let width = two_sided_t(0.95, count - 1.0) * error;
    Some(PairedRatio {
        ratio: median(&of_blocks)?,
        interval: median_interval(&of_blocks, 0.95, key)?,
        student_interval: [(mean - width).exp(), (mean + width).exp()],
        p,
        of_blocks,
    })
}

#[cfg(test)]
mod tests {
    use super::super::CountedRandom;
    use super::*;

    #[test]
    fn a_known_ratio() {
        let got = paired_ratio(&[2.0, 4.0, 6.0], &[1.0, 2.0, 3.0], 1).unwrap();
        assert_eq!((got.ratio, got.interval), (2.0, [2.0, 2.0]));
        assert!(got.p < 1e-9, "{}", got.p);
        let got = paired_ratio(&[1.0, 1.0, 1.0], &[1.0, 1.0, 1.0], 1).unwrap();
        assert_eq!((got.ratio, got.p), (1.0, 1.0));
        // scipy.stats.ttest_1samp(log([1.1, 1.2, 0.9, 1.05]), 0): t = 0.91696, p = 0.42678.
        let got = paired_ratio(&[1.1, 1.2, 0.9, 1.05], &[1.0; 4], 1).unwrap();
        assert!((got.p - 0.426_78).abs() < 1e-5, "{}", got.p);
    }

    #[test]
    fn nothing_is_divided_by_what_was_not_measured() {
        for (these, those) in [
            (&[1.0, 2.0][..], &[1.0][..]),
            (&[1.0], &[1.0]),
            (&[1.0, 2.0], &[0.0, 1.0]),
            (&[1.0, f64::NAN], &[1.0, 1.0]),
            (&[1.0, f64::INFINITY], &[1.0, 1.0]),
        ] {
            assert_eq!(paired_ratio(these, those, 1), None);
        }
    }

    /// Of pairs that differ by chance alone, one in twenty has p below 0.05: also where a block in ten is disturbed.
    #[test]
    fn chance_is_called_a_difference_as_rarely_as_is_said() {
        for disturbed in [0.0, 0.1] {
            let mut random = CountedRandom::new(11);
            let mut uniform = || random.next_bits() as f64 / 2f64.powi(64);
            let mut value = || {
                let noise = 0.01 * (uniform() + uniform() + uniform() - 1.5);
                1.0 + noise + if uniform() < disturbed { uniform() } else { 0.0 }
            };
            let mut found = 0;
            for key in 0..2000 {
                let [these, those] = [(); 2].map(|()| (0..6).map(|_| value()).collect::<Vec<f64>>());
                found += u32::from(paired_ratio(&these, &those, key).unwrap().p < 0.05);
            }
            // 100 are expected of 2,000 without disturbance, give or take 10; disturbed ones are found less often.
            assert!(found < 135, "{disturbed}: {found}");
        }
    }
}
