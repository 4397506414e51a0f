//! BMP and TGA, by the `image` crate; whether a file can hold what it claims is asked here first.

use super::{Header, Picture, broken_picture, limits};
use crate::model::TexelLayout;
use image::codecs::{bmp::BmpDecoder, tga::TgaDecoder};
use image::{ColorType, ImageDecoder, ImageResult};
use std::io::Cursor;

const CUT_SHORT: &str = "the file is cut short; get it again";

/// Of a file.
type Bytes<'a> = Cursor<&'a [u8]>;

/// What a texel is at most.
const MOST: TexelLayout = TexelLayout::Bytes(4);

pub(super) fn bmp_header(bytes: &[u8]) -> Result<Header, String> {
    Ok(open_bmp(bytes)?.1)
}

fn open_bmp(bytes: &[u8]) -> Result<(BmpDecoder<Bytes<'_>>, Header), String> {
    let word = |at: usize| {
        bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).ok_or(CUT_SHORT)
    };
    let half = |at: usize| word(at).map(|w| w & 0xffff);
    // The oldest header is 12 bytes long, has sides of 16 bits and knows no compression.
    let (width, height, bits, compression) = match word(14)? {
        12 => (half(18)?, half(20)?, half(24)?, 0),
        _ => (word(18)?, (word(22)? as i32).unsigned_abs(), half(28)?, word(30)?),
    };
    let header = limits::size(width.into(), height.into(), MOST)?;
    let row = u64::from(width);
    match compression {
        // Run lengths: two bytes for 255 texels.
        1 | 2 => limits::holds(row * u64::from(height), 128, bytes.len())?,
        _ => limits::holds((row * u64::from(bits)).div_ceil(8) * u64::from(height), 1, bytes.len())?,
    }
    opened("BMP", &header, BmpDecoder::new(Cursor::new(bytes)))
}

pub(super) fn decode_bmp(bytes: &[u8]) -> Result<Picture, String> {
    let (decoder, header) = open_bmp(bytes)?;
    decoded("BMP", &header, decoder)
}

pub(super) fn tga_header(bytes: &[u8]) -> Result<Header, String> {
    Ok(open_tga(bytes)?.1)
}

fn open_tga(bytes: &[u8]) -> Result<(TgaDecoder<Bytes<'_>>, Header), String> {
    let Some(head) = bytes.first_chunk::<18>() else { return Err(CUT_SHORT.into()) };
    let side = |at: usize| u64::from(head[at]) | u64::from(head[at + 1]) << 8;
    let header = limits::size(side(12), side(14), MOST)?;
    let texels = side(12) * side(14);
    match head[2] {
        // Run lengths: a byte and a texel for 128 texels.
        9..=11 => limits::holds(texels, 128, bytes.len())?,
        _ => limits::holds(texels * u64::from(head[16]).div_ceil(8), 1, bytes.len())?,
    }
    opened("TGA", &header, TgaDecoder::new(Cursor::new(bytes)))
}

pub(super) fn decode_tga(bytes: &[u8]) -> Result<Picture, String> {
    let (decoder, header) = open_tga(bytes)?;
    decoded("TGA", &header, decoder)
}

/// A decoder, and what it says of the texels.
fn opened<D: ImageDecoder>(
    kind: &str,
    header: &Header,
    decoder: ImageResult<D>,
) -> Result<(D, Header), String> {
    let decoder = decoder.map_err(|e| broken_picture(kind, e))?;
    let (width, height) = decoder.dimensions();
    if (width, height) != (header.width, header.height) {
        return Err("its header contradicts itself".into());
    }
    let channels = match decoder.color_type() {
        ColorType::L8 => 1,
        ColorType::La8 => 2,
        ColorType::Rgb8 => 3,
        ColorType::Rgba8 => 4,
        _ => return Err(broken_picture(kind, "unsupported")),
    };
    let header = limits::size(width.into(), height.into(), TexelLayout::Bytes(channels))?;
    Ok((decoder, header))
}

fn decoded(kind: &str, header: &Header, decoder: impl ImageDecoder) -> Result<Picture, String> {
    Picture::of_bytes(header, |bytes| decoder.read_image(bytes).map_err(|e| broken_picture(kind, e)))
}
