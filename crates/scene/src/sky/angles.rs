//! Angles in double precision, without a maths library.

use eosphor_core::math::{elementary, elementary64};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The angle whose sine and cosine these are, or a common multiple of them; -pi to pi.
pub(super) fn atan2(sine: f64, cosine: f64) -> f64 {
    let length = (sine * sine + cosine * cosine).sqrt();
    if !(length > 0.0) {
        return 0.0;
    }
    let (sine, cosine) = (sine / length, cosine / length);
    // Single precision is off by less than 1e-6, and the sine of that is what is left, but for its cube.
    let near = f64::from(elementary::atan2(sine as f32, cosine as f32));
    let (s, c) = elementary64::sin_cos(near);
    near + (sine * c - cosine * s)
}

/// The angle of this sine, -pi/2 to pi/2; beyond -1 and 1 as there.
pub(super) fn asin(sine: f64) -> f64 {
    let sine = sine.clamp(-1.0, 1.0);
    let cosine = ((1.0 - sine) * (1.0 + sine)).sqrt();
    if cosine > 0.0 { atan2(sine, cosine) } else { FRAC_PI_2 * sine }
}

/// The same direction, 0 to 2 pi.
pub(super) fn turned_once(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).floor()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_of_known_sines() {
        for k in -3000..=3000 {
            let angle = f64::from(k) * 1e-3;
            let (s, c) = elementary64::sin_cos(angle);
            for scale in [1.0, 1e-3, 250.0] {
                assert!((atan2(scale * s, scale * c) - angle).abs() < 2e-15, "{angle}");
            }
            if angle.abs() < 1.5 {
                assert!((asin(s) - angle).abs() < 1e-14, "{angle}");
            }
        }
        assert_eq!((atan2(0.0, 0.0), asin(1.0), asin(-7.0)), (0.0, FRAC_PI_2, -FRAC_PI_2));
        assert!((turned_once(-1.0) - (TAU - 1.0)).abs() < 1e-15);
    }
}
