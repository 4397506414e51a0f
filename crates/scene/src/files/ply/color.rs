//! Colours of vertices: display values, coded by sRGB, become linear.

use super::scalar::Scalar;
use eosphor_core::math::elementary64::srgb_to_linear;
use std::sync::LazyLock;

/// The linear value of each byte.
static OF_BYTE: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| srgb_to_linear(byte as f64 / 255.0) as f32));

/// The linear value of a colour code. What is no number is left as it is, for the caller to notice.
pub(super) fn linear(scalar: Scalar, code: f32) -> f32 {
    match scalar {
        Scalar::U8 => OF_BYTE[code as u8 as usize],
        _ if code.is_nan() => code,
        _ => srgb_to_linear(share(scalar, code)) as f32,
    }
}

/// Opacity is linear as it is.
pub(super) fn opacity(scalar: Scalar, code: f32) -> f32 {
    if code.is_nan() { code } else { share(scalar, code) as f32 }
}

/// A code as a share of the largest: 255 for bytes and for wider types that hold bytes, 65,535 for `ushort`, 1 for
/// floats. Codes beyond are cut.
fn share(scalar: Scalar, code: f32) -> f64 {
    let most = match scalar {
        Scalar::F32 | Scalar::F64 => 1.0,
        Scalar::U16 => 65_535.0,
        _ => 255.0,
    };
    (f64::from(code) / most).clamp(0.0, 1.0)
}
