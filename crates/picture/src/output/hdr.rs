//! Radiance HDR: linear colours with a shared exponent (RGBE, Ward 1991), in run lengths.

use super::destination::Destination;
use super::encoder::LinearEncoder;
use super::metadata::{SOFTWARE, completeness};
use eosphor_core::math::{Vec3, vec3};
use eosphor_render::{FeatureRows, Film};
use eosphor_scene::read_hdr;
use rayon::prelude::*;
use std::io::{Error, Write};

/// The header up to the word that says whether the picture is complete.
const BEGIN: &str = "#?RADIANCE\n# ";

/// Widths that run lengths are defined for; other rows are written plain.
const RUN_LENGTH_WIDTHS: std::ops::Range<usize> = 8..32_768;

/// Shorter runs cost more than they save.
const SHORTEST_RUN: usize = 4;

/// Rows that are encoded before any is written.
const ROWS_AT_ONCE: usize = 64;

/// Encodes rows as they come.
pub(super) struct HdrEncoder {
    file: Destination,
}

impl HdrEncoder {
    pub(super) fn new(mut file: Destination, width: u32, height: u32) -> Result<HdrEncoder, Error> {
        let complete = completeness(true);
        writeln!(file, "{BEGIN}{complete}\nSOFTWARE={SOFTWARE}\nFORMAT=32-bit_rle_rgbe\n")?;
        writeln!(file, "-Y {height} +X {width}")?;
        Ok(HdrEncoder { file })
    }
}

impl LinearEncoder for HdrEncoder {
    fn rows(&mut self, film: &Film, _features: Option<&FeatureRows>) -> Result<(), Error> {
        let width = film.width as usize;
        for rows in film.pixels.chunks(width * ROWS_AT_ONCE) {
            let encoded: Vec<Vec<u8>> = rows.par_chunks(width).map(encode_row).collect();
            encoded.iter().try_for_each(|row| self.file.write_all(row))?;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>, complete: bool) -> Result<(), Error> {
        self.file.patch(BEGIN.len() as u64, completeness(complete).as_bytes())
    }
}

fn encode_row(colours: &[Vec3]) -> Vec<u8> {
    let pixels: Vec<[u8; 4]> = colours.iter().map(|&colour| rgbe(colour)).collect();
    if !RUN_LENGTH_WIDTHS.contains(&pixels.len()) {
        return pixels.concat();
    }
    let [high, low] = (pixels.len() as u16).to_be_bytes();
    let mut row = vec![2, 2, high, low];
    for component in 0..4 {
        let bytes: Vec<u8> = pixels.iter().map(|pixel| pixel[component]).collect();
        run_lengths(&bytes, &mut row);
    }
    row
}

/// Runs of up to 127 bytes as 128 + length and the byte; what is between them as its length, up to 128, and the bytes.
fn run_lengths(bytes: &[u8], out: &mut Vec<u8>) {
    let mut rest = bytes;
    while !rest.is_empty() {
        let mut plain = 0;
        let mut run = 0;
        while plain < rest.len() {
            run = rest[plain..].iter().take(127).take_while(|&&byte| byte == rest[plain]).count();
            if run >= SHORTEST_RUN {
                break;
            }
            plain += run;
            run = 0;
        }
        for literal in rest[..plain].chunks(128) {
            out.push(literal.len() as u8);
            out.extend_from_slice(literal);
        }
        if run > 0 {
            out.extend_from_slice(&[128 + run as u8, rest[plain]]);
        }
        rest = &rest[plain + run..];
    }
}

/// Mantissas of 8 bits for an exponent of all three: m · 2^(e − 136). Rounded to the nearest, so off by at most 1/256 of
/// the largest component. Negative values and NaN become 0; values over 2^127 the largest there is. The exponent is taken
/// from the bits: no maths library has a say.
fn rgbe(colour: Vec3) -> [u8; 4] {
    const LARGEST: f32 = f32::from_bits(0x7eff_0000); // 255 · 2^119
    let clamp = |x: f32| if x > 0.0 { x.min(LARGEST) } else { 0.0 };
    let [r, g, b] = [clamp(colour.x), clamp(colour.y), clamp(colour.z)];
    let largest = r.max(g).max(b);
    // Its power of two: 2^(exponent - 127) <= largest, but for subnormal numbers.
    let mut exponent = (largest.to_bits() >> 23) as i32;
    if exponent == 0 {
        return [0; 4];
    }
    let scaled = |x: f32, exponent: i32| {
        // x · 2^(127 + 7 - exponent), in two steps: the power alone may be out of range.
        let half = |power: i32| f32::from_bits(((127 + power) as u32) << 23);
        let power = 134 - exponent;
        (x * half(power / 2) * half(power - power / 2) + 0.5).floor()
    };
    if scaled(largest, exponent) > 255.0 {
        exponent += 1;
    }
    let [r, g, b] = [r, g, b].map(|x| scaled(x, exponent) as u8);
    // 128..255 · 2^(e - 136) is 2^(exponent - 127) .. 2^(exponent - 126).
    [r, g, b, (exponent + 2) as u8]
}

/// The pixels of an HDR file as a film.
pub(super) fn read(bytes: &[u8]) -> Result<Film, String> {
    let picture = read_hdr(bytes)?;
    let pixels = picture.pixels.into_iter().map(colour).collect();
    Ok(Film { width: picture.width, height: picture.height, pixels })
}

/// m · 2^(e − 136) of each mantissa, exactly.
fn colour([r, g, b, e]: [u8; 4]) -> Vec3 {
    // A power of two of double precision: none of an f32 is so small.
    let scale = if e == 0 { 0.0 } else { f64::from_bits((1023 - 136 + u64::from(e)) << 52) };
    let channel = |m: u8| (f64::from(m) * scale) as f32;
    vec3(channel(r), channel(g), channel(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mantissas_become_the_numbers_that_they_mean() {
        for e in 0..=255 {
            for m in [0, 1, 127, 128, 255] {
                let read = <[f32; 3]>::from(colour([m, 0, m, e]));
                let [expected, ..] = decoded([m, 0, m, e]);
                assert_eq!(read.map(f64::from), [expected, 0.0, expected], "{m} {e}");
            }
        }
    }

    fn decoded([r, g, b, e]: [u8; 4]) -> [f64; 3] {
        [r, g, b].map(|m| if e == 0 { 0.0 } else { m as f64 * 2f64.powi(e as i32 - 136) })
    }

    #[test]
    fn mantissas_are_the_nearest() {
        assert_eq!(rgbe(Vec3::ONE), [128, 128, 128, 129]);
        assert_eq!(rgbe(vec3(1.0, 0.5, 0.25)), [128, 64, 32, 129]);
        assert_eq!(rgbe(vec3(255.0, 0.49, 0.5)), [255, 0, 1, 136]);
        assert_eq!(rgbe(Vec3::splat(255.75)), [128, 128, 128, 137], "rounding reaches the next power");
        assert_eq!(rgbe(vec3(f32::NAN, -3.0, 0.0)), [0; 4]);
        assert_eq!(rgbe(vec3(f32::INFINITY, f32::MAX, 0.0)), [255, 255, 0, 255]);
        assert_eq!(rgbe(Vec3::splat(f32::MIN_POSITIVE)), [128, 128, 128, 3]);
        assert_eq!(rgbe(Vec3::splat(f32::MIN_POSITIVE / 2.0)), [0; 4]);
        let mut value = 1e-30f32;
        while value < 1e37 {
            let colour = vec3(value, value * 0.3, value * 0.001);
            for (x, back) in <[f32; 3]>::from(colour).into_iter().zip(decoded(rgbe(colour))) {
                assert!((x as f64 - back).abs() <= value as f64 / 255.0, "{colour:?}");
            }
            value *= 1.37;
        }
    }

    #[test]
    fn runs_and_what_is_between_them() {
        let encode = |bytes: &[u8]| {
            let mut out = Vec::new();
            run_lengths(bytes, &mut out);
            out
        };
        assert_eq!(encode(&[7; 9]), [137, 7]);
        assert_eq!(encode(&[7; 130]), [255, 7, 3, 7, 7, 7]);
        assert_eq!(encode(&[1, 2, 2, 3, 9, 9, 9, 9]), [4, 1, 2, 2, 3, 132, 9]);
        let noise: Vec<u8> = (0..200).collect();
        assert_eq!(encode(&noise).len(), 202);
    }
}
