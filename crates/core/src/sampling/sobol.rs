//! Points spread more evenly than random ones: the first two dimensions of Sobol's sequence, Owen-scrambled.
//!
//! Any aligned block of 2^m consecutive points of it is a (0, m, 2)-net: each of the 2^m boxes of every division of
//! the square into equal boxes of power-of-two sides holds exactly one point. Owen scrambling (Owen, "Randomly
//! permuted (t,m,s)-nets", 1995) keeps that, makes every point uniformly distributed and removes the pattern.

use super::hash::mix;

/// The first two dimensions of Sobol's sequence as 32-bit fractions: the van der Corput sequence, and the same
/// after multiplication by Pascal's triangle modulo 2.
///
/// The binomial C(j, i) is odd exactly where the bits of `i` are a subset of those of `j` (Lucas' theorem), so the
/// product is a sum over supersets of bit positions, which takes one step for each of the five bits of a position.
#[inline(always)]
pub fn sobol_2d(index: u32) -> [u32; 2] {
    [index.reverse_bits(), pascal(index).reverse_bits()]
}

/// Bit `i` of the result is the sum modulo 2 of C(j, i) times bit `j` of `x`.
#[inline(always)]
pub(super) fn pascal(x: u32) -> u32 {
    let x = x ^ ((x >> 1) & 0x5555_5555);
    let x = x ^ ((x >> 2) & 0x3333_3333);
    let x = x ^ ((x >> 4) & 0x0f0f_0f0f);
    let x = x ^ ((x >> 8) & 0x00ff_00ff);
    x ^ (x >> 16)
}

/// Laine and Karras' hash ("Stratified sampling for stochastic transparency", 2011), in which a bit depends only on
/// lower bits, with the constants of Vegdahl ("Building a better LK hash", 2021). `seed` must be well mixed.
#[inline(always)]
pub(super) fn laine_karras(x: u32, seed: u32) -> u32 {
    let x = x ^ x.wrapping_mul(0x3d20_adea);
    let x = x.wrapping_add(seed);
    let x = x.wrapping_mul((seed >> 16) | 1);
    let x = x ^ x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Nested uniform (Owen) scrambling of a 32-bit fraction: each bit is flipped or not by a hash of the bits above it.
///
/// Burley, "Practical hash-based Owen scrambling", JCGT 9(4), 2020. `seed` must be well mixed, as by [`mix`].
#[inline(always)]
pub fn owen_scramble(x: u32, seed: u32) -> u32 {
    laine_karras(x.reverse_bits(), seed).reverse_bits()
}

/// Point `index` of the Owen-scrambled Sobol sequence of `seed`, in [0, 1) with 24 bits each.
///
/// Every seed, of any quality, gives an independent sequence. The order of the points is scrambled too (Burley
/// 2020, section 3.1): without it two sequences used together, as for a lens and a light, would visit their halves
/// and quarters in step, and four-dimensional integrals would converge worse than with random numbers.
#[inline(always)]
pub fn point_2d(index: u32, seed: u32) -> [f32; 2] {
    let order_seed = mix(seed);
    let x_seed = mix(order_seed);
    let y_seed = mix(x_seed);
    let index = owen_scramble(index, order_seed);
    // The scrambles work on reversed bits, and so does the sequence: the two reversals between them cancel.
    let x = laine_karras(index, x_seed).reverse_bits();
    let y = laine_karras(pascal(index), y_seed).reverse_bits();
    [unit_float(x), unit_float(y)]
}

/// The upper 24 bits as a fraction: exact, so never rounded up to one.
#[inline(always)]
pub(super) fn unit_float(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A number in [0, 1) of 24 bits with 29 more behind them, the upper ones of `digits`: as many as double precision has.
#[inline(always)]
pub fn with_digits(x: f32, digits: u32) -> f64 {
    const LAST_BIT: f64 = 1.0 / (1u64 << 53) as f64;
    x as f64 + (digits >> 3) as f64 * LAST_BIT
}

/// A place in a part of a range, where 0 is its beginning and 1 its end, as a number in [0, 1) of 24 bits: rounding may have led
/// beyond either of them.
#[inline(always)]
pub fn place_within(x: f64) -> f32 {
    const STEPS: u32 = 1 << 24;
    let step = (x * STEPS as f64) as u32;
    (if step < STEPS { step } else { STEPS - 1 }) as f32 * (1.0 / STEPS as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_fill_what_is_between_two_numbers() {
        let last = 1.0 - 1.0 / 16_777_216.0;
        assert_eq!(with_digits(0.0, 0), 0.0);
        assert_eq!(with_digits(last, u32::MAX), 1.0 - f64::EPSILON / 2.0);
        assert_eq!(with_digits(0.5, 1 << 31), 0.5 + 1.0 / 33_554_432.0);
        for x in [0.0, 0.3, last] {
            assert_eq!(place_within(with_digits(x, u32::MAX)), x);
        }
        assert_eq!([-1e-9, 1.0, f64::NAN].map(place_within), [0.0, last, 0.0]);
    }
    use crate::sampling::hash_pair;

    /// Sobol's second dimension with primitive polynomial x + 1, direction number by direction number.
    fn second_dimension(mut index: u32) -> u32 {
        let (mut direction, mut sum) = (1u32 << 31, 0);
        while index != 0 {
            sum ^= if index & 1 != 0 { direction } else { 0 };
            direction ^= direction >> 1;
            index >>= 1;
        }
        sum
    }

    fn assert_is_net(points: &[[f32; 2]]) {
        let m = points.len().ilog2();
        for columns_log2 in 0..=m {
            let (columns, rows) = (1usize << columns_log2, 1usize << (m - columns_log2));
            let mut seen = vec![false; points.len()];
            for p in points {
                let cell = (p[1] * rows as f32) as usize * columns + (p[0] * columns as f32) as usize;
                assert!(!seen[cell], "two points in a box of {columns} x {rows}");
                seen[cell] = true;
            }
        }
    }

    #[test]
    fn bit_tricks_equal_the_direction_numbers() {
        for index in (0..5000).chain((0..5000).map(mix)) {
            assert_eq!(sobol_2d(index), [index.reverse_bits(), second_dimension(index)]);
        }
    }

    #[test]
    fn aligned_blocks_are_nets() {
        for seed in [0, 1, 2, 3, 12345, u32::MAX] {
            for m in [0, 1, 2, 3, 4, 6, 8, 10] {
                for block in [0u32, 1, 2, 5, 1000] {
                    let points: Vec<_> = (0..1u32 << m).map(|i| point_2d((block << m) + i, seed)).collect();
                    assert_is_net(&points);
                }
            }
        }
        let plain: Vec<_> = (0..1024).map(|i| sobol_2d(i).map(unit_float)).collect();
        assert_is_net(&plain);
    }

    #[test]
    fn points_are_uniform_and_below_one() {
        assert_eq!(unit_float(u32::MAX), 1.0 - f32::EPSILON / 2.0);
        // One point of each of many sequences: uniform by scrambling alone.
        for index in [0, 1, 7, 64] {
            let mut bins = [0u32; 64];
            for seed in 0..64_000 {
                let [x, y] = point_2d(index, seed);
                assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y));
                bins[(y * 8.0) as usize * 8 + (x * 8.0) as usize] += 1;
            }
            // Chi-square with 63 degrees of freedom: mean 63, deviation 11.
            let chi_square: f32 = bins.iter().map(|&n| (n as f32 - 1000.0).powi(2) / 1000.0).sum();
            assert!((25.0..120.0).contains(&chi_square), "{chi_square}");
        }
    }

    #[test]
    fn scrambling_keeps_intervals_together() {
        // Numbers that share their upper bits keep sharing as many, and only as many.
        for trial in 0..10_000 {
            let (a, b, seed) =
                (mix(trial), mix(trial) ^ (mix(trial + 70_000) >> (trial % 32)), mix(trial + 90_000));
            let shared = |a: u32, b: u32| (a ^ b).leading_zeros();
            assert_eq!(shared(a, b), shared(owen_scramble(a, seed), owen_scramble(b, seed)));
        }
    }

    /// Root mean square error of the mean of `f` over many estimates of `n` samples, each from its own seed.
    fn rmse(n: u32, exact: f64, sample: impl Fn(u32, u32) -> f64) -> f64 {
        const ESTIMATES: u32 = 2000;
        let squares: f64 = (0..ESTIMATES)
            .map(|seed| ((0..n).map(|i| sample(i, seed)).sum::<f64>() / n as f64 - exact).powi(2))
            .sum();
        (squares / ESTIMATES as f64).sqrt()
    }

    fn random_2d(index: u32, seed: u32) -> [f32; 2] {
        let h = hash_pair(hash_pair(99, seed), index);
        [unit_float(h), unit_float(mix(h ^ 0x5555))]
    }

    #[test]
    fn points_beat_random_numbers() {
        let smooth = |p: [f32; 2]| ((p[0] + 2.0 * p[1]) as f64).exp();
        let smooth_exact = (1f64.exp() - 1.0) * (2f64.exp() - 1.0) / 2.0;
        let disk = |p: [f32; 2]| if p[0] * p[0] + p[1] * p[1] < 1.0 { 1.0 } else { 0.0 };
        let disk_exact = core::f64::consts::FRAC_PI_4;
        for (n, disk_factor, smooth_factor) in [(16, 1.6, 4.0), (64, 2.3, 10.0), (256, 3.2, 25.0)] {
            let gain = |f: &dyn Fn([f32; 2]) -> f64, exact| {
                rmse(n, exact, |i, s| f(random_2d(i, s))) / rmse(n, exact, |i, s| f(point_2d(i, s)))
            };
            let (of_disk, of_smooth) = (gain(&disk, disk_exact), gain(&smooth, smooth_exact));
            println!("{n} samples: disk {of_disk:.2}, smooth {of_smooth:.2} times better than random");
            assert!(of_disk > disk_factor && of_smooth > smooth_factor);
        }
    }

    #[test]
    fn sequences_of_different_seeds_are_independent() {
        // The correlation of two coordinates of two sequences. In step, the halves of the one are the halves of the
        // other in order or swapped, and no number of samples removes that.
        let product = |a: f32, b: f32| (a as f64 - 0.5) * (b as f64 - 0.5);
        let padded = |in_order: bool| {
            rmse(64, 0.0, |i, s| {
                let seeds = [hash_pair(s, 0), hash_pair(s, 1)];
                let [a, b] = seeds.map(|seed| match in_order {
                    true => unit_float(owen_scramble(i.reverse_bits(), seed)),
                    false => point_2d(i, seed)[0],
                });
                product(a, b)
            })
        };
        let random = rmse(64, 0.0, |i, s| product(random_2d(i, s)[0], random_2d(i, s)[1]));
        let (shuffled, in_step) = (padded(false), padded(true));
        println!("random {random:.4}, shuffled {shuffled:.4}, in step {in_step:.4}");
        // Not quite 1: neighbours in order stay neighbours, and opposite, in both sequences.
        assert!(shuffled < 1.4 * random && in_step > 4.0 * random);
    }
}
