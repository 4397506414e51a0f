//! Developing: what a linear colour becomes on its way to three bytes of a screen: exposure, tone curve, clamp to 0..1, transfer,
//! then rounding half up. NaN becomes 0.
//!
//! CPUs develop blocks of [`PIXELS`] pixels step by step, which vectorises; GPUs one pixel after the other, by the same steps
//! ([`developed`]).

mod tone_curve;

pub use tone_curve::{Planes, bend};

use crate::math::elementary::linear_to_srgb;
use crate::math::{Vec3, min};

/// Pixels that a CPU develops together.
pub const PIXELS: usize = 16;

/// What becomes of light that is brighter than a screen. See `docs/units.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[repr(u32)]
pub enum ToneCurve {
    /// It is cut.
    None,
    /// ACES by Stephen Hill's fit: strong contrast, bright colours become white.
    Aces,
    /// AgX by Troy Sobotka, without a look: soft contrast, all colours become white bit by bit.
    Agx,
    /// Khronos PBR Neutral: colours stay as they are up to 0.8, less a reflection of 0.04; the rest is compressed.
    Neutral,
}

/// How linear colours become bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[repr(u32)]
pub enum Transfer {
    /// IEC 61966-2-1.
    Srgb,
    /// As they are.
    Linear,
}

/// How colours are developed, as kernels take it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Development {
    /// What colours are multiplied by before anything else: 2 to the power of the exposure in stops.
    pub gain: f32,
    /// What becomes of light that is brighter than a screen.
    pub tone_curve: ToneCurve,
    /// The curve between linear light and byte.
    pub transfer: Transfer,
}

/// The bytes of one pixel: red, green, blue.
#[inline(always)]
pub fn developed(color: Vec3, development: &Development) -> [u8; 3] {
    let [r, g, b] = exposed(color, development.gain);
    let mut planes = [[r], [g], [b]];
    bend(development.tone_curve, &mut planes);
    let [r, g, b] = &mut planes;
    transferred(r, development.transfer);
    transferred(g, development.transfer);
    transferred(b, development.transfer);
    [quantised(r[0]), quantised(g[0]), quantised(b[0])]
}

/// The channels of a colour, times the gain.
#[inline(always)]
pub fn exposed(color: Vec3, gain: f32) -> [f32; 3] {
    [color.x * gain, color.y * gain, color.z * gain]
}

/// Clamps all values to 0..1 and applies the transfer curve to them.
#[inline(always)]
pub fn transferred<const N: usize>(values: &mut [f32; N], transfer: Transfer) {
    match transfer {
        Transfer::Srgb => {
            for value in values {
                *value = linear_to_srgb(cut(*value));
            }
        }
        Transfer::Linear => {
            for value in values {
                *value = cut(*value);
            }
        }
    }
}

/// Clamps to 0..1, before the transfer curve: outside its value does not matter, and NaN must not reach it.
#[inline(always)]
fn cut(linear: f32) -> f32 {
    if linear > 0.0 { min(linear, 1.0) } else { 0.0 }
}

/// 0..1 to 0..255, half up (a cast of what is not negative rounds down).
#[inline(always)]
pub fn quantised(x: f32) -> u8 {
    (x * 255.0 + 0.5) as i32 as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;

    const CURVES: [ToneCurve; 4] = [ToneCurve::None, ToneCurve::Aces, ToneCurve::Agx, ToneCurve::Neutral];

    fn bytes_of(color: Vec3, gain: f32, tone_curve: ToneCurve, transfer: Transfer) -> [u8; 3] {
        developed(color, &Development { gain, tone_curve, transfer })
    }

    #[test]
    fn channels_stay_where_they_are() {
        let color = vec3(0.1, 0.25, 3.0);
        assert_eq!(bytes_of(color, 2.0, ToneCurve::None, Transfer::Linear), [51, 128, 255]);
        assert_eq!(bytes_of(vec3(0.0, 0.5, 1.0), 1.0, ToneCurve::None, Transfer::Srgb), [0, 188, 255]);
    }

    /// Middle grey, white and light of 100: sRGB of what `tone_curve/truth.py` prints.
    #[test]
    fn curves_come_before_the_transfer() {
        let bytes = CURVES.map(|curve| {
            [0.18, 1.0, 100.0].map(|light| bytes_of(Vec3::splat(light), 1.0, curve, Transfer::Srgb)[1])
        });
        assert_eq!(bytes, [[118, 255, 255], [91, 206, 255], [128, 202, 255], [105, 240, 255]]);
    }

    #[test]
    fn what_is_no_light_is_black() {
        for curve in CURVES {
            for light in [f32::NAN, -1.0, f32::NEG_INFINITY, 0.0, -0.0] {
                assert_eq!(
                    bytes_of(Vec3::splat(light), 1.0, curve, Transfer::Srgb),
                    [0; 3],
                    "{curve:?} {light}"
                );
            }
        }
    }
}
