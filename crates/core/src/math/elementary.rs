//! Elementary functions in single precision, the same bits on every target.
//!
//! No function of a maths library is used: those differ between systems and GPUs. Everything here is `+ - * /`,
//! [`fma`] and moves of bits, in straight lines (every `if` is a select), so that a loop over an array of lanes
//! vectorises. Polynomials are weighted minimax fits with coefficients rounded one after the other; the bounds
//! stated in ulps (units in the last place) are checked against double precision by the tests below.
//!
//! Methods: Muller, "Elementary Functions", 3rd ed. 2016, chapters 9 to 11; Cody and Waite, "Software Manual for the
//! Elementary Functions", 1980; the double-word steps are Dekker's, "A floating-point technique for extending the
//! available precision", 1971.

use super::float::{clamp, fma, min};
use core::f32::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, LN_2, LOG2_E, PI};

/// Adding 1.5 * 2^23 leaves the nearest whole number in the low bits of the sum, two's complement.
const ROUND: f32 = 12_582_912.0;

/// Tangent of pi/8.
const TAN_PI_8: f32 = 0.414_213_57;

/// Base-2 logarithm of a positive finite number as an unevaluated sum; the relative error is below 2^-29.
///
/// `x = 2^k m` with `m` in [sqrt(1/2), sqrt(2)), then `log2 m = 2/ln 2 * atanh(s)` with `s = (m - 1)/(m + 1)`, an
/// odd series in `s`. Only its first term needs double words: the rest is at most a hundredth of it.
#[inline(always)]
fn log2_parts(x: f32) -> (f32, f32) {
    const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    const TWO_OVER_LN2: f32 = 2.0 * LOG2_E;
    const TWO_OVER_LN2_LOW: f32 = 3.851_926e-8;

    let subnormal = x < f32::MIN_POSITIVE;
    let bits = (if subnormal { x * 16_777_216.0 } else { x }).to_bits();
    let k = (bits.wrapping_sub(SQRT_HALF_BITS) as i32) >> 23;
    let m = f32::from_bits(bits.wrapping_sub((k << 23) as u32));
    let k = (k - if subnormal { 24 } else { 0 }) as f32;

    // s + s_low = f / d to about 46 bits. `f` is exact, which is what keeps the digits near x = 1.
    let f = m - 1.0;
    let d = f + 2.0;
    let d_low = f - (d - 2.0);
    let reciprocal = 1.0 / d;
    let s = f * reciprocal;
    let s_low = fma(-s, d_low, fma(-s, d, f)) * reciprocal;

    let z = s * s;
    let series = fma(fma(fma(0.336_922_82, z, 0.411_906_6), z, 0.577_079_06), z, 0.961_796_7);
    let h = s * TWO_OVER_LN2;
    let h_rounding = fma(s, TWO_OVER_LN2, -h);
    // 2/ln 2 * (1 + z) is the derivative of the whole, so that the series too is corrected for s_low.
    let slope = fma(z, TWO_OVER_LN2, TWO_OVER_LN2);
    let h_low = fma(s * z, series, fma(s, TWO_OVER_LN2_LOW, fma(s_low, slope, h_rounding)));

    // |h| <= 1/2, so k is zero or the larger: the sum's rounding error is exact.
    let sum = k + h;
    let sum_low = (k - sum) + h + h_low;
    let high = sum + sum_low;
    (high, (sum - high) + sum_low)
}

/// `2^(p + e)` for a small correction `e`; `p` is limited to where the result over- or underflows anyway.
///
/// `2^p = 2^n 2^r` with `n` the nearest whole number and a polynomial of degree 6 for |r| <= 1/2.
#[inline(always)]
fn exp2_parts(p: f32, e: f32) -> f32 {
    let p = clamp(p, -200.0, 200.0);
    let rounded = p + ROUND;
    let n = rounded.to_bits().wrapping_sub(ROUND.to_bits()) as i32;
    let r = (p - (rounded - ROUND)) + e;
    let q = fma(fma(0.000_152_380_06, r, 0.001_339_113_7), r, 0.009_618_841);
    let q = fma(fma(fma(q, r, 0.055_503_592), r, 0.240_226_45), r, LN_2);
    // Two factors, because 2^n itself may not be representable; only the second product can round.
    let half = n >> 1;
    fma(q, r, 1.0) * power_of_two(half) * power_of_two(n - half)
}

/// `2^n` for n in [-126, 127].
#[inline(always)]
fn power_of_two(n: i32) -> f32 {
    f32::from_bits(((n + 127) << 23) as u32)
}

/// Base-2 logarithm, within 0.53 ulp, subnormal numbers included. Zero gives minus infinity, negative numbers and
/// NaN give NaN.
#[inline(always)]
pub fn log2(x: f32) -> f32 {
    let (high, _) = log2_parts(x);
    let finite = if x < f32::INFINITY { high } else { x };
    let known = if x > 0.0 { finite } else { f32::NAN };
    if x == 0.0 { f32::NEG_INFINITY } else { known }
}

/// Two to the power of `x`, within 1 ulp, gradual underflow included. 128 and more give infinity, NaN gives NaN.
#[inline(always)]
pub fn exp2(x: f32) -> f32 {
    let y = exp2_parts(x, 0.0);
    if x.is_nan() { x } else { y }
}

/// `x` to the power of `y` for `x >= 0`: always finite and never negative.
///
/// The relative error of normal results is below 2e-7 (3 ulp) everywhere, also for `y` of many thousands and `x` near one,
/// because the logarithm carries 29 bits and more. `pow(x, 0)` is 1 and `pow(0, y)` is 0 for positive `y`; results
/// too large, among them `pow(0, y)` for negative `y`, become the largest finite number. Negative and NaN `x` count
/// as zero, infinite ones as the largest finite number.
#[inline(always)]
pub fn pow(x: f32, y: f32) -> f32 {
    let x = clamp(x, 0.0, f32::MAX);
    let (high, low) = log2_parts(x);
    let p = y * high;
    // Where the product overflows its rounding error is not a number, and does not matter.
    let e = if p.abs() < 200.0 { fma(y, low, fma(y, high, -p)) } else { 0.0 };
    let power = min(exp2_parts(p, e), f32::MAX);
    let of_zero = if y > 0.0 { 0.0 } else { f32::MAX };
    let power = if x > 0.0 { power } else { of_zero };
    if y == 0.0 { 1.0 } else { power }
}

/// Sine and cosine of an angle in radians, each within 2 ulp for |x| up to 2^13 and within 1e-7 up to 2^20.
///
/// Beyond, and for infinities and NaN, the results carry no meaning, but they are always numbers in [-1, 1].
#[inline(always)]
pub fn sin_cos(x: f32) -> (f32, f32) {
    // x = n * pi/2 + r. Pi/2 in three words; with fma the first subtraction is exact (Muller, section 11.2).
    let rounded = fma(x, FRAC_2_PI, ROUND);
    let n = rounded - ROUND;
    let r = fma(-n, -1.715_124_5e-15, fma(-n, -4.371_139e-8, fma(-n, FRAC_PI_2, x)));
    // Only arguments without meaning are limited here; |r| <= 1 keeps both polynomials within [-1, 1].
    let r = clamp(r, -1.0, 1.0);

    let z = r * r;
    let s = fma(fma(-0.000_195_182_85, z, 0.008_332_189), z, -0.166_666_55);
    let sine = fma(r * z, s, r);
    let c = fma(fma(2.443_256_4e-5, z, -0.001_388_731_1), z, 0.041_666_646);
    let cosine = fma(z, fma(c, z, -0.5), 1.0);

    let quadrant = rounded.to_bits();
    let swap = quadrant & 1 != 0;
    let (a, b) = if swap { (cosine, sine) } else { (sine, cosine) };
    let sign_a = (quadrant & 2) << 30;
    let sign_b = (quadrant.wrapping_add(1) & 2) << 30;
    (f32::from_bits(a.to_bits() ^ sign_a), f32::from_bits(b.to_bits() ^ sign_b))
}

/// Sine of an angle in radians; for bounds see [`sin_cos`].
#[inline(always)]
pub fn sin(x: f32) -> f32 {
    sin_cos(x).0
}

/// Cosine of an angle in radians; for bounds see [`sin_cos`].
#[inline(always)]
pub fn cos(x: f32) -> f32 {
    sin_cos(x).1
}

/// The angle of the point (x, y) from the x axis in radians, from -pi to pi, within 4 ulp. 0 where both are 0; infinities and NaN
/// give some number in that range.
#[inline(always)]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let (small, large) = if ay < ax { (ay, ax) } else { (ax, ay) };
    // The tangent of the angle from the nearer axis, 0 to 1; the angle less pi/4, where that is nearer.
    let is_steep = small > TAN_PI_8 * large;
    let over = if is_steep { small - large } else { small };
    let under = if is_steep { small + large } else { large };
    let t = if under > 0.0 { clamp(over / under, -TAN_PI_8, TAN_PI_8) } else { 0.0 };
    let z = t * t;
    let p = fma(fma(fma(-0.060_834_534, z, 0.105_960_02), z, -0.142_438_49), z, 0.199_984_9);
    let angle = fma(t * z, fma(p, z, -0.333_333_16), t);
    let angle = if is_steep { FRAC_PI_4 + angle } else { angle };
    let angle = if ay < ax { angle } else { FRAC_PI_2 - angle };
    let angle = if x < 0.0 { PI - angle } else { angle };
    let angle = if ax > 0.0 || ay > 0.0 { angle } else { 0.0 };
    f32::from_bits(angle.to_bits() | (y.to_bits() & 0x8000_0000))
}

/// The sRGB code (IEC 61966-2-1) of a linear value, 0 to 1 for 0 to 1; not clamped to that range.
///
/// Within 2e-7 of the exact code, so that rounding to 8 bits gives what double precision gives, except within
/// 5e-5 of a step of a tie.
#[inline(always)]
pub fn linear_to_srgb(x: f32) -> f32 {
    // 1.055 p - 0.055, written so that one gives exactly one.
    let curve = fma(1.055, pow(x, 1.0 / 2.4) - 1.0, 1.0);
    if x > 0.003_130_8 { curve } else { x * 12.92 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary64;

    /// Error in units of the last place that a single-precision number of that size has.
    fn ulps(got: f32, want: f64) -> f64 {
        let exponent = ((want.abs().to_bits() >> 52) as i32 - 1023).max(-126);
        (got as f64 - want).abs() / 2f64.powi(exponent - 23)
    }

    /// The largest error in ulps over every `stride`-th bit pattern from `from` to `to`, both of one sign.
    fn worst(from: f32, to: f32, stride: usize, got: impl Fn(f32) -> f32, want: impl Fn(f64) -> f64) -> f64 {
        let mut worst = (0.0, 0.0);
        for bits in (from.to_bits()..=to.to_bits()).step_by(stride) {
            let x = f32::from_bits(bits);
            let error = ulps(got(x), want(x as f64));
            assert!(!error.is_nan(), "not a number at {x:e}");
            worst = if error > worst.0 { (error, x) } else { worst };
        }
        println!("{from:e} to {to:e}: {:.4} ulp at {:e}", worst.0, worst.1);
        worst.0
    }

    #[test]
    fn log2_holds_its_bound() {
        assert!(worst(f32::from_bits(1), f32::MAX, 211, log2, f64::log2) < 0.53);
        assert!(worst(0.99, 1.01, 1, log2, f64::log2) < 0.53);
        assert!(worst(f32::from_bits(1), f32::from_bits(100_000), 1, log2, f64::log2) < 0.53);
        for k in -149..=127 {
            assert_eq!(log2(2f64.powi(k) as f32), k as f32);
        }
    }

    #[test]
    fn log2_special_cases() {
        assert_eq!(log2(0.0), f32::NEG_INFINITY);
        assert_eq!(log2(-0.0), f32::NEG_INFINITY);
        assert_eq!(log2(f32::INFINITY), f32::INFINITY);
        assert!(log2(-1.0).is_nan() && log2(f32::NEG_INFINITY).is_nan() && log2(f32::NAN).is_nan());
    }

    #[test]
    fn exp2_holds_its_bound() {
        assert!(worst(1e-9, 127.999_99, 37, exp2, f64::exp2) < 1.0);
        assert!(worst(-1e-9, -152.0, 37, exp2, f64::exp2) < 1.0);
        assert!(worst(0.45, 0.55, 1, exp2, f64::exp2) < 1.0);
        for k in -149..=127 {
            assert_eq!(exp2(k as f32), 2f64.powi(k) as f32);
        }
    }

    #[test]
    fn exp2_special_cases() {
        assert_eq!([exp2(0.0), exp2(-0.0), exp2(f32::MIN_POSITIVE)], [1.0; 3]);
        assert_eq!([exp2(128.0), exp2(1e30), exp2(f32::INFINITY)], [f32::INFINITY; 3]);
        assert_eq!([exp2(-151.0), exp2(-1e30), exp2(f32::NEG_INFINITY)], [0.0; 3]);
        assert!(exp2(f32::NAN).is_nan());
    }

    #[test]
    fn pow_holds_its_bound() {
        let exponents = [
            0.01,
            0.2,
            1.0 / 2.4,
            0.5,
            1.0,
            1.5,
            2.0,
            2.4,
            5.0,
            20.0,
            100.0,
            265.3689,
            1000.0,
            1e4,
            1e6,
            -0.5,
            -3.0,
            -700.0,
        ];
        for y in exponents {
            // All of x for which the result is a normal number.
            let (a, b) = (2f64.powf(-125.9 / y as f64), 2f64.powf(127.9 / y as f64));
            let (low, high) = (a.min(b).max(1e-45) as f32, a.max(b).min(f32::MAX as f64) as f32);
            let stride = (high.to_bits() - low.to_bits()) as usize / 1_000_000 + 1;
            let error = worst(low, high, stride, |x| pow(x, y), |x| x.powf(y as f64));
            assert!(error < 3.0, "exponent {y}");
            // In relative terms, as the documentation states it.
            for bits in (low.to_bits()..=high.to_bits()).step_by(stride * 8) {
                let (x, exact) = (f32::from_bits(bits), (f32::from_bits(bits) as f64).powf(y as f64));
                assert!((pow(x, y) as f64 - exact).abs() <= 2e-7 * exact, "{x:e}^{y}");
            }
        }
    }

    #[test]
    fn pow_special_cases() {
        let numbers = [
            0.0,
            -0.0,
            1e-45,
            1e-38,
            0.3,
            1.0,
            1.000_000_1,
            7.0,
            1e38,
            f32::MAX,
            f32::INFINITY,
            -2.0,
            f32::NAN,
        ];
        for x in numbers {
            assert_eq!(pow(x, 0.0), 1.0, "{x}^0");
            for y in numbers.iter().flat_map(|&y| [y, -y]) {
                assert!((0.0..=f32::MAX).contains(&pow(x, y)), "{x}^{y}");
            }
        }
        for y in [1e-45, 1e-10, 0.4, 1.0, 1000.0, f32::MAX] {
            assert_eq!([pow(0.0, y), pow(-0.0, y), pow(1.0, y), pow(1.0, -y)], [0.0, 0.0, 1.0, 1.0]);
            assert_eq!(pow(0.0, -y), f32::MAX);
        }
        assert_eq!([pow(10.0, 39.0), pow(0.1, -39.0), pow(10.0, -50.0)], [f32::MAX, f32::MAX, 0.0]);
        assert_eq!([pow(3.0, 1.0), pow(2.0, 10.0), pow(0.25, 0.5)], [3.0, 1024.0, 0.5]);
    }

    #[test]
    fn sine_and_cosine_hold_their_bounds() {
        for sign in [1.0, -1.0] {
            assert!(worst(sign * 1e-30, sign * 8192.0, 211, sin, f64::sin) < 2.0);
            assert!(worst(sign * 1e-30, sign * 8192.0, 211, cos, f64::cos) < 2.0);
        }
        assert!(worst(0.7, 7.0, 13, sin, f64::sin) < 2.0);
        assert!(worst(0.7, 7.0, 13, cos, f64::cos) < 2.0);
        // The hard arguments: next to multiples of pi/2, where one of the two is nearly zero.
        for n in 1..5200 {
            let x = (n as f64 * core::f64::consts::FRAC_PI_2) as f32;
            for x in [x.next_down(), x, x.next_up()] {
                assert!(ulps(sin(x), (x as f64).sin()) < 2.0 && ulps(cos(x), (x as f64).cos()) < 2.0, "{x}");
            }
        }
        for i in 0..1_000_000 {
            let x = 8192.0 + i as f32 * 1.04;
            let (s, c) = sin_cos(x);
            assert!(
                (s as f64 - (x as f64).sin()).abs() < 1e-7 && (c as f64 - (x as f64).cos()).abs() < 1e-7,
                "{x}"
            );
        }
    }

    #[test]
    fn angles_hold_their_bound() {
        let parts =
            [0.0, 1e-30, 1e-3, 0.1, 0.41, 0.4143, 0.5, 0.999_999_9, 1.0, 1.000_000_1, 2.4, 7.0, 1e4, 1e30];
        let mut worst = 0f64;
        let mut check = |y: f32, x: f32| {
            worst = worst.max(ulps(atan2(y, x), f64::from(y).atan2(f64::from(x))));
        };
        for x in parts.into_iter().flat_map(|x| [x, -x]) {
            parts.into_iter().flat_map(|y| [y, -y]).filter(|y| *y != 0.0).for_each(|y| check(y, x));
        }
        for i in 1..1_000_000 {
            let (s, c) = sin_cos(i as f32 * (core::f32::consts::TAU / 1e6));
            check(s, c);
        }
        assert!(worst < 4.0, "{worst}");
        assert_eq!([atan2(0.0, 0.0), atan2(0.0, 1.0), atan2(0.0, -1.0)], [0.0, 0.0, PI]);
        for y in [f32::NAN, f32::INFINITY, 0.0, -1.0, f32::MAX] {
            for x in [f32::NAN, f32::NEG_INFINITY, 1.0, f32::MAX] {
                assert!(atan2(y, x).abs() <= PI, "{y} {x}");
            }
        }
    }

    #[test]
    fn sine_and_cosine_are_bounded_everywhere() {
        for bits in (0..=u32::MAX).step_by(509) {
            let (s, c) = sin_cos(f32::from_bits(bits));
            assert!((-1.0..=1.0).contains(&s) && (-1.0..=1.0).contains(&c), "{:e}", f32::from_bits(bits));
        }
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
    }

    #[test]
    fn srgb_code_is_that_of_double_precision() {
        let mut last = 0.0;
        for bits in (0..=1f32.to_bits()).step_by(101) {
            let x = f32::from_bits(bits);
            let (code, exact) = (linear_to_srgb(x), elementary64::linear_to_srgb(x as f64));
            assert!((code as f64 - exact).abs() < 2e-7, "{x:e}");
            assert!(code >= last - 2e-7, "{x:e}");
            last = code;
            let step = exact * 255.0;
            let tie = (step - step.floor() - 0.5).abs() < 5e-5;
            assert!(tie || (code * 255.0 + 0.5).floor() as f64 == (step + 0.5).floor(), "{x:e}");
        }
        assert_eq!([linear_to_srgb(0.0), linear_to_srgb(1.0)], [0.0, 1.0]);
    }
}
