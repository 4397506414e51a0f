//! By which power one quantity grows with another.

use super::{median, median_interval};

/// The power, over blocks that each have a whole curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Slope {
    /// Of each block.
    pub of_blocks: Vec<f64>,
    /// Their median.
    pub slope: f64,
    /// Where that lies with 95 %, by the bootstrap over blocks; `None` of one block.
    pub interval: Option<[f64; 2]>,
}

/// Fits a line to the logarithms of each block's points (x, y), by least squares. `None` where no block has two points of
/// different x.
pub fn log_log_slope(blocks: &[Vec<(f64, f64)>], key: u64) -> Option<Slope> {
    let of_blocks: Vec<f64> = blocks.iter().filter_map(|points| fit(points)).collect();
    Some(Slope { slope: median(&of_blocks)?, interval: median_interval(&of_blocks, 0.95, key), of_blocks })
}

fn fit(points: &[(f64, f64)]) -> Option<f64> {
    let is_positive = |&(x, y): &(f64, f64)| x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite();
    if !points.iter().all(is_positive) {
        return None;
    }
    let logarithms: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logarithms.len() as f64;
    let (x_mean, y_mean) = (
        logarithms.iter().map(|p| p.0).sum::<f64>() / count,
        logarithms.iter().map(|p| p.1).sum::<f64>() / count,
    );
    let spread: f64 = logarithms.iter().map(|p| (p.0 - x_mean).powi(2)).sum();
    let together: f64 = logarithms.iter().map(|p| (p.0 - x_mean) * (p.1 - y_mean)).sum();
    (spread > 0.0).then(|| together / spread)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_found() {
        let curve = |power: f64| [1.0, 2.0, 8.0].map(|x: f64| (x, 3.0 * x.powf(power))).to_vec();
        for power in [-0.5, 0.0, 1.0, 2.0] {
            let slope = log_log_slope(&[curve(power), curve(power)], 1).unwrap();
            assert!((slope.slope - power).abs() < 1e-12, "{slope:?}");
        }
        assert_eq!(log_log_slope(&[curve(1.0)], 1).unwrap().interval, None);
    }

    #[test]
    fn a_line_needs_two_places() {
        for points in [&[][..], &[(1.0, 1.0)], &[(2.0, 1.0), (2.0, 3.0)], &[(0.0, 1.0), (1.0, 1.0)]] {
            assert_eq!(log_log_slope(&[points.to_vec()], 1), None);
        }
    }
}
