//! Developing: linear film to display bytes.

use crate::film::{Film, zeros};
use eosphor_accel::SimdLevel;
use eosphor_core::develop::{
    Development, PIXELS, Planes, ToneCurve, Transfer, bend, exposed, quantised, transferred,
};
use eosphor_core::math::Vec3;
use eosphor_core::math::elementary::exp2;
use eosphor_scene::RenderSettings;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How linear colours become bytes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DevelopSettings {
    /// Stops: colours are multiplied by 2 to this power before anything else.
    pub exposure: f32,
    /// What becomes of light that is brighter than a screen.
    pub tone_curve: ToneCurve,
    /// The curve between linear light and byte.
    pub transfer: Transfer,
}

impl Default for DevelopSettings {
    fn default() -> DevelopSettings {
        DevelopSettings { exposure: 0.0, tone_curve: ToneCurve::None, transfer: Transfer::Srgb }
    }
}

impl DevelopSettings {
    /// The same as devices take it.
    pub fn development(&self) -> Development {
        let DevelopSettings { exposure, tone_curve, transfer } = *self;
        Development { gain: exp2(exposure), tone_curve, transfer }
    }
}

impl From<&RenderSettings> for DevelopSettings {
    fn from(settings: &RenderSettings) -> DevelopSettings {
        let RenderSettings { exposure, tone_curve, transfer, .. } = *settings;
        DevelopSettings { exposure, tone_curve, transfer }
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
    /// Exposure, tone curve, clamp to 0..1, transfer, then rounding half up. NaN becomes 0. The same film gives the same bytes on
    /// every machine.
    pub fn new(film: &Film, settings: &DevelopSettings) -> Developed {
        let development = settings.development();
        let width = film.width as usize;
        // As many as there are: a film that lacks some is refused where it is written.
        let rgb = zeros(film.pixels.len() * 3);
        let mut developed = Developed { width: film.width, height: film.height, rgb, alpha: Vec::new() };
        if width > 0 {
            let rows = developed.rgb.par_chunks_mut(width * 3).zip(film.pixels.par_chunks(width));
            rows.for_each(|(bytes, colours)| develop_row(bytes, colours, &development));
        }
        developed
    }

    /// A black picture of this width and height in pixels, without alpha.
    pub fn black(width: u32, height: u32) -> Developed {
        let rgb = zeros(width as usize * height as usize * 3);
        Developed { width, height, rgb, alpha: Vec::new() }
    }

    /// The bytes of one row, from the left.
    pub fn row(&self, y: u32) -> &[u8] {
        let length = self.width as usize * 3;
        &self.rgb[y as usize * length..][..length]
    }
}

/// Develops a row with the best instructions that the CPU has: without them each fused multiply-add of the curve is a
/// library call. All give the same bytes. `cargo xtask fma` looks for these functions by name.
fn develop_row(bytes: &mut [u8], colours: &[Vec3], development: &Development) {
    // Rows without a tone curve have code of their own, which compiles as if there were none.
    match (SimdLevel::best(), development.tone_curve) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `SimdLevel::best` returns only levels that the CPU has, and both of these have AVX2 and FMA.
        (SimdLevel::Avx2 | SimdLevel::Avx512, ToneCurve::None) => unsafe {
            develop_row_avx2(bytes, colours, development);
        },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `SimdLevel::best` returns only levels that the CPU has, and both of these have AVX2 and FMA.
        (SimdLevel::Avx2 | SimdLevel::Avx512, _) => unsafe {
            bent_row_avx2(bytes, colours, development);
        },
        (_, ToneCurve::None) => develop_row_with(bytes, colours, development),
        _ => bent_row_with(bytes, colours, development),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
unsafe fn develop_row_avx2(bytes: &mut [u8], colours: &[Vec3], development: &Development) {
    develop_row_with(bytes, colours, development);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
unsafe fn bent_row_avx2(bytes: &mut [u8], colours: &[Vec3], development: &Development) {
    bent_row_with(bytes, colours, development);
}

/// Takes no notice of the tone curve.
#[inline(always)]
fn develop_row_with(bytes: &mut [u8], colours: &[Vec3], development: &Development) {
    for (bytes, colours) in bytes.chunks_mut(3 * PIXELS).zip(colours.chunks(PIXELS)) {
        let mut values = channels(colours, development.gain);
        transferred(&mut values, development.transfer);
        write(bytes, &values);
    }
}

/// The same with the tone curve.
#[inline(always)]
fn bent_row_with(bytes: &mut [u8], colours: &[Vec3], development: &Development) {
    for (bytes, colours) in bytes.chunks_mut(3 * PIXELS).zip(colours.chunks(PIXELS)) {
        let mut values = channels(colours, development.gain);
        bend_all(development.tone_curve, &mut values);
        transferred(&mut values, development.transfer);
        write(bytes, &values);
    }
}

/// The channels of all pixels, pixel after pixel, times the gain.
#[inline(always)]
fn channels(colours: &[Vec3], gain: f32) -> [f32; 3 * PIXELS] {
    let mut values = [0.0; 3 * PIXELS];
    for (values, colour) in values.as_chunks_mut::<3>().0.iter_mut().zip(colours) {
        *values = exposed(*colour, gain);
    }
    values
}

#[inline(always)]
fn write(bytes: &mut [u8], values: &[f32; 3 * PIXELS]) {
    let mut developed = [0; 3 * PIXELS];
    for (byte, value) in developed.iter_mut().zip(values) {
        *byte = quantised(*value);
    }
    bytes.copy_from_slice(&developed[..bytes.len()]);
}

/// Applies a tone curve, to all pixels at once.
#[inline(always)]
fn bend_all(curve: ToneCurve, values: &mut [f32; 3 * PIXELS]) {
    let mut planes: Planes = [[0.0; PIXELS]; 3];
    for (pixel, colour) in values.as_chunks::<3>().0.iter().enumerate() {
        for (plane, value) in planes.iter_mut().zip(colour) {
            plane[pixel] = *value;
        }
    }
    bend(curve, &mut planes);
    for (pixel, colour) in values.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        *colour = [planes[0][pixel], planes[1][pixel], planes[2][pixel]];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_core::develop::developed;

    fn develop(linear: f32, settings: DevelopSettings) -> u8 {
        let film = Film { width: 1, height: 1, pixels: vec![Vec3::splat(linear)] };
        Developed::new(&film, &settings).rgb[0]
    }

    fn srgb(linear: f32) -> u8 {
        develop(linear, DevelopSettings::default())
    }

    fn linear(value: f32) -> u8 {
        develop(value, DevelopSettings { transfer: Transfer::Linear, ..DevelopSettings::default() })
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
        let stop =
            |exposure| DevelopSettings { exposure, transfer: Transfer::Linear, ..DevelopSettings::default() };
        assert_eq!(develop(0.25, stop(1.0)), linear(0.5));
        assert_eq!(develop(1.0, stop(-1.0)), linear(0.5));
        assert_eq!(develop(0.0, stop(f32::MAX)), 0, "0 times infinity is NaN");
    }

    const CURVES: [ToneCurve; 4] = [ToneCurve::None, ToneCurve::Aces, ToneCurve::Agx, ToneCurve::Neutral];

    /// Grey of 0.18, white, and light of 100, in bytes: sRGB of what core's `develop/tone_curve/truth.py` prints.
    #[test]
    fn tone_curves_come_before_the_transfer_curve() {
        let bytes = CURVES.map(|tone_curve| {
            let settings = DevelopSettings { tone_curve, ..DevelopSettings::default() };
            [0.0, 0.18, 1.0, 100.0].map(|light| develop(light, settings))
        });
        assert_eq!(bytes, [[0, 118, 255, 255], [0, 91, 206, 255], [0, 128, 202, 255], [0, 105, 240, 255]]);
    }

    /// A stop of exposure comes before the curve.
    #[test]
    fn curves_bend_what_is_exposed() {
        for tone_curve in CURVES {
            let stop = |exposure| DevelopSettings { exposure, tone_curve, ..DevelopSettings::default() };
            assert_eq!(develop(0.5, stop(1.0)), develop(1.0, stop(0.0)), "{tone_curve:?}");
        }
    }

    #[test]
    fn what_is_no_light_has_bytes_on_every_curve() {
        for tone_curve in CURVES {
            let bytes = |light| develop(light, DevelopSettings { tone_curve, ..DevelopSettings::default() });
            assert_eq!([f32::NAN, -1.0, f32::NEG_INFINITY, 0.0].map(bytes), [0; 4], "{tone_curve:?}");
            assert_eq!([f32::INFINITY, f32::MAX].map(bytes), [255; 2], "{tone_curve:?}");
        }
    }

    /// The bytes of the code for every CPU are those of the code for this one, for light of any size and of none.
    #[test]
    fn instructions_change_no_byte() {
        let mut bits = 1u32;
        let mut light = || {
            bits = bits.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            match bits >> 28 {
                0 => f32::from_bits(bits.rotate_left(9)),
                _ => exp2((bits >> 8) as f32 * (22.0 / (1 << 24) as f32) - 14.0),
            }
        };
        let colours: Vec<Vec3> = (0..20_011).map(|_| Vec3 { x: light(), y: light(), z: light() }).collect();
        for (tone_curve, transfer) in
            CURVES.into_iter().flat_map(|c| [(c, Transfer::Srgb), (c, Transfer::Linear)])
        {
            let settings = DevelopSettings { exposure: 0.5, tone_curve, transfer };
            let development = settings.development();
            let [mut plain, mut best] = [(); 2].map(|()| vec![0; colours.len() * 3]);
            match tone_curve {
                ToneCurve::None => develop_row_with(&mut plain, &colours, &development),
                _ => bent_row_with(&mut plain, &colours, &development),
            }
            develop_row(&mut best, &colours, &development);
            assert!(plain == best, "{settings:?}");
            // As devices do it, pixel by pixel.
            for (colour, bytes) in colours.iter().zip(best.as_chunks::<3>().0) {
                assert_eq!(developed(*colour, &development), *bytes, "{settings:?}");
            }
            // All shades are there.
            assert!((0..=255).all(|byte| best.contains(&byte)), "{settings:?}");
        }
    }

    #[test]
    fn an_empty_film_develops_to_nothing() {
        assert!(Developed::new(&Film::new(0, 7), &DevelopSettings::default()).rgb.is_empty());
    }
}
