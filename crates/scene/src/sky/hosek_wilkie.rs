//! The sky and the sun of Hosek and Wilkie.
//!
//! The sky: "An Analytic Model for Full Spectral Sky-Dome Radiance" (ACM Transactions on Graphics 31, 4, 2012). The sun: "Adding a
//! Solar-Radiance Function to the Hosek-Wilkie Skylight Model" (IEEE Computer Graphics and Applications 33, 3, 2013), with limb
//! darkening. The numbers are the authors' (data/LICENSE.txt), as Mitsuba 3.9.1 keeps them for red, green and blue: linear,
//! with Rec. 709's primaries (data/extract.py).

use super::angles::asin;
use eosphor_core::math::elementary64::{exp2, pow};
use std::f64::consts::{FRAC_PI_2, LOG2_E};
use std::ops::Mul;

/// Little-endian single precision; the arrays follow each other.
static DATA: &[u8; 4 * (SHAPES + MEANS + SUNS)] = include_bytes!("data/hosek-wilkie.f32");

const TURBIDITIES: usize = 10;
const ALBEDOS: usize = 2;
const CONTROL_POINTS: usize = 6;
const CHANNELS: usize = 3;
const COEFFICIENTS: usize = 9;
const SEGMENTS: usize = 45;
const POWERS: usize = 4;
const DARKENINGS: usize = 6;
const SHAPES: usize = MEANS * COEFFICIENTS;
const MEANS: usize = TURBIDITIES * ALBEDOS * CONTROL_POINTS * CHANNELS;
const SUNS: usize = TURBIDITIES * SEGMENTS * CHANNELS * POWERS * DARKENINGS;

/// Half the angle that the sun fills, in radians: 0.5358 degrees / 2.
pub(super) const SUN_RADIUS: f64 = 0.2679 * (std::f64::consts::PI / 180.0);

/// From what the sky's numbers mean to cd/m²: lumens per watt at 555 nm. Those of the sun are per nanometre, once more.
const CANDELA: f64 = 683.0;

/// Mitsuba's, from the numbers of the sun to those of the sky.
const SKY_FROM_SUN: f64 = 467.069_280_386;

/// Red, green and blue.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rgb(pub(super) [f64; 3]);

impl Rgb {
    pub(super) fn add(&mut self, other: Rgb) {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a += b);
    }
}

impl Mul<f64> for Rgb {
    type Output = Rgb;

    fn mul(self, factor: f64) -> Rgb {
        Rgb(self.0.map(|x| x * factor))
    }
}

fn number(at: usize) -> f64 {
    let bytes = [0, 1, 2, 3].map(|k| DATA[4 * at + k]);
    f64::from(f32::from_le_bytes(bytes))
}

/// The lower of two turbidities with data, from 0, and how far the next is on the way.
fn between(turbidity: f64) -> (usize, f64) {
    let place = (turbidity - 1.0).clamp(0.0, (TURBIDITIES - 1) as f64);
    let low = (place as usize).min(TURBIDITIES - 2);
    (low, place - low as f64)
}

/// Where elevations stand in the data: 0 at the horizon, 1 at the zenith.
fn elevation_place(elevation: f64) -> f64 {
    pow((elevation / FRAC_PI_2).clamp(0.0, 1.0), 1.0 / 3.0)
}

/// The sky without its sun.
#[derive(Clone, Debug)]
pub(super) struct SkyDome {
    /// Of each channel, named A to I in the paper.
    shape: [[f64; COEFFICIENTS]; CHANNELS],
    mean: [f64; CHANNELS],
}

impl SkyDome {
    /// A turbidity from 1 to 10, an albedo of the ground from 0 to 1, the sun's elevation in radians from 0 to pi/2.
    pub(super) fn new(turbidity: f64, albedo: f64, elevation: f64) -> SkyDome {
        let x = elevation_place(elevation);
        let y = 1.0 - x;
        // Bernstein's polynomials.
        let (x2, y2) = (x * x, y * y);
        let bezier = [
            y2 * y2 * y,
            5.0 * x * y2 * y2,
            10.0 * x2 * y2 * y,
            10.0 * x2 * x * y2,
            5.0 * x2 * x2 * y,
            x2 * x2 * x,
        ];
        let (low, rest) = between(turbidity);
        let interpolated = |of: &dyn Fn(usize) -> f64| {
            let mut sum = 0.0;
            for (t, share_t) in [(low, 1.0 - rest), (low + 1, rest)] {
                for (a, share_a) in [(0, 1.0 - albedo), (1, albedo)] {
                    for (k, weight) in bezier.iter().enumerate() {
                        sum += share_t * share_a * weight * of((t * ALBEDOS + a) * CONTROL_POINTS + k);
                    }
                }
            }
            sum
        };
        let shape = |channel: usize, k: usize| {
            interpolated(&|row| number((row * CHANNELS + channel) * COEFFICIENTS + k))
        };
        let mean = |channel: usize| interpolated(&|row| number(SHAPES + row * CHANNELS + channel));
        SkyDome {
            shape: [0, 1, 2].map(|channel| std::array::from_fn(|k| shape(channel, k))),
            mean: [0, 1, 2].map(mean),
        }
    }

    /// The part of the radiance that directions of one elevation share. `up`: the sine of that, 0 to 1.
    pub(super) fn ring(&self, up: f64) -> SkyRing<'_> {
        let fade = |channel: usize| {
            let [a, b, ..] = self.shape[channel];
            1.0 + a * exp2(LOG2_E * b / (up + 0.01))
        };
        SkyRing { dome: self, fade: [0, 1, 2].map(fade), zenith: up.sqrt() }
    }
}

/// Directions of one elevation.
pub(super) struct SkyRing<'a> {
    dome: &'a SkyDome,
    fade: [f64; CHANNELS],
    zenith: f64,
}

impl SkyRing<'_> {
    /// Radiance in cd/m², at an angle from the sun, in radians, of this cosine. Colours beyond Rec. 709's have channels below 0.
    pub(super) fn radiance(&self, angle: f64, cosine: f64) -> Rgb {
        let channel = |k: usize| {
            let [_, _, c, d, e, f, g, h, i] = self.dome.shape[k];
            let rayleigh = cosine * cosine;
            let base = 1.0 + i * i - 2.0 * i * cosine;
            let glow = (1.0 + rayleigh) / (base * base.sqrt());
            let sum = c + d * exp2(LOG2_E * e * angle) + f * rayleigh + g * glow + h * self.zenith;
            CANDELA * self.fade[k] * sum * self.dome.mean[k]
        };
        Rgb([0, 1, 2].map(channel))
    }
}

/// The sun's disk.
#[derive(Clone, Debug)]
pub(super) struct SunDisk {
    /// By segment, channel and power of the elevation within the segment: coefficients of the powers of the cosine between the ray
    /// and the sun's surface.
    segments: Vec<[[[f64; DARKENINGS]; POWERS]; CHANNELS]>,
}

impl SunDisk {
    /// A turbidity from 1 to 10.
    pub(super) fn new(turbidity: f64) -> SunDisk {
        let (low, rest) = between(turbidity);
        let coefficient = |row: usize| {
            let of = |t: usize| number(SHAPES + MEANS + t * (SUNS / TURBIDITIES) + row);
            (1.0 - rest) * of(low) + rest * of(low + 1)
        };
        let segment = |s: usize| {
            [0, 1, 2].map(|channel| {
                std::array::from_fn(|power| {
                    std::array::from_fn(|k| {
                        coefficient(((s * CHANNELS + channel) * POWERS + power) * DARKENINGS + k)
                    })
                })
            })
        };
        SunDisk { segments: (0..SEGMENTS).map(segment).collect() }
    }

    /// Radiance in cd/m² of a place of the disk. `up`: the sine of its elevation; `from_middle`: how far it is from the middle over
    /// the disk's radius, 0 to 1. Colours beyond Rec. 709's have channels below 0.
    pub(super) fn radiance(&self, up: f64, from_middle: f64) -> Rgb {
        let elevation = asin(up.clamp(0.0, 1.0));
        let segment = ((elevation_place(elevation) * SEGMENTS as f64) as usize).min(SEGMENTS - 1);
        let first = segment as f64 / SEGMENTS as f64;
        let x = elevation - FRAC_PI_2 * first * first * first;
        let inward = (1.0 - from_middle * from_middle).max(0.0).sqrt();
        let polynomial =
            |coefficients: &[f64], x: f64| coefficients.iter().rev().fold(0.0, |sum, &c| sum * x + c);
        let channel = |k: usize| {
            let powers = self.segments[segment][k].map(|darkening| polynomial(&darkening, inward));
            CANDELA * SKY_FROM_SUN * polynomial(&powers, x)
        };
        Rgb([0, 1, 2].map(channel))
    }
}
