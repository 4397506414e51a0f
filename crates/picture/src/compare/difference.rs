//! Differences pixel by pixel.

use super::flip::mean_flip;
use super::pixels::Pixels;
use crate::output::{Developed, Picture};
use rayon::prelude::*;
use serde::Serialize;

/// How two pictures compare. Units: bytes (0 to 255) for PNG, PPM, JPEG and `.data`, linear values for EXR and HDR.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Every channel of every pixel has the same bits.
    pub identical: bool,
    /// Width of both pictures in pixels.
    pub width: u32,
    /// Height of both pictures in pixels.
    pub height: u32,
    /// The first pixel that differs, row after row from the top.
    pub first: Option<FirstDifference>,
    /// How many pixels differ.
    pub differing_pixels: u64,
    /// The largest difference of a channel; infinite where a number meets NaN or infinity.
    pub max_difference: f64,
    /// Root of the mean squared difference over R, G and B of all pixels; alpha is left out.
    pub rmse: f64,
    /// Peak signal-to-noise ratio in decibels, peak 255 or 1; infinite (`null` in JSON) for equal values.
    pub psnr: f64,
    /// Mean FLIP error, 0 to 1, both seen as sRGB on a screen at 67 pixels a degree; `None` over 67 million pixels.
    pub flip: Option<f64>,
}

/// The first pixel that differs, row after row from the top left, and its colours in both pictures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FirstDifference {
    /// Column, from the left.
    pub x: u32,
    /// Row, from the top.
    pub y: u32,
    /// The channels in the first picture.
    pub a: Vec<f32>,
    /// The channels in the second.
    pub b: Vec<f32>,
}

/// Why two pictures cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// The pictures have different sizes.
    #[error("the pictures have different sizes, {} x {} and {} x {}", a.0, a.1, b.0, b.1)]
    Sizes {
        /// Width and height of the first.
        a: (u32, u32),
        /// Width and height of the second.
        b: (u32, u32),
    },
    /// One holds bytes, the other linear floats.
    #[error("one picture holds bytes and the other linear floats; compare two of the same kind")]
    Kinds,
}

/// Compares two pictures bit by bit.
pub fn compare(a: &Picture, b: &Picture) -> Result<Comparison, CompareError> {
    let rows = differences(a, b)?;
    let (width, height) = a.size();
    let peak = match a {
        Picture::Bytes(_) => 255.0,
        Picture::Linear(_) => 1.0f64,
    };
    // In one order, so that the last digit is always the same.
    let sum: f64 = rows.iter().map(|row| row.squares).sum();
    let rmse = (sum / (width as f64 * height as f64 * 3.0)).sqrt();
    let differing_pixels = rows.iter().map(|row| row.pixels).sum();
    Ok(Comparison {
        identical: differing_pixels == 0,
        width,
        height,
        first: rows.iter().find_map(|row| row.first.clone()),
        differing_pixels,
        max_difference: rows.iter().map(|row| row.max).fold(0.0, f64::max),
        rmse,
        psnr: 20.0 * (peak / rmse).log10(),
        flip: if differing_pixels == 0 { Some(0.0) } else { mean_flip(a, b) },
    })
}

/// The absolute difference of R, G and B, amplified so that the largest is white; also the factor. Alpha is left out.
pub fn difference_image(a: &Picture, b: &Picture) -> Result<(Developed, f64), CompareError> {
    let pixels = Pixels::of(a, b)?;
    let (width, height) = a.size();
    let rows = (0..height as usize).into_par_iter();
    let row_max = |y| (0..width as usize).flat_map(|x| pixels.differences(x, y)).fold(0.0, finite_max);
    let max = rows.clone().map(row_max).reduce(|| 0.0, f64::max);
    let factor = if max > 0.0 { 255.0 / max } else { 0.0 };
    let byte = |difference: f64| (difference * factor + 0.5).min(255.0) as u8;
    let row =
        |y| (0..width as usize).flat_map(move |x| pixels.differences(x, y)).map(byte).collect::<Vec<_>>();
    let rgb = rows.flat_map_iter(row).collect();
    let scale = if let Picture::Linear(_) = a { factor / 255.0 } else { factor };
    Ok((Developed { width, height, rgb, alpha: Vec::new() }, scale))
}

fn finite_max(max: f64, x: f64) -> f64 {
    if x.is_finite() { max.max(x) } else { max }
}

/// What differs in one row.
struct RowDifference {
    pixels: u64,
    max: f64,
    squares: f64,
    first: Option<FirstDifference>,
}

fn differences(a: &Picture, b: &Picture) -> Result<Vec<RowDifference>, CompareError> {
    let pixels = Pixels::of(a, b)?;
    let (width, height) = a.size();
    let row = |y: usize| {
        let mut row = RowDifference { pixels: 0, max: 0.0, squares: 0.0, first: None };
        for x in (0..width as usize).filter(|&x| !pixels.same(x, y)) {
            row.pixels += 1;
            let rgb = pixels.differences(x, y);
            row.squares += rgb.iter().map(|d| d * d).sum::<f64>();
            row.max = rgb.into_iter().chain(pixels.alpha_difference(x, y)).fold(row.max, f64::max);
            row.first.get_or_insert_with(|| pixels.first(x, y));
        }
        row
    };
    Ok((0..height as usize).into_par_iter().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::ByteImage;
    use eosphor_core::math::{Vec3, vec3};
    use eosphor_render::Film;

    fn grey(width: u32, height: u32, value: u8) -> ByteImage {
        let rgba = vec![[value, value, value, 255]; (width * height) as usize];
        ByteImage { width, height, rgba }
    }

    #[test]
    fn equal_pictures_are_identical() {
        let picture = Picture::Bytes(grey(9, 4, 77));
        let c = compare(&picture, &picture).unwrap();
        assert!(c.identical && c.first.is_none());
        assert_eq!((c.differing_pixels, c.max_difference, c.rmse, c.flip), (0, 0.0, 0.0, Some(0.0)));
        assert_eq!(c.psnr, f64::INFINITY);
    }

    #[test]
    fn one_pixel_is_found_and_measured() {
        let a = grey(10, 10, 100);
        let mut b = a.clone();
        b.rgba[42] = [100, 110, 100, 255];
        let c = compare(&Picture::Bytes(a), &Picture::Bytes(b)).unwrap();
        let first = c.first.unwrap();
        assert_eq!((first.x, first.y), (2, 4));
        assert_eq!((first.a, first.b), (vec![100.0; 3], vec![100.0, 110.0, 100.0]));
        assert_eq!((c.identical, c.differing_pixels, c.max_difference), (false, 1, 10.0));
        // 10^2 over 300 channels.
        assert_eq!(c.rmse, (1.0f64 / 3.0).sqrt());
        assert!((c.psnr - 10.0 * (255.0 * 255.0 * 3.0f64).log10()).abs() < 1e-12);
        assert!(c.flip.unwrap() > 0.0);
    }

    #[test]
    fn black_and_white_are_as_different_as_can_be() {
        let c = compare(&Picture::Bytes(grey(32, 32, 0)), &Picture::Bytes(grey(32, 32, 255))).unwrap();
        assert_eq!((c.differing_pixels, c.max_difference), (1024, 255.0));
        assert!(c.flip.unwrap() > 0.9, "{:?}", c.flip);
    }

    #[test]
    fn floats_are_compared_by_their_bits() {
        let film = |v: f32| Picture::Linear(Film { width: 1, height: 1, pixels: vec![Vec3::splat(v)] });
        let c = compare(&film(0.0), &film(-0.0)).unwrap();
        assert_eq!((c.identical, c.max_difference, c.rmse), (false, 0.0, 0.0));
        assert!(compare(&film(f32::NAN), &film(f32::NAN)).unwrap().identical);
        let c = compare(&film(f32::NAN), &film(1.0)).unwrap();
        assert_eq!((c.max_difference, c.rmse), (f64::INFINITY, f64::INFINITY));
    }

    #[test]
    fn unlike_pictures_are_refused() {
        let (a, b) = (Picture::Bytes(grey(2, 3, 0)), Picture::Bytes(grey(3, 2, 0)));
        let error = compare(&a, &b).unwrap_err();
        assert_eq!(error.to_string(), "the pictures have different sizes, 2 x 3 and 3 x 2");
        let c = Picture::Linear(Film::new(2, 3));
        assert_eq!(compare(&a, &c), Err(CompareError::Kinds));
    }

    #[test]
    fn the_largest_difference_is_white() {
        let a = grey(2, 1, 10);
        let mut b = a.clone();
        b.rgba[1] = [12, 11, 10, 255];
        let (image, factor) = difference_image(&Picture::Bytes(a), &Picture::Bytes(b)).unwrap();
        assert_eq!(image.rgb, [0, 0, 0, 255, 128, 0]);
        assert_eq!(factor, 127.5);
        let film = |v| Picture::Linear(Film { width: 1, height: 1, pixels: vec![v] });
        let (image, _) = difference_image(&film(Vec3::ZERO), &film(vec3(0.5, f32::NAN, 0.0))).unwrap();
        assert_eq!(image.rgb, [255, 255, 0]);
    }
}
