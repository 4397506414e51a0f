//! Two pictures side by side.

use super::{CompareError, FirstDifference};
use crate::output::Picture;
use eosphor_core::math::Vec3;

/// Two pictures of one kind and size.
#[derive(Clone, Copy)]
pub(super) enum Pixels<'a> {
    /// Both, and the width.
    Bytes(&'a [[u8; 4]], &'a [[u8; 4]], usize),
    /// Both, and the width.
    Linear(&'a [Vec3], &'a [Vec3], usize),
}

impl<'a> Pixels<'a> {
    pub(super) fn of(a: &'a Picture, b: &'a Picture) -> Result<Pixels<'a>, CompareError> {
        if a.size() != b.size() {
            return Err(CompareError::Sizes { a: a.size(), b: b.size() });
        }
        let width = a.size().0 as usize;
        match (a, b) {
            (Picture::Bytes(a), Picture::Bytes(b)) => Ok(Pixels::Bytes(&a.rgba, &b.rgba, width)),
            (Picture::Linear(a), Picture::Linear(b)) => Ok(Pixels::Linear(&a.pixels, &b.pixels, width)),
            _ => Err(CompareError::Kinds),
        }
    }

    /// Whether all channels have the same bits.
    pub(super) fn same(self, x: usize, y: usize) -> bool {
        match self {
            Pixels::Bytes(a, b, width) => a[y * width + x] == b[y * width + x],
            Pixels::Linear(a, b, width) => {
                let bits = |p: &[_], i: usize| <[f32; 3]>::from(p[i]).map(f32::to_bits);
                bits(a, y * width + x) == bits(b, y * width + x)
            }
        }
    }

    /// The absolute differences of R, G and B of a pixel, never NaN.
    pub(super) fn differences(self, x: usize, y: usize) -> [f64; 3] {
        match self {
            Pixels::Bytes(a, b, width) => {
                let (a, b) = (a[y * width + x], b[y * width + x]);
                [0, 1, 2].map(|k| a[k].abs_diff(b[k]) as f64)
            }
            Pixels::Linear(a, b, width) => {
                let (a, b) = (a[y * width + x], b[y * width + x]);
                [0, 1, 2].map(|k| float_difference(a[k], b[k]))
            }
        }
    }

    pub(super) fn alpha_difference(self, x: usize, y: usize) -> Option<f64> {
        match self {
            Pixels::Bytes(a, b, width) => Some(a[y * width + x][3].abs_diff(b[y * width + x][3]) as f64),
            Pixels::Linear(..) => None,
        }
    }

    /// The pixel, for a message.
    pub(super) fn first(self, x: usize, y: usize) -> FirstDifference {
        let (a, b) = match self {
            Pixels::Bytes(a, b, width) => {
                let (a, b) = (a[y * width + x], b[y * width + x]);
                // Most files have no alpha: it is shown where it says something.
                let channels = if a[3] == b[3] { 3 } else { 4 };
                let values = |p: [u8; 4]| p[..channels].iter().map(|&v| v as f32).collect();
                (values(a), values(b))
            }
            Pixels::Linear(a, b, width) => {
                let values = |p: &[_]| <[f32; 3]>::from(p[y * width + x]).to_vec();
                (values(a), values(b))
            }
        };
        FirstDifference { x: x as u32, y: y as u32, a, b }
    }
}

/// 0 for the same bits, and infinite where a number meets NaN or infinity.
fn float_difference(a: f32, b: f32) -> f64 {
    let difference = (a as f64 - b as f64).abs();
    match difference.is_nan() {
        _ if a.to_bits() == b.to_bits() => 0.0,
        true => f64::INFINITY,
        false => difference,
    }
}
