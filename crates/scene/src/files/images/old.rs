//! BMP and TGA, by the `image` crate; whether a file can hold what it claims is asked here first.

use super::{Header, Picture, broken_picture, limits};
use crate::model::Texels;
use image::codecs::{bmp::BmpDecoder, tga::TgaDecoder};
use image::{DynamicImage, ImageDecoder};
use std::io::Cursor;

const CUT_SHORT: &str = "the file is cut short; get it again";

pub(super) fn bmp_header(bytes: &[u8]) -> Result<Header, String> {
    let word = |at: usize| {
        bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).ok_or(CUT_SHORT)
    };
    let half = |at: usize| word(at).map(|w| w & 0xffff);
    // The oldest header is 12 bytes long, has sides of 16 bits and knows no compression.
    let (width, height, bits, compression) = match word(14)? {
        12 => (half(18)?, half(20)?, half(24)?, 0),
        _ => (word(18)?, (word(22)? as i32).unsigned_abs(), half(28)?, word(30)?),
    };
    let header = limits::size(width.into(), height.into(), limits::RGBA8)?;
    let row = u64::from(width);
    match compression {
        // Run lengths: two bytes for 255 texels.
        1 | 2 => limits::holds(row * u64::from(height), 128, bytes.len())?,
        _ => limits::holds((row * u64::from(bits)).div_ceil(8) * u64::from(height), 1, bytes.len())?,
    }
    Ok(header)
}

pub(super) fn decode_bmp(bytes: &[u8]) -> Result<Picture, String> {
    let header = bmp_header(bytes)?;
    decoded("BMP", &header, BmpDecoder::new(Cursor::new(bytes)))
}

pub(super) fn tga_header(bytes: &[u8]) -> Result<Header, String> {
    let Some(header) = bytes.first_chunk::<18>() else { return Err(CUT_SHORT.into()) };
    let side = |at: usize| u64::from(header[at]) | u64::from(header[at + 1]) << 8;
    let size = limits::size(side(12), side(14), limits::RGBA8)?;
    let texels = side(12) * side(14);
    match header[2] {
        // Run lengths: a byte and a texel for 128 texels.
        9..=11 => limits::holds(texels, 128, bytes.len())?,
        _ => limits::holds(texels * u64::from(header[16]).div_ceil(8), 1, bytes.len())?,
    }
    Ok(size)
}

pub(super) fn decode_tga(bytes: &[u8]) -> Result<Picture, String> {
    let header = tga_header(bytes)?;
    decoded("TGA", &header, TgaDecoder::new(Cursor::new(bytes)))
}

fn decoded(
    kind: &str,
    header: &Header,
    decoder: image::ImageResult<impl ImageDecoder>,
) -> Result<Picture, String> {
    let picture = decoder.and_then(DynamicImage::from_decoder);
    let picture = picture.map_err(|e| broken_picture(kind, e))?.into_rgba8();
    let (width, height) = picture.dimensions();
    if (width, height) != (header.width, header.height) {
        return Err("its header contradicts itself".into());
    }
    let texel = |c: &[u8]| u32::from_le_bytes([c[0], c[1], c[2], c[3]]);
    let texels = picture.as_raw().chunks_exact(4).map(texel).collect();
    Ok(Picture { width, height, texels: Texels::Rgba8(texels) })
}
