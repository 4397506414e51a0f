//! Two runs that share no blocks: a ratio, its interval, and the probability of it by chance.

use super::student::two_sided_p;
use super::{CountedRandom, median, quantile};

/// How often the values of one run are those of another.
#[derive(Clone, Debug, PartialEq)]
pub struct UnpairedRatio {
    /// The median of these over the median of those.
    pub ratio: f64,
    /// Where that lies with 95 %, by the bootstrap over the processes of both.
    pub interval: [f64; 2],
    /// How probable so different means are, to either side, by chance (Welch's test of the logarithms).
    pub p: f64,
}

/// Samples that are drawn.
const RESAMPLES: usize = 4000;

/// The ratio of positive values of two runs. `None` of fewer than two values in one, and of values that no ratio can be formed of.
pub fn unpaired_ratio(these: &[f64], those: &[f64], key: u64) -> Option<UnpairedRatio> {
    let is_usable = |values: &[f64]| values.len() >= 2 && values.iter().all(|v| v.is_finite() && *v > 0.0);
    if !is_usable(these) || !is_usable(those) {
        return None;
    }
    let mut random = CountedRandom::new(key);
    let mut ratios = Vec::with_capacity(RESAMPLES);
    for _ in 0..RESAMPLES {
        let mut drawn = |values: &[f64]| {
            let drawn: Vec<f64> = values.iter().map(|_| values[random.next_below(values.len())]).collect();
            median(&drawn)
        };
        ratios.push(drawn(these)? / drawn(those)?);
    }
    Some(UnpairedRatio {
        ratio: median(these)? / median(those)?,
        interval: [quantile(&ratios, 0.025)?, quantile(&ratios, 0.975)?],
        p: welch(these, those),
    })
}

/// Welch's test (1947) of the logarithms, whose spreads may differ.
fn welch(these: &[f64], those: &[f64]) -> f64 {
    let moments = |values: &[f64]| {
        let count = values.len() as f64;
        let mean = values.iter().map(|v| v.ln()).sum::<f64>() / count;
        let variance = values.iter().map(|v| (v.ln() - mean).powi(2)).sum::<f64>() / (count - 1.0);
        (mean, variance / count, count - 1.0)
    };
    let ((mean, error, freedom), (other_mean, other_error, other_freedom)) = (moments(these), moments(those));
    if mean == other_mean {
        return 1.0;
    }
    let sum = error + other_error;
    let freedom = sum * sum / (error * error / freedom + other_error * other_error / other_freedom);
    two_sided_p((mean - other_mean) / sum.sqrt(), freedom)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_answers() {
        // scipy.stats.ttest_ind(log([1.0, 1.1, 1.2, 0.9]), log([1.5, 1.4, 1.7]), equal_var=False): p = 0.0064043.
        let got = unpaired_ratio(&[1.0, 1.1, 1.2, 0.9], &[1.5, 1.4, 1.7], 1).unwrap();
        assert!((got.p - 0.006_404_3).abs() < 1e-6, "{}", got.p);
        assert!((got.ratio - 0.7).abs() < 1e-12 && got.interval[0] < 0.7 && got.interval[1] > 0.7, "{got:?}");
        assert_eq!(unpaired_ratio(&[2.0, 2.0], &[2.0, 2.0], 1).unwrap().p, 1.0);
    }

    #[test]
    fn nothing_is_divided_by_what_was_not_measured() {
        for (these, those) in
            [(&[1.0][..], &[1.0, 2.0][..]), (&[1.0, 2.0], &[0.0, 1.0]), (&[1.0, f64::NAN], &[1.0, 1.0])]
        {
            assert_eq!(unpaired_ratio(these, those, 1), None);
        }
    }

    /// Of runs that differ by chance alone, one in twenty has p below 0.05.
    #[test]
    fn chance_is_called_a_difference_as_rarely_as_is_said() {
        let mut random = CountedRandom::new(12);
        let mut value =
            || 1.0 + 0.01 * (0..4).map(|_| random.next_bits() as f64 / 2f64.powi(64)).sum::<f64>();
        let found = (0..2000).filter(|&key| {
            let [these, those] = [(); 2].map(|()| (0..6).map(|_| value()).collect::<Vec<f64>>());
            unpaired_ratio(&these, &those, key).unwrap().p < 0.05
        });
        let found = found.count();
        assert!((60..140).contains(&found), "{found}");
    }
}
