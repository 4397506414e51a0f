//! Medians and other quantiles.

/// The value that this share (0 to 1) of the values lies below, with linear interpolation between neighbours (type 7 of Hyndman and
/// Fan 1996, as numpy has it). `None` of no values.
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted_quantile(&sorted, share)
}

/// That of values in increasing order.
pub(super) fn sorted_quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let at = share.clamp(0.0, 1.0) * last as f64;
    let (below, part) = (at.floor(), at.fract());
    let (low, high) = (sorted[below as usize], sorted[(below as usize + 1).min(last)]);
    Some(if part == 0.0 { low } else { low + (high - low) * part })
}

/// The middle value, or the mean of the two middle ones. `None` of no values.
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_answers() {
        // numpy.quantile([3, 1, 4, 1, 5, 9, 2, 6], q).
        let values = [3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0, 6.0];
        for (share, expected) in [(0.0, 1.0), (0.1, 1.0), (0.25, 1.75), (0.5, 3.5), (0.9, 6.9), (1.0, 9.0)] {
            let got = quantile(&values, share).unwrap();
            assert!((got - expected).abs() < 1e-12, "{share}: {got}");
        }
        assert_eq!(median(&[2.0]), Some(2.0));
        assert_eq!(median(&[]), None);
    }
}
