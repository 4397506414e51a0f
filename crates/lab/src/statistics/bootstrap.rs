//! Intervals by the bootstrap: how far a median could lie elsewhere, had the processes been others.

use super::CountedRandom;
use super::quantile::sorted_quantile;

/// Samples that are drawn.
const RESAMPLES: usize = 4000;

/// The range that the median lies in with this confidence: quantiles of the medians of values that are drawn from these with
/// replacement (Efron 1979, the percentile method). `key` keys the random numbers. `None` of fewer than two values.
pub fn median_interval(values: &[f64], confidence: f64, key: u64) -> Option<[f64; 2]> {
    if values.len() < 2 {
        return None;
    }
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&one, &other| values[one].total_cmp(&values[other]));
    let mut places = vec![0; values.len()];
    order.iter().enumerate().for_each(|(place, &number)| places[number] = place);
    let mut random = CountedRandom::new(key);
    // How often each value was drawn, in increasing order: the median is found by counting, without sorting each sample.
    let mut counts = vec![0; values.len()];
    let mut medians = Vec::with_capacity(RESAMPLES);
    for _ in 0..RESAMPLES {
        counts.fill(0);
        (0..values.len()).for_each(|_| counts[places[random.next_below(values.len())]] += 1);
        let middle =
            [(values.len() - 1) / 2, values.len() / 2].map(|rank| values[order[drawn_at(&counts, rank)]]);
        medians.push(sorted_quantile(&middle, 0.5)?);
    }
    medians.sort_unstable_by(f64::total_cmp);
    let tail = (1.0 - confidence) / 2.0;
    Some([sorted_quantile(&medians, tail)?, sorted_quantile(&medians, 1.0 - tail)?])
}

/// Which value stands at a rank of a sample, from 0.
fn drawn_at(counts: &[usize], rank: usize) -> usize {
    let mut below = 0;
    let is_reached = |count: &usize| {
        below += count;
        below > rank
    };
    counts.iter().position(is_reached).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_are_equal_have_no_width() {
        assert_eq!(median_interval(&[2.0; 6], 0.95, 1), Some([2.0, 2.0]));
        assert_eq!(median_interval(&[2.0], 0.95, 1), None);
    }

    /// The medians of three values drawn from three are known: each is the middle one in 13 of 27 cases, an outer one in 7.
    #[test]
    fn known_distribution() {
        assert_eq!(median_interval(&[1.0, 2.0, 3.0], 0.40, 1), Some([2.0, 2.0]));
        assert_eq!(median_interval(&[1.0, 2.0, 3.0], 0.60, 1), Some([1.0, 3.0]));
    }

    /// Of 1,000 rows of values, so many intervals hold the true median.
    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        let mut random = CountedRandom::new(5);
        // Sums of four uniform numbers: nearly normal, with median 2.
        let mut value = || (0..4).map(|_| random.next_bits() as f64 / 2f64.powi(64)).sum::<f64>();
        let holds = |key| {
            let values: Vec<f64> = (0..12).map(|_| value()).collect();
            let [low, high] = median_interval(&values, 0.95, key).unwrap();
            low <= 2.0 && 2.0 <= high
        };
        let count = (0..1000).map(holds).filter(|&is| is).count();
        // Medians of few values are steps: the percentile method holds a little less or more than it says.
        assert!((920..=985).contains(&count), "{count}");
    }
}
