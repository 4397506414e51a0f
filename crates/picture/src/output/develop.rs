//! Developing: linear film to display bytes.

use eosphor_accel::SimdLevel;
use eosphor_core::math::elementary::{exp2, linear_to_srgb};
use eosphor_core::math::{Vec3, min};
use eosphor_render::Film;
use eosphor_scene::{RenderSettings, Transfer};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How linear colours become bytes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DevelopSettings {
    /// Stops: colours are multiplied by 2 to this power before anything else.
    pub exposure: f32,
    /// The curve between linear light and byte.
    pub transfer: Transfer,
}

impl Default for DevelopSettings {
    fn default() -> DevelopSettings {
        DevelopSettings { exposure: 0.0, transfer: Transfer::Srgb }
    }
}

impl From<&RenderSettings> for DevelopSettings {
    fn from(settings: &RenderSettings) -> DevelopSettings {
        DevelopSettings { exposure: settings.exposure, transfer: settings.transfer }
    }
}

/// A picture in bytes, ready for a screen: R, G, B, top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Developed {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// `width * height * 3` bytes.
    pub rgb: Vec<u8>,
    /// `width * height` bytes, from 0 for what is not there to 255; none where the picture has no alpha channel.
    pub alpha: Vec<u8>,
}

impl Developed {
    /// Exposure, transfer, clamp to 0..1, then rounding half up. NaN becomes 0. The same film gives the same bytes on
    /// every machine.
    pub fn new(film: &Film, settings: &DevelopSettings) -> Developed {
        let gain = exp2(settings.exposure);
        let width = film.width as usize;
        let mut rgb = vec![0; film.pixels.len() * 3];
        if width > 0 {
            let rows = rgb.par_chunks_mut(width * 3).zip(film.pixels.par_chunks(width));
            rows.for_each(|(bytes, colours)| develop_row(bytes, colours, gain, settings.transfer));
        }
        Developed { width: film.width, height: film.height, rgb, alpha: Vec::new() }
    }

    /// The bytes of one row, from the left.
    pub fn row(&self, y: u32) -> &[u8] {
        let length = self.width as usize * 3;
        &self.rgb[y as usize * length..][..length]
    }
}

/// Develops a row with the best instructions that the CPU has: without them each fused multiply-add of the curve is a
/// library call. All give the same bytes. `cargo xtask fma` looks for these functions by name.
fn develop_row(bytes: &mut [u8], colours: &[Vec3], gain: f32, transfer: Transfer) {
    match SimdLevel::best() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `SimdLevel::best` returns only levels that the CPU has, and both of these have AVX2 and FMA.
        SimdLevel::Avx2 | SimdLevel::Avx512 => unsafe {
            develop_row_avx2(bytes, colours, gain, transfer);
        },
        _ => develop_row_with(bytes, colours, gain, transfer),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
unsafe fn develop_row_avx2(bytes: &mut [u8], colours: &[Vec3], gain: f32, transfer: Transfer) {
    develop_row_with(bytes, colours, gain, transfer);
}

/// Pixels that are developed together.
const PIXELS: usize = 16;

#[inline(always)]
fn develop_row_with(bytes: &mut [u8], colours: &[Vec3], gain: f32, transfer: Transfer) {
    for (bytes, colours) in bytes.chunks_mut(3 * PIXELS).zip(colours.chunks(PIXELS)) {
        let mut values = [0.0; 3 * PIXELS];
        for (values, colour) in values.as_chunks_mut::<3>().0.iter_mut().zip(colours) {
            *values = [colour.x * gain, colour.y * gain, colour.z * gain];
        }
        match transfer {
            Transfer::Srgb => {
                for value in &mut values {
                    *value = linear_to_srgb(cut(*value));
                }
            }
            Transfer::Linear => {
                for value in &mut values {
                    *value = cut(*value);
                }
            }
        }
        let mut developed = [0; 3 * PIXELS];
        for (byte, value) in developed.iter_mut().zip(&values) {
            *byte = quantise(*value);
        }
        bytes.copy_from_slice(&developed[..bytes.len()]);
    }
}

/// Clamps to 0..1, before the curve: outside its value does not matter, and NaN must not reach it.
#[inline(always)]
fn cut(linear: f32) -> f32 {
    if linear > 0.0 { min(linear, 1.0) } else { 0.0 }
}

/// 0..1 to 0..255, half up (a cast of what is not negative rounds down).
#[inline(always)]
fn quantise(x: f32) -> u8 {
    (x * 255.0 + 0.5) as i32 as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn develop(linear: f32, settings: DevelopSettings) -> u8 {
        let film = Film { width: 1, height: 1, pixels: vec![Vec3::splat(linear)] };
        Developed::new(&film, &settings).rgb[0]
    }

    fn srgb(linear: f32) -> u8 {
        develop(linear, DevelopSettings::default())
    }

    fn linear(value: f32) -> u8 {
        develop(value, DevelopSettings { exposure: 0.0, transfer: Transfer::Linear })
    }

    #[test]
    fn known_srgb_values() {
        assert_eq!([srgb(0.0), srgb(1.0), srgb(0.5), srgb(0.215_860_5)], [0, 255, 188, 128]);
    }

    #[test]
    fn halves_round_up() {
        // Both products are exact in f32, so the half is a true half.
        assert_eq!(linear(0.5), 128, "127.5");
        assert_eq!(linear(f32::from_bits(0.5f32.to_bits() - 1)), 127, "just under 127.5");
    }

    #[test]
    fn every_byte_survives_the_linear_transfer() {
        for byte in 0..=255 {
            assert_eq!(linear(byte as f32 / 255.0), byte);
        }
    }

    #[test]
    fn what_is_no_colour_is_clamped() {
        assert_eq!([srgb(f32::NAN), srgb(-1.0), srgb(f32::NEG_INFINITY)], [0, 0, 0]);
        assert_eq!([srgb(2.0), srgb(f32::INFINITY), srgb(f32::MAX)], [255, 255, 255]);
    }

    #[test]
    fn a_stop_doubles() {
        let stop = |exposure| DevelopSettings { exposure, transfer: Transfer::Linear };
        assert_eq!(develop(0.25, stop(1.0)), linear(0.5));
        assert_eq!(develop(1.0, stop(-1.0)), linear(0.5));
        assert_eq!(develop(0.0, stop(f32::MAX)), 0, "0 times infinity is NaN");
    }

    #[test]
    fn an_empty_film_develops_to_nothing() {
        assert!(Developed::new(&Film::new(0, 7), &DevelopSettings::default()).rgb.is_empty());
    }
}
