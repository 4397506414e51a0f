//! Tone curves: linear light without an upper end to linear colours of a screen, 0 to 1.
//!
//! Everything is arithmetic of core in straight lines, so that a loop over pixels vectorises and has the same bits on every
//! machine. No closures and no `map` of arrays: what is not inlined is compiled for the baseline, where each fused multiply-add is
//! a library call. `tone_curve/truth.py` computes the same from the publications.

use super::{PIXELS, ToneCurve};
use crate::math::elementary::{log2, pow};
use crate::math::{clamp, fma, max, min};

#[cfg(test)]
mod tests;

/// Colours of pixels: all reds, all greens, all blues.
pub type Planes<const N: usize = PIXELS> = [[f32; N]; 3];

/// More light than this is this much: all curves are white long before, and squares of it are finite.
const MOST: f32 = 4_294_967_296.0;

type Matrix = [[f32; 3]; 3];

/// Applies a curve to each pixel. What is no light (NaN, less than 0) counts as 0. Colours may come out a little outside 0 to 1.
#[inline(always)]
pub fn bend<const N: usize>(curve: ToneCurve, [red, green, blue]: &mut Planes<N>) {
    match curve {
        ToneCurve::None => {}
        ToneCurve::Aces => {
            for ((r, g), b) in red.iter_mut().zip(green).zip(blue) {
                [*r, *g, *b] = aces([light(*r), light(*g), light(*b)]);
            }
        }
        ToneCurve::Agx => {
            for ((r, g), b) in red.iter_mut().zip(green).zip(blue) {
                [*r, *g, *b] = agx([light(*r), light(*g), light(*b)]);
            }
        }
        ToneCurve::Neutral => {
            for ((r, g), b) in red.iter_mut().zip(green).zip(blue) {
                [*r, *g, *b] = neutral([light(*r), light(*g), light(*b)]);
            }
        }
    }
}

#[inline(always)]
fn light(x: f32) -> f32 {
    if x > 0.0 { min(x, MOST) } else { 0.0 }
}

#[inline(always)]
fn times(m: &Matrix, color: [f32; 3]) -> [f32; 3] {
    [dot(m[0], color), dot(m[1], color), dot(m[2], color)]
}

#[inline(always)]
fn dot(row: [f32; 3], [r, g, b]: [f32; 3]) -> f32 {
    fma(row[2], b, fma(row[1], g, row[0] * r))
}

/// Khronos PBR Neutral, as PBR_Neutral/README.md of github.com/KhronosGroup/ToneMapping specifies it (2024).
#[inline(always)]
fn neutral([r, g, b]: [f32; 3]) -> [f32; 3] {
    /// What dielectrics reflect at normal incidence: the curve takes it away.
    const F90: f32 = 0.04;
    /// From here on light is compressed.
    const START: f32 = 0.8 - F90;
    const DESATURATION: f32 = 0.15;

    let x = min(r, min(g, b));
    let offset = if x <= 2.0 * F90 { fma(x * x, -1.0 / (4.0 * F90), x) } else { F90 };
    let [r, g, b] = [r - offset, g - offset, b - offset];
    let peak = max(r, max(g, b));
    let compressed = 1.0 - (1.0 - START) * (1.0 - START) / (max(peak, START) + (1.0 - 2.0 * START));
    let share = 1.0 / fma(DESATURATION, peak - compressed, 1.0);
    let (scale, white) = (compressed / max(peak, START) * share, compressed * (1.0 - share));
    let is_bright = peak > START;
    let (scale, white) = if is_bright { (scale, white) } else { (1.0, 0.0) };
    [fma(r, scale, white), fma(g, scale, white), fma(b, scale, white)]
}

/// Stephen Hill's fit of the ACES reference rendering transform and the output transform of sRGB: `ACES.hlsl` of
/// github.com/TheRealMJP/BakingLab (2016). Its matrices go from linear sRGB to the space of the curve and back.
#[inline(always)]
#[allow(clippy::excessive_precision, reason = "digits as published")]
fn aces(color: [f32; 3]) -> [f32; 3] {
    const BEFORE: Matrix =
        [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    const AFTER: Matrix =
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let [r, g, b] = times(&BEFORE, color);
    times(&AFTER, [aces_fit(r), aces_fit(g), aces_fit(b)])
}

#[inline(always)]
fn aces_fit(v: f32) -> f32 {
    fma(v, v + 0.024_578_6, -0.000_090_537) / fma(v, fma(0.983_729, v, 0.432_951), 0.238_081)
}

/// AgX by Troy Sobotka (github.com/sobotka/AgX, 2022) without a look: its sigmoid over the logarithm of light, between the matrices
/// of Blender's AgX (github.com/EaryChow/AgX_LUT_Gen), in Rec. 2020, as Filament and three.js have them. Those two have a
/// polynomial in place of the sigmoid.
#[inline(always)]
#[allow(clippy::excessive_precision, reason = "nine digits, as single precision has at most")]
fn agx(color: [f32; 3]) -> [f32; 3] {
    /// From linear sRGB to Rec. 2020 (ITU-R BT.2087), and then inwards.
    const BEFORE: Matrix = [
        [0.544_814_75, 0.373_787_4, 0.081_397_855],
        [0.140_416_95, 0.754_137_55, 0.105_445_5],
        [0.088_810_42, 0.178_871_76, 0.732_317_8],
    ];
    /// Outwards.
    const AFTER: Matrix = [
        [1.127_100_6, -0.110_606_64, -0.016_493_939],
        [-0.141_329_76, 1.157_823_7, -0.016_493_939],
        [-0.141_329_76, -0.110_606_64, 1.251_936_4],
    ];
    const SRGB_FROM_REC2020: Matrix = [
        [1.660_491, -0.587_641_14, -0.072_849_86],
        [-0.124_550_476, 1.132_899_9, -0.008_349_423],
        [-0.018_150_763, -0.100_578_9, 1.118_729_7],
    ];
    let [r, g, b] = times(&BEFORE, color);
    let [r, g, b] = times(&AFTER, [agx_sigmoid(r), agx_sigmoid(g), agx_sigmoid(b)]);
    // (Powers take what is below 0 as 0.)
    times(&SRGB_FROM_REC2020, [pow(r, 2.2), pow(g, 2.2), pow(b, 2.2)])
}

/// From light, by the logarithm of 10 stops below middle grey to 6.5 above it, to 0 to 1.
///
/// Below and above the pivot, which is middle grey, it is `0.5 + 2 d / (1 + a |d|^n)^(1/n)`, with `d` the distance from there and
/// `a` such that the ends are 0 and 1.
#[inline(always)]
fn agx_sigmoid(x: f32) -> f32 {
    const STOPS: f64 = 16.5;
    const PIVOT: f32 = (10.0 / STOPS) as f32;
    /// log2 of middle grey, 0.18.
    const LOG2_GREY: f64 = -2.473_931_188_332_412;
    const LOWEST: f64 = LOG2_GREY - 10.0;
    /// Powers of toe and shoulder, and their `a`: 4^n - (distance from the pivot to the end)^-n.
    const TOE: (f32, f32) = (3.0, 59.507_875);
    const SHOULDER: (f32, f32) = (3.25, 69.862_79);

    let t = clamp(fma(log2(x), (1.0 / STOPS) as f32, (-LOWEST / STOPS) as f32), 0.0, 1.0);
    let d = t - PIVOT;
    let n = if d < 0.0 { TOE.0 } else { SHOULDER.0 };
    let a = if d < 0.0 { TOE.1 } else { SHOULDER.1 };
    let inverse = if d < 0.0 { -1.0 / TOE.0 } else { -1.0 / SHOULDER.0 };
    fma(2.0 * d, pow(fma(a, pow(d.abs(), n), 1.0), inverse), 0.5)
}
