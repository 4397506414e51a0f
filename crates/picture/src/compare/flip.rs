//! FLIP: how different two pictures look when one flips between them, after Andersson, Nilsson, Akenine-Möller, Oskarsson,
//! Åström and Fairchild 2020, "FLIP: A Difference Evaluator for Alternating Images". The constants are the paper's; its
//! authors' program is the oracle of the tests.

use crate::output::{DevelopSettings, Developed, Picture};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Some twenty floats are held a pixel: larger pictures go without.
const MAX_PIXELS: u64 = 1 << 26;

/// Pixels per degree of a screen of 3,840 pixels and 0.7 m that is seen from 0.7 m.
const PIXELS_PER_DEGREE: f32 = 3840.0 * PI / 180.0;

/// Exponents and limits of the colour pipeline: q_c, p_c, p_t; and of features: their width in degrees, and q_f.
const COLOR_EXPONENT: f32 = 0.7;
const COLOR_KNEE: f32 = 0.4;
const ERROR_AT_KNEE: f32 = 0.95;
const FEATURE_WIDTH_DEGREES: f32 = 0.082;
const FEATURE_EXPONENT: f32 = 0.5;

/// D65, the white of sRGB.
const WHITE: [f32; 3] = [0.950_428_5, 1.0, 1.088_900_3];

/// Contrast sensitivity of the three channels: sums of two Gaussians, an amplitude and a width each.
const SENSITIVITY: [[(f32, f32); 2]; 3] =
    [[(1.0, 0.0047), (0.0, 1e-5)], [(1.0, 0.0053), (0.0, 1e-5)], [(34.1, 0.04), (13.5, 0.025)]];

/// The mean error, 0 (equal to the eye) to 1, of two pictures of equal size; `None` where they are too large.
pub(super) fn mean_flip(reference: &Picture, test: &Picture) -> Option<f64> {
    let (width, height) = reference.size();
    if width as u64 * height as u64 > MAX_PIXELS {
        return None;
    }
    let size = [width as usize, height as usize];
    Some(mean_of_bytes(size, &rgb(reference), &rgb(test)))
}

/// sRGB bytes, as a screen would show them.
fn rgb(picture: &Picture) -> Vec<u8> {
    match picture {
        Picture::Bytes(image) => image.rgba.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect(),
        Picture::Linear(film) => Developed::new(film, &DevelopSettings::default()).rgb,
    }
}

/// The mean error of sRGB pictures, three bytes a pixel.
fn mean_of_bytes(size: [usize; 2], reference: &[u8], test: &[u8]) -> f64 {
    let (a, b) = (Seen::new(size, reference), Seen::new(size, test));
    let largest = hyab(hunt(lab([0.0, 1.0, 0.0])), hunt(lab([0.0, 0.0, 1.0]))).powf(COLOR_EXPONENT);
    let knee = COLOR_KNEE * largest;
    let error = |k: usize| {
        let distance = hyab(a.colors[k], b.colors[k]).powf(COLOR_EXPONENT);
        let color = match distance < knee {
            true => distance * ERROR_AT_KNEE / knee,
            false => ERROR_AT_KNEE + (distance - knee) / (largest - knee) * (1.0 - ERROR_AT_KNEE),
        };
        let edges = (a.features[k][0] - b.features[k][0]).abs();
        let points = (a.features[k][1] - b.features[k][1]).abs();
        let feature = (edges.max(points) / 2f32.sqrt()).powf(FEATURE_EXPONENT);
        f64::from(color.powf(1.0 - feature))
    };
    // Row by row, so that the sum does not depend on threads.
    let [width, height] = size;
    let rows: Vec<f64> =
        (0..height).into_par_iter().map(|y| (y * width..(y + 1) * width).map(error).sum()).collect();
    rows.iter().sum::<f64>() / (width * height) as f64
}

/// A picture as it is seen.
struct Seen {
    /// CIELAB after the filters of contrast sensitivity, a and b adjusted for the Hunt effect.
    colors: Vec<[f32; 3]>,
    /// How strong edges and points are.
    features: Vec<[f32; 2]>,
}

impl Seen {
    fn new(size: [usize; 2], srgb: &[u8]) -> Seen {
        let table: Vec<f32> = (0..=255u8).map(linear).collect();
        let channel = |of: fn([f32; 3]) -> f32| -> Vec<f32> {
            let pixels = srgb.par_chunks_exact(3);
            pixels.map(|p| of([0, 1, 2].map(|k| table[p[k] as usize]))).collect()
        };
        let luma = channel(|rgb| opponent(rgb)[0]);
        let features = features(size, &luma);
        let filtered = [
            filter(size, &luma, &SENSITIVITY[0]),
            filter(size, &channel(|rgb| opponent(rgb)[1]), &SENSITIVITY[1]),
            filter(size, &channel(|rgb| opponent(rgb)[2]), &SENSITIVITY[2]),
        ];
        let color = |k: usize| hunt(lab(from_opponent([filtered[0][k], filtered[1][k], filtered[2][k]])));
        Seen { colors: (0..luma.len()).into_par_iter().map(color).collect(), features }
    }
}

/// sRGB's transfer curve.
fn linear(byte: u8) -> f32 {
    let x = f32::from(byte) / 255.0;
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// CIE XYZ of linear sRGB, and back.
fn xyz([r, g, b]: [f32; 3]) -> [f32; 3] {
    [
        10_135_552.0 / 24_577_794.0 * r + 8_788_810.0 / 24_577_794.0 * g + 4_435_075.0 / 24_577_794.0 * b,
        2_613_072.0 / 12_288_897.0 * r + 8_788_810.0 / 12_288_897.0 * g + 887_015.0 / 12_288_897.0 * b,
        1_425_312.0 / 73_733_382.0 * r + 8_788_810.0 / 73_733_382.0 * g + 70_074_185.0 / 73_733_382.0 * b,
    ]
}

fn rgb_of_xyz([x, y, z]: [f32; 3]) -> [f32; 3] {
    [
        3.241_003_2 * x - 1.537_399 * y - 0.498_615_9 * z,
        -0.969_224_3 * x + 1.875_93 * y + 0.041_554_23 * z,
        0.055_639_42 * x - 0.204_011_2 * y + 1.057_149 * z,
    ]
}

/// YCxCz, a linear space of opponent colours.
fn opponent(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = [0, 1, 2].map(|k| xyz(rgb)[k] / WHITE[k]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Linear sRGB of YCxCz, within what a screen shows.
fn from_opponent([luma, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (luma + 16.0) / 116.0;
    let white = [y + cx / 500.0, y, y - cz / 200.0];
    rgb_of_xyz([0, 1, 2].map(|k| white[k] * WHITE[k])).map(|x| x.clamp(0.0, 1.0))
}

/// CIELAB of linear sRGB.
fn lab(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let curve = |x: f32| match x > DELTA * DELTA * DELTA {
        true => x.cbrt(),
        false => x / (3.0 * DELTA * DELTA) + 4.0 / 29.0,
    };
    let [x, y, z] = [0, 1, 2].map(|k| curve(xyz(rgb)[k] / WHITE[k]));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Colours differ less where it is dark.
fn hunt([lightness, a, b]: [f32; 3]) -> [f32; 3] {
    [lightness, 0.01 * lightness * a, 0.01 * lightness * b]
}

/// The HyAB distance (Abasi et al. 2020).
fn hyab(x: [f32; 3], y: [f32; 3]) -> f32 {
    (x[0] - y[0]).abs() + (x[1] - y[1]).hypot(x[2] - y[2])
}

/// A channel filtered by a sum of Gaussians, each of which is separable, and of which the whole has the sum 1.
fn filter(size: [usize; 2], channel: &[f32], gaussians: &[(f32, f32); 2]) -> Vec<f32> {
    // The widest has a standard deviation of sqrt(0.04 / (2 pi^2)) degrees.
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as usize;
    let kernel = |width: f32| -> Vec<f32> {
        let at = |k: usize| (k as f32 - radius as f32) / PIXELS_PER_DEGREE;
        (0..=2 * radius).map(|k| (-PI * PI * at(k) * at(k) / width).exp()).collect()
    };
    let used: Vec<(f32, Vec<f32>)> = gaussians
        .iter()
        .filter(|(amplitude, _)| *amplitude != 0.0)
        .map(|&(amplitude, width)| (amplitude * (PI / width).sqrt(), kernel(width)))
        .collect();
    let sum: f32 = used.iter().map(|(weight, kernel)| weight * kernel.iter().sum::<f32>().powi(2)).sum();
    let mut filtered = vec![0.0; channel.len()];
    for (weight, kernel) in &used {
        let across = convolve(size, channel, kernel, Axis::X);
        let both = convolve(size, &across, kernel, Axis::Y);
        filtered.par_iter_mut().zip(both).for_each(|(sum_of, x)| *sum_of += weight / sum * x);
    }
    filtered
}

/// How strong edges and points are at each pixel, of a Y channel from -16 to 100.
fn features(size: [usize; 2], luma: &[f32]) -> Vec<[f32; 2]> {
    let deviation = 0.5 * FEATURE_WIDTH_DEGREES * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let kernel = |of: &dyn Fn(f32) -> f32| -> Vec<f32> {
        let gaussian = |x: f32| (-x * x / (2.0 * deviation * deviation)).exp();
        (-radius..=radius).map(|x| of(x as f32) * gaussian(x as f32)).collect()
    };
    let smooth = kernel(&|_| 1.0);
    let smooth = scaled(&smooth, 1.0 / smooth.iter().sum::<f32>());
    // What is above 0 and what is below add up to 1 and -1.
    let balanced = |kernel: Vec<f32>| -> Vec<f32> {
        let above: f32 = kernel.iter().filter(|x| **x > 0.0).sum();
        let below: f32 = kernel.iter().filter(|x| **x < 0.0).sum();
        kernel.iter().map(|x| if *x > 0.0 { x / above } else { -x / below }).collect()
    };
    let edge = balanced(kernel(&|x| -x));
    let point = balanced(kernel(&|x| x * x / (deviation * deviation) - 1.0));
    let normalized: Vec<f32> = luma.iter().map(|y| (y + 16.0) / 116.0).collect();
    let strength = |derivative: &[f32]| -> Vec<f32> {
        let x = convolve(size, &convolve(size, &normalized, &smooth, Axis::Y), derivative, Axis::X);
        let y = convolve(size, &convolve(size, &normalized, &smooth, Axis::X), derivative, Axis::Y);
        x.iter().zip(y).map(|(x, y)| x.hypot(y)).collect()
    };
    strength(&edge).into_iter().zip(strength(&point)).map(|(edge, point)| [edge, point]).collect()
}

fn scaled(kernel: &[f32], by: f32) -> Vec<f32> {
    kernel.iter().map(|x| x * by).collect()
}

#[derive(Clone, Copy)]
enum Axis {
    X,
    Y,
}

/// A channel and a kernel of odd length; beyond its sides a picture goes on as at them.
fn convolve([width, height]: [usize; 2], channel: &[f32], kernel: &[f32], axis: Axis) -> Vec<f32> {
    let radius = kernel.len() / 2;
    let mut out = vec![0.0f32; channel.len()];
    out.par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
        for (k, weight) in kernel.iter().enumerate() {
            match axis {
                Axis::X => {
                    let from = &channel[y * width..][..width];
                    for (x, sum) in row.iter_mut().enumerate() {
                        *sum += weight * from[(x + k).saturating_sub(radius).min(width - 1)];
                    }
                }
                Axis::Y => {
                    let at = (y + k).saturating_sub(radius).min(height - 1);
                    for (sum, value) in row.iter_mut().zip(&channel[at * width..][..width]) {
                        *sum += weight * value;
                    }
                }
            }
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::mean_of_bytes;
    use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool, flip};

    /// The authors' program.
    fn oracle([width, height]: [usize; 2], reference: &[u8], test: &[u8]) -> f64 {
        let image = |bytes| FlipImageRgb8::with_data(width as u32, height as u32, bytes);
        let errors = flip(image(reference), image(test), DEFAULT_PIXELS_PER_DEGREE);
        f64::from(FlipPool::from_image(&errors).mean())
    }

    /// Waves of several lengths, with noise: every pixel has another colour.
    fn picture([width, height]: [usize; 2], seed: u32, noise: f32) -> Vec<u8> {
        let mut state = seed.wrapping_mul(2_654_435_761) | 1;
        let mut bytes = Vec::new();
        for y in 0..height {
            for x in 0..width {
                for c in 0..3 {
                    state ^= state << 13;
                    state ^= state >> 17;
                    state ^= state << 5;
                    let wave =
                        ((x * (c + 1)) as f32 * 0.13).sin() * ((y * 2) as f32 * 0.07 + seed as f32).cos();
                    let random = state as f32 / u32::MAX as f32 - 0.5;
                    bytes.push((127.5 + 100.0 * wave + 255.0 * noise * random).clamp(0.0, 255.0) as u8);
                }
            }
        }
        bytes
    }

    #[test]
    fn errors_are_those_of_the_authors_program() {
        for size in [[1, 1], [7, 5], [64, 48], [130, 97]] {
            for (a, b) in [((1, 0.0), (1, 0.05)), ((1, 0.02), (1, 0.5)), ((1, 0.1), (2, 0.1))] {
                let (a, b) = (picture(size, a.0, a.1), picture(size, b.0, b.1));
                let (ours, theirs) = (mean_of_bytes(size, &a, &b), oracle(size, &a, &b));
                assert!(
                    (ours - theirs).abs() < 1e-3 * theirs.max(0.01),
                    "{size:?}: {ours} instead of {theirs}"
                );
            }
        }
    }

    #[test]
    fn black_and_white_are_as_different_as_can_be() {
        let size = [16, 16];
        assert_eq!(mean_of_bytes(size, &[0; 768], &[0; 768]), 0.0);
        let error = mean_of_bytes(size, &[0; 768], &[255; 768]);
        assert!((0.95..=1.0).contains(&error), "{error}");
    }
}
