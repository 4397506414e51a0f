//! FLIP: how different two pictures look when one flips between them (Andersson et al. 2020).

use crate::output::{DevelopSettings, Developed, Picture};
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool, flip};

/// FLIP holds about twenty floats a pixel, and its sizes are 32-bit numbers: larger pictures go without.
const MAX_PIXELS: u64 = 1 << 26;

/// The mean error, 0 (equal to the eye) to 1, of two pictures of equal size; `None` where they are too large.
pub(super) fn mean_flip(reference: &Picture, test: &Picture) -> Option<f64> {
    let (width, height) = reference.size();
    if width as u64 * height as u64 > MAX_PIXELS {
        return None;
    }
    let image = |picture| FlipImageRgb8::with_data(width, height, &rgb(picture));
    let errors = flip(image(reference), image(test), DEFAULT_PIXELS_PER_DEGREE);
    Some(FlipPool::from_image(&errors).mean() as f64)
}

/// sRGB bytes, as a screen would show them.
fn rgb(picture: &Picture) -> Vec<u8> {
    match picture {
        Picture::Bytes(image) => image.rgba.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect(),
        Picture::Linear(film) => Developed::new(film, &DevelopSettings::default()).rgb,
    }
}
