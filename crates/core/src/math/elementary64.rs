//! Elementary functions in double precision, for preparing scenes: cameras, rotations, colour tables.
//!
//! The same methods and rules as in [`elementary`](super::elementary), where they are explained; the numbers that
//! scene preparation hands to the kernels must not depend on a system's maths library either.

use super::float::fma64;
use core::f64::consts::{FRAC_2_PI, FRAC_PI_2, LN_2, LOG2_E};

/// Adding 1.5 * 2^52 leaves the nearest whole number in the low bits of the sum, two's complement.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Polynomial by Horner's rule, the coefficient of the highest power first.
#[inline(always)]
fn horner<const N: usize>(coefficients: [f64; N], x: f64) -> f64 {
    coefficients.iter().fold(0.0, |sum, &c| fma64(sum, x, c))
}

/// `x` limited to `[low, high]`; `low` when `x` is NaN.
#[inline(always)]
fn clamp64(x: f64, low: f64, high: f64) -> f64 {
    let x = if x > low { x } else { low };
    if x < high { x } else { high }
}

/// Base-2 logarithm of a positive finite number as an unevaluated sum; the relative error is near 2^-64.
///
/// As in single precision, but here two terms of the series need double words: `s (K + s^2 (C + s^2 Q(s^2)))`.
#[inline(always)]
fn log2_parts(x: f64) -> (f64, f64) {
    const SQRT_HALF_BITS: u64 = 0x3fe6_a09e_667f_3bcd;
    const K: f64 = 2.0 * LOG2_E; // 2 / ln 2
    const K_LOW: f64 = 4.071_054_748_186_206_6e-17;
    const C: f64 = 0.961_796_693_925_975_6; // 2 / (3 ln 2)
    const C_LOW: f64 = 5.057_761_664_812_590_7e-17;
    const Q: [f64; 8] = [
        0.172_800_203_619_666_4,
        0.168_453_650_081_299_78,
        0.192_401_214_106_978_55,
        0.221_952_273_187_524,
        0.262_308_198_617_802_47,
        0.320_598_897_913_074_67,
        0.412_198_583_111_344_9,
        0.577_078_016_355_585_1,
    ];

    let subnormal = x < f64::MIN_POSITIVE;
    let bits = (if subnormal { x * 18_014_398_509_481_984.0 } else { x }).to_bits();
    let k = (bits.wrapping_sub(SQRT_HALF_BITS) as i64) >> 52;
    let m = f64::from_bits(bits.wrapping_sub((k << 52) as u64));
    let k = (k as i32 - if subnormal { 54 } else { 0 }) as f64;

    let f = m - 1.0;
    let d = f + 2.0;
    let d_low = f - (d - 2.0);
    let reciprocal = 1.0 / d;
    let s = f * reciprocal;
    let s_low = fma64(-s, d_low, fma64(-s, d, f)) * reciprocal;

    let z = s * s;
    let z_low = fma64(2.0 * s, s_low, fma64(s, s, -z));
    let tail = z * horner(Q, z);
    let t = C + tail;
    let t_low = (C - t) + tail + C_LOW;
    let u = z * t;
    let u_low = fma64(z_low, t, fma64(z, t_low, fma64(z, t, -u)));
    let v = K + u;
    let v_low = (K - v) + u + (u_low + K_LOW);
    let h = s * v;
    let h_low = fma64(s_low, v, fma64(s, v_low, fma64(s, v, -h)));

    let sum = k + h;
    let sum_low = (k - sum) + h + h_low;
    let high = sum + sum_low;
    (high, (sum - high) + sum_low)
}

/// `2^(p + e)` for a small correction `e`; `p` is limited to where the result over- or underflows anyway.
#[inline(always)]
fn exp2_parts(p: f64, e: f64) -> f64 {
    const Q: [f64; 11] = [
        4.449_955_477_539_567_3e-10,
        7.073_826_046_303_359e-9,
        1.017_808_677_368_769_3e-7,
        1.321_543_500_111_084_8e-6,
        1.525_273_380_550_841_5e-5,
        0.000_154_035_304_577_650_14,
        0.001_333_355_814_638_065_8,
        0.009_618_129_107_593_498,
        0.055_504_108_664_822_26,
        0.240_226_506_959_101_33,
        LN_2,
    ];
    let p = clamp64(p, -1500.0, 1500.0);
    let rounded = p + ROUND;
    let n = rounded.to_bits().wrapping_sub(ROUND.to_bits()) as i32;
    let r = (p - (rounded - ROUND)) + e;
    let half = n >> 1;
    fma64(horner(Q, r), r, 1.0) * power_of_two(half) * power_of_two(n - half)
}

/// `2^n` for n in [-1022, 1023].
#[inline(always)]
fn power_of_two(n: i32) -> f64 {
    f64::from_bits(((n + 1023) as u64) << 52)
}

/// Base-2 logarithm, within 1 ulp, subnormal numbers included. Zero gives minus infinity, negative numbers and NaN
/// give NaN.
#[inline(always)]
pub fn log2(x: f64) -> f64 {
    let (high, _) = log2_parts(x);
    let finite = if x < f64::INFINITY { high } else { x };
    let known = if x > 0.0 { finite } else { f64::NAN };
    if x == 0.0 { f64::NEG_INFINITY } else { known }
}

/// Two to the power of `x`, within 2 ulp, gradual underflow included. 1024 and more give infinity, NaN gives NaN.
#[inline(always)]
pub fn exp2(x: f64) -> f64 {
    let y = exp2_parts(x, 0.0);
    if x.is_nan() { x } else { y }
}

/// `x` to the power of `y` for `x >= 0`, within 3 ulp: always finite and never negative.
///
/// `pow(x, 0)` is 1 and `pow(0, y)` is 0 for positive `y`; results too large become the largest finite number.
/// Negative and NaN `x` count as zero, infinite ones as the largest finite number.
#[inline(always)]
pub fn pow(x: f64, y: f64) -> f64 {
    let x = clamp64(x, 0.0, f64::MAX);
    let (high, low) = log2_parts(x);
    let p = y * high;
    let e = if p.abs() < 1500.0 { fma64(y, low, fma64(y, high, -p)) } else { 0.0 };
    let power = clamp64(exp2_parts(p, e), 0.0, f64::MAX);
    let of_zero = if y > 0.0 { 0.0 } else { f64::MAX };
    let power = if x > 0.0 { power } else { of_zero };
    if y == 0.0 { 1.0 } else { power }
}

/// Sine and cosine of an angle in radians, each within 2 ulp for |x| up to 2^20.
///
/// Beyond, digits are lost, and from about 2^50 on, and for infinities and NaN, the results carry no meaning; but they
/// are always numbers in [-1, 1].
#[inline(always)]
pub fn sin_cos(x: f64) -> (f64, f64) {
    const SINE: [f64; 6] = [
        1.589_593_067_055_528_4e-10,
        -2.505_074_209_546_695_7e-8,
        2.755_731_358_085_508_6e-6,
        -0.000_198_412_698_294_547_8,
        0.008_333_333_333_321_915,
        -0.166_666_666_666_666_3,
    ];
    const COSINE: [f64; 7] = [
        -1.135_875_350_199_316_9e-11,
        2.087_570_550_504_334e-9,
        -2.755_731_421_798_882e-7,
        2.480_158_728_900_55e-5,
        -0.001_388_888_888_887_334_6,
        0.041_666_666_666_666_595,
        -0.5,
    ];
    let rounded = fma64(x, FRAC_2_PI, ROUND);
    let n = rounded - ROUND;
    let r = fma64(-n, 6.123_233_995_736_766e-17, fma64(-n, FRAC_PI_2, x));
    let r = clamp64(fma64(-n, -1.497_384_904_859_169_8e-33, r), -1.0, 1.0);

    let z = r * r;
    let sine = fma64(r * z, horner(SINE, z), r);
    let cosine = fma64(z, horner(COSINE, z), 1.0);

    let quadrant = rounded.to_bits();
    let swap = quadrant & 1 != 0;
    let (a, b) = if swap { (cosine, sine) } else { (sine, cosine) };
    let sign_a = (quadrant & 2) << 62;
    let sign_b = (quadrant.wrapping_add(1) & 2) << 62;
    (f64::from_bits(a.to_bits() ^ sign_a), f64::from_bits(b.to_bits() ^ sign_b))
}

/// Sine of an angle in radians; for bounds see [`sin_cos`].
#[inline(always)]
pub fn sin(x: f64) -> f64 {
    sin_cos(x).0
}

/// Cosine of an angle in radians; for bounds see [`sin_cos`].
#[inline(always)]
pub fn cos(x: f64) -> f64 {
    sin_cos(x).1
}

/// Tangent of an angle in radians, within 4 ulp for |x| up to 2^20.
#[inline(always)]
pub fn tan(x: f64) -> f64 {
    let (s, c) = sin_cos(x);
    s / c
}

/// The linear value of an sRGB code (IEC 61966-2-1), 0 to 1 for 0 to 1; not clamped to that range.
#[inline(always)]
pub fn srgb_to_linear(x: f64) -> f64 {
    let curve = pow((x + 0.055) / 1.055, 2.4);
    if x > 0.04045 { curve } else { x / 12.92 }
}

/// The sRGB code (IEC 61966-2-1) of a linear value, 0 to 1 for 0 to 1; not clamped to that range.
#[inline(always)]
pub fn linear_to_srgb(x: f64) -> f64 {
    let curve = fma64(1.055, pow(x, 1.0 / 2.4) - 1.0, 1.0);
    if x > 0.003_130_8 { curve } else { x * 12.92 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error in units of the last place against the standard library, itself good to one such unit.
    fn ulps(got: f64, want: f64) -> f64 {
        let exponent = ((want.abs().to_bits() >> 52) as i32 - 1023).max(-1022);
        // Two steps: the unit itself may be subnormal.
        (got - want).abs() * 2f64.powi(52 - exponent.max(-900)) / 2f64.powi(exponent.min(-900) + 900)
    }

    /// The largest error in ulps over a million bit patterns spread from `from` to `to`, both of one sign.
    fn worst(from: f64, to: f64, got: impl Fn(f64) -> f64, want: impl Fn(f64) -> f64) -> f64 {
        let stride = (to.to_bits() - from.to_bits()) / 1_000_000 + 1;
        let mut worst = (0.0, 0.0);
        for bits in (from.to_bits()..=to.to_bits()).step_by(stride as usize) {
            let x = f64::from_bits(bits);
            let error = ulps(got(x), want(x));
            assert!(!error.is_nan(), "not a number at {x:e}");
            worst = if error > worst.0 { (error, x) } else { worst };
        }
        println!("{from:e} to {to:e}: {} ulp at {:e}", worst.0, worst.1);
        worst.0
    }

    #[test]
    fn logarithm_and_exponential_hold_their_bounds() {
        assert!(worst(5e-324, f64::MAX, log2, f64::log2) <= 1.0);
        assert!(worst(0.9, 1.1, log2, f64::log2) <= 1.0);
        assert!(worst(1.0 - 1e-9, 1.0 + 1e-9, log2, f64::log2) <= 1.0);
        assert!(worst(1e-18, 1023.999, exp2, f64::exp2) <= 2.0);
        assert!(worst(-1e-18, -1080.0, exp2, f64::exp2) <= 2.0);
        for k in -1074..=1023 {
            let power = if k < -1000 { 2f64.powi(-1000) * 2f64.powi(k + 1000) } else { 2f64.powi(k) };
            assert_eq!((log2(power), exp2(k as f64)), (k as f64, power));
        }
    }

    #[test]
    fn power_holds_its_bound() {
        for y in [0.01, 1.0 / 2.4, 0.5, 1.0, 2.0, 2.4, 30.0, 1000.0, 1e6, -0.7, -50.0] {
            let (a, b) = (2f64.powf(-1021.0 / y), 2f64.powf(1023.0 / y));
            let (low, high) = (a.min(b).max(5e-324), a.max(b).min(f64::MAX));
            assert!(worst(low, high, |x| pow(x, y), |x| x.powf(y)) <= 3.0, "exponent {y}");
        }
    }

    #[test]
    fn trigonometry_holds_its_bounds() {
        for (from, to) in [(1e-300, 1e-3), (1e-3, 7.0), (7.0, 1_048_576.0), (-1e-3, -1_048_576.0)] {
            assert!(worst(from, to, sin, f64::sin) <= 2.0);
            assert!(worst(from, to, cos, f64::cos) <= 2.0);
            assert!(worst(from, to, tan, f64::tan) <= 4.0);
        }
        for n in 1..600_000 {
            let x = n as f64 * FRAC_PI_2;
            assert!(ulps(sin(x), x.sin()) <= 2.0 && ulps(cos(x), x.cos()) <= 2.0, "{x}");
        }
    }

    #[test]
    fn special_cases() {
        let numbers = [0.0, -0.0, 5e-324, 0.3, 1.0, 7.0, f64::MAX, f64::INFINITY, -2.0, f64::NAN];
        for x in numbers {
            let (s, c) = sin_cos(x);
            assert!((-1.0..=1.0).contains(&s) && (-1.0..=1.0).contains(&c), "{x}");
            assert_eq!(pow(x, 0.0), 1.0);
            for y in numbers.iter().flat_map(|&y| [y, -y]) {
                assert!((0.0..=f64::MAX).contains(&pow(x, y)), "{x}^{y}");
            }
        }
        assert_eq!([pow(0.0, 2.0), pow(0.0, -2.0), pow(1.0, 1e300)], [0.0, f64::MAX, 1.0]);
        assert_eq!((log2(0.0), log2(f64::INFINITY)), (f64::NEG_INFINITY, f64::INFINITY));
        assert_eq!((exp2(f64::INFINITY), exp2(f64::NEG_INFINITY)), (f64::INFINITY, 0.0));
        assert!(log2(-1.0).is_nan() && log2(f64::NAN).is_nan() && exp2(f64::NAN).is_nan());
    }

    #[test]
    fn srgb_follows_the_standard() {
        // Known pairs: the two ends, the middle grey of 8 bits, the joint of the two branches.
        assert_eq!([srgb_to_linear(0.0), srgb_to_linear(1.0)], [0.0, 1.0]);
        assert_eq!([linear_to_srgb(0.0), linear_to_srgb(1.0)], [0.0, 1.0]);
        assert!((srgb_to_linear(128.0 / 255.0) - 0.215_860_500_113_899_26).abs() < 1e-15);
        assert!((linear_to_srgb(0.18) - 0.461_356_129_500_441_6).abs() < 1e-15);
        for byte in 0..=255 {
            let code = byte as f64 / 255.0;
            assert!((linear_to_srgb(srgb_to_linear(code)) - code).abs() < 1e-14, "{byte}");
        }
    }
}
