//! From one key to the next. All in double precision and a fixed order: the same bits on every machine.

use eosphor_core::math::{Vec3, sqrt64};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How something goes from one key to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// Not at all: it stays until the next key.
    Step,
    /// Straight, at an even pace.
    Linear,
    /// On a curve through the keys, without jerks (Catmull and Rom 1974).
    #[default]
    Smooth,
}

/// A value and its time in seconds.
type Key<const N: usize> = (f64, [f64; N]);

/// The keys around a time: the last that is not after it, the next, and those beside them.
struct Span<const N: usize> {
    before: Option<Key<N>>,
    from: Key<N>,
    to: Key<N>,
    behind: Option<Key<N>>,
}

/// Where a time lies.
enum Place<const N: usize> {
    /// Before the first key, or after the last.
    At([f64; N]),
    Between(Span<N>),
}

/// Among keys at increasing times; `None` where there are none.
fn place<const N: usize>(keys: impl Iterator<Item = Key<N>>, time: f64) -> Option<Place<N>> {
    let mut keys = keys;
    let (mut before, mut from) = (None, None);
    while let Some(key) = keys.next() {
        if key.0 > time {
            return Some(match from {
                None => Place::At(key.1),
                Some(from) => Place::Between(Span { before, from, to: key, behind: keys.next() }),
            });
        }
        (before, from) = (from, Some(key));
    }
    from.map(|(_, value)| Place::At(value))
}

impl Interpolation {
    /// A value at a time; `None` without keys. Before the first and after the last it stays as they are.
    pub(super) fn at<const N: usize>(
        self,
        keys: impl Iterator<Item = Key<N>>,
        time: f64,
    ) -> Option<[f64; N]> {
        Some(match place(keys, time)? {
            Place::At(value) => value,
            Place::Between(span) => match self {
                Interpolation::Step => span.from.1,
                Interpolation::Linear => {
                    let share = span.share(time);
                    let (a, b) = (span.from.1, span.to.1);
                    std::array::from_fn(|k| a[k] + share * (b[k] - a[k]))
                }
                Interpolation::Smooth => span.curve(time),
            },
        })
    }

    /// A vector at a time; `None` without keys.
    pub(super) fn vector(self, keys: impl Iterator<Item = (f64, Vec3)>, time: f64) -> Option<Vec3> {
        let keys = keys.map(|(time, v)| (time, <[f32; 3]>::from(v).map(f64::from)));
        self.at(keys, time).map(|v| Vec3::from(v.map(|x| x as f32)))
    }

    /// A rotation at a time, as a quaternion; `None` without keys. It goes the shorter way around. Quaternions come and go
    /// with any length.
    pub(super) fn rotation(self, keys: impl Iterator<Item = Key<4>>, time: f64) -> Option<[f64; 4]> {
        let mut span = match place(keys.map(|(time, q)| (time, unit(q))), time)? {
            Place::At(q) => return Some(q),
            Place::Between(span) => span,
        };
        // Of the two quaternions of each rotation, the one that is nearer to its neighbour.
        span.to.1 = nearer(span.to.1, &span.from.1);
        span.before = span.before.map(|(time, q)| (time, nearer(q, &span.from.1)));
        span.behind = span.behind.map(|(time, q)| (time, nearer(q, &span.to.1)));
        Some(match self {
            Interpolation::Step => span.from.1,
            Interpolation::Linear => arc(span.from.1, span.to.1, span.share(time)),
            Interpolation::Smooth => span.curve(time),
        })
    }
}

impl<const N: usize> Span<N> {
    /// How much of the way is done.
    fn share(&self, time: f64) -> f64 {
        (time - self.from.0) / (self.to.0 - self.from.0)
    }

    /// On the curve of Catmull and Rom.
    fn curve(&self, time: f64) -> [f64; N] {
        let share = self.share(time);
        let (p1, p2) = (self.from.1, self.to.1);
        let (before, behind) = (self.before.unwrap_or(self.from), self.behind.unwrap_or(self.to));
        // Slopes a second at both ends: those from neighbour to neighbour.
        let slope = |a: &Key<N>, b: &Key<N>, k: usize| (b.1[k] - a.1[k]) / (b.0 - a.0);
        let span = self.to.0 - self.from.0;
        let (s, s2, s3) = (share, share * share, share * share * share);
        std::array::from_fn(|k| {
            (2.0 * s3 - 3.0 * s2 + 1.0) * p1[k]
                + (s3 - 2.0 * s2 + s) * span * slope(&before, &self.to, k)
                + (3.0 * s2 - 2.0 * s3) * p2[k]
                + (s3 - s2) * span * slope(&self.from, &behind, k)
        })
    }
}

fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

/// The quaternion scaled to length 1; one without length becomes that which turns nothing.
fn unit(q: [f64; 4]) -> [f64; 4] {
    let length = sqrt64(dot(&q, &q));
    if length > 0.0 { q.map(|part| part / length) } else { [0.0, 0.0, 0.0, 1.0] }
}

fn nearer(q: [f64; 4], to: &[f64; 4]) -> [f64; 4] {
    if dot(&q, to) < 0.0 { q.map(|part| -part) } else { q }
}

/// At an even pace along the great circle (Shoemake 1985), by halving it: that needs square roots alone. What is left
/// after twelve halves is straight within 1e-11.
fn arc(mut a: [f64; 4], mut b: [f64; 4], mut share: f64) -> [f64; 4] {
    let mix = |a: &[f64; 4], b: &[f64; 4], share: f64| {
        unit(std::array::from_fn(|k| (1.0 - share) * a[k] + share * b[k]))
    };
    for _ in 0..12 {
        let middle = mix(&a, &b, 0.5);
        if share < 0.5 {
            (b, share) = (middle, 2.0 * share);
        } else {
            (a, share) = (middle, 2.0 * share - 1.0);
        }
    }
    mix(&a, &b, share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// About an axis by an angle, times a length.
    fn about(axis: [f64; 3], radians: f64, length: f64) -> [f64; 4] {
        let [x, y, z] = axis.map(|part| part * (0.5 * radians).sin() * length);
        [x, y, z, (0.5 * radians).cos() * length]
    }

    #[test]
    fn a_turn_goes_at_an_even_pace_and_the_shorter_way() {
        let axis = [0.6, 0.0, 0.8];
        // The second key says the same as -170 degrees, and so the way leads over 180.
        let keys =
            [(1.0, about(axis, 100f64.to_radians(), 2.0)), (3.0, about(axis, 190f64.to_radians(), -0.5))];
        for (time, degrees) in
            [(0.0, 100.0), (1.0, 100.0), (1.5, 122.5), (2.0, 145.0), (2.9, 185.5), (9.0, 190.0)]
        {
            let found = Interpolation::Linear.rotation(keys.into_iter(), time).unwrap();
            let expected = about(axis, f64::to_radians(degrees), 1.0);
            assert!((dot(&unit(found), &expected).abs() - 1.0).abs() < 1e-12, "{time}: {found:?}");
        }
        assert_eq!(Interpolation::Linear.rotation(std::iter::empty(), 1.0), None);
    }

    #[test]
    fn steps_stay_until_the_next_key() {
        let keys = [(1.0, [5.0]), (2.0, [7.0])];
        for (time, value) in [(0.0, 5.0), (1.0, 5.0), (1.99, 5.0), (2.0, 7.0), (3.0, 7.0)] {
            assert_eq!(Interpolation::Step.at(keys.into_iter(), time), Some([value]));
        }
    }

    proptest! {
        /// Slerp's formula, by the standard library.
        #[test]
        fn arcs_are_those_of_the_formula(
            a in prop::array::uniform4(-1.0f64..1.0),
            b in prop::array::uniform4(-1.0f64..1.0),
            share in 0.0f64..1.0,
        ) {
            prop_assume!(dot(&a, &a) > 0.01 && dot(&b, &b) > 0.01);
            let a = unit(a);
            let b = nearer(unit(b), &a);
            let angle = dot(&a, &b).clamp(-1.0, 1.0).acos();
            prop_assume!(angle > 1e-4);
            let (wa, wb) = (((1.0 - share) * angle).sin() / angle.sin(), (share * angle).sin() / angle.sin());
            let found = arc(a, b, share);
            for k in 0..4 {
                prop_assert!((found[k] - (wa * a[k] + wb * b[k])).abs() < 1e-9);
            }
        }
    }
}
