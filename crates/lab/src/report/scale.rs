//! From values to places on paper, and the values that an axis names.

/// An axis: which values it shows, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    ends: [f64; 2],
    places: [f64; 2],
    is_logarithmic: bool,
}

/// The least width of an axis, as a share of its values.
const LEAST: f64 = 1e-3;

/// The most values that an axis names.
const MAX_TICKS: usize = 12;

impl Scale {
    /// The axis that shows all these values, with some room at its ends. `None` where there are none that it can show: a
    /// logarithmic one shows values above 0.
    pub(super) fn of(
        values: impl IntoIterator<Item = f64>,
        is_logarithmic: bool,
        places: [f64; 2],
    ) -> Option<Scale> {
        let is_shown = |value: &f64| value.is_finite() && (!is_logarithmic || *value > 0.0);
        let (low, high) = values
            .into_iter()
            .filter(is_shown)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        if low > high {
            return None;
        }
        let ends = if is_logarithmic {
            let room = ((high / low).ln() * 0.04).max(LEAST);
            [low * (-room).exp(), high * room.exp()]
        } else {
            let room = ((high - low) * 0.04).max(high.abs() * LEAST);
            // From 0 where that takes little more paper: lengths can be compared then.
            let start = if low >= 0.0 && low < 0.4 * high { 0.0 } else { low - room };
            [start, high + room]
        };
        let scale = Scale { ends, places, is_logarithmic };
        let [start, end] = ends.map(|value| scale.position(value));
        (start.is_finite() && end.is_finite() && end > start).then_some(scale)
    }

    /// Whether values span so much that only a logarithmic axis shows the small ones.
    pub(super) fn wants_logarithm(values: impl IntoIterator<Item = f64>) -> bool {
        let mut ends = (f64::INFINITY, 0.0_f64);
        for value in values {
            ends = (ends.0.min(value), ends.1.max(value));
        }
        ends.0 > 0.0 && ends.1 > 30.0 * ends.0
    }

    fn position(&self, value: f64) -> f64 {
        if self.is_logarithmic { value.ln() } else { value }
    }

    /// Where a value is; one that the axis does not show is at its nearer end.
    pub(super) fn at(&self, value: f64) -> f64 {
        let [start, end] = self.ends.map(|value| self.position(value));
        let share = ((self.position(value) - start) / (end - start)).clamp(0.0, 1.0);
        let share = if share.is_nan() { 0.0 } else { share };
        self.places[0] + (self.places[1] - self.places[0]) * share
    }

    /// The middle of its paper.
    pub(super) fn middle(&self) -> f64 {
        (self.places[0] + self.places[1]) / 2.0
    }

    /// Whether it begins at 0, or shows factors: otherwise lengths on it mean nothing.
    pub(super) fn has_honest_lengths(&self) -> bool {
        self.is_logarithmic || self.ends[0] == 0.0
    }

    /// About so many round values.
    pub(super) fn ticks(&self, wanted: usize) -> Vec<f64> {
        let [low, high] = self.ends;
        let is_inside = |value: &f64| (low..=high).contains(value);
        if self.is_logarithmic {
            let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
            let each = |factors: &[f64], stride: usize| -> Vec<f64> {
                let powers = (first..=last).step_by(stride).map(|power| 10_f64.powi(power));
                powers
                    .flat_map(|power| factors.iter().map(move |factor| factor * power))
                    .filter(is_inside)
                    .collect()
            };
            let stride = ((last - first) as usize / wanted.max(1)).max(1);
            let sets = [each(&[1.0], stride), each(&[1.0, 3.0], 1), each(&[1.0, 2.0, 5.0], 1)];
            if let Some(set) = sets.into_iter().find(|set| (3..=MAX_TICKS).contains(&set.len())) {
                return set;
            }
        }
        let rough = (high - low) / wanted.max(1) as f64;
        let power = 10_f64.powf(rough.log10().floor());
        let step =
            [1.0, 2.0, 2.5, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * power);
        let first = (low / step).ceil();
        (0..MAX_TICKS).map(|number| (first + number as f64) * step).filter(is_inside).collect()
    }
}

/// A round value in few letters: thousands are `k`, millions `M`.
pub(super) fn tick_label(value: f64) -> String {
    let size = value.abs();
    let (divisor, letter) = match size {
        _ if size >= 1e13 => return format!("{value:.0e}"),
        _ if size >= 1e9 => (1e9, " G"),
        _ if size >= 1e6 => (1e6, " M"),
        _ if size >= 1e4 => (1e3, " k"),
        _ if size < 1e-4 && size > 0.0 => return format!("{value:.0e}"),
        _ => (1.0, ""),
    };
    let value = value / divisor;
    let digits = (4.0 - value.abs().max(1e-4).log10().floor()).clamp(0.0, 8.0) as usize;
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{text}{letter}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(values: [f64; 2], is_logarithmic: bool) -> String {
        let scale = Scale::of(values, is_logarithmic, [0.0, 100.0]).unwrap();
        let labels: Vec<String> = scale.ticks(5).into_iter().map(tick_label).collect();
        labels.join(" ")
    }

    #[test]
    fn axes_name_round_values_inside_them() {
        assert_eq!(labels([3.0, 17.0], false), "0 5 10 15");
        assert_eq!(labels([101.2, 103.9], false), "102 103 104");
        assert_eq!(labels([1e3, 1e6], true), "1000 10 k 100 k 1 M");
        assert_eq!(labels([1.0, 8.0], true), "1 2 5");
        assert_eq!(labels([0.97, 1.04], true), "0.98 1 1.02 1.04");
        assert_eq!(labels([2.7, 4.5], true), "3 3.5 4 4.5");
        assert_eq!(labels([1e-9, 1e12], true).split(' ').next(), Some("1e-6"));
        assert_eq!(labels([5.0, 5.0], false).split(' ').count(), 5);
    }

    #[test]
    fn places_are_on_the_paper_whatever_the_values() {
        let scale = Scale::of([10.0, 1000.0], true, [100.0, 0.0]).unwrap();
        assert!((scale.at(100.0) - 50.0).abs() < 1e-9);
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
            assert!((0.0..=100.0).contains(&scale.at(value)), "{value}");
        }
        for values in [[f64::NAN; 2], [0.0, -1.0], [f64::INFINITY; 2]] {
            assert_eq!(Scale::of(values, true, [0.0, 1.0]), None);
        }
        // Wider than any number can say.
        assert_eq!(Scale::of([-1.7e308, 1.7e308], false, [0.0, 1.0]), None);
        assert!(Scale::wants_logarithm([1.0, 31.0]) && !Scale::wants_logarithm([1.0, 29.0]));
        assert!(!Scale::wants_logarithm([0.0, 29.0]) && !Scale::wants_logarithm([]));
    }
}
