//! Decoding of pictures: PNG, JPEG, PPM, Radiance HDR, OpenEXR, `.data`, TGA and BMP.
//!
//! Texels reach pixels, so a file must decode to the same bits on every machine. PNG, PPM, `.data`, TGA and BMP are
//! moves of whole numbers; `jpeg.rs` and `exr.rs` say how they keep to it. Texels stay as files have them; only what has
//! another number of bits than 8, palettes and runs are expanded to bytes, 16 bits rounded.

mod bmp;
mod broken;
mod data;
mod exr;
mod float;
mod hdr;
mod jpeg;
mod limits;
#[cfg(test)]
mod oracle_tests;
mod pixels;
mod png;
mod pnm;
#[cfg(test)]
pub(super) mod tests;
mod tga;

use crate::model::{TexelLayout, Texels};
use limits::MAX_TEXTURE_BYTES;

pub use broken::broken_picture;
pub use pixels::{PicturePixels, read_data, read_hdr, read_jpeg, read_png, read_ppm};

/// A decoded picture, top row first.
#[derive(Debug)]
pub(super) struct Picture {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) texels: Texels,
}

impl Picture {
    /// One white texel.
    pub(super) fn white() -> Picture {
        Picture { width: 1, height: 1, texels: Texels::rgba8(vec![u32::MAX]) }
    }

    /// Of words, as the header says.
    fn new(header: &Header, words: Vec<u32>) -> Picture {
        let Header { width, height, layout, .. } = *header;
        Picture { width, height, texels: Texels::new(layout, header.texels(), words) }
    }

    /// Of bytes, as the header says, which a decoder puts where they stay.
    fn of_bytes(
        header: &Header,
        fill: impl FnOnce(&mut [u8]) -> Result<(), String>,
    ) -> Result<Picture, String> {
        let mut words = vec![0u32; (header.bytes / 4) as usize];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut words);
        fill(&mut bytes[..header.texels() * header.layout.channels() as usize])?;
        // The first byte is the lowest of a word.
        words.iter_mut().for_each(|word| *word = u32::from_le(*word));
        Ok(Picture::new(header, words))
    }
}

/// What is read, for messages.
const KINDS: &str = "PNG, JPEG, PPM, HDR, EXR, BMP, TGA and .data";

/// What the head of a picture file says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) layout: TexelLayout,
    /// Of all texels, decoded.
    pub(super) bytes: u64,
}

impl Header {
    fn texels(&self) -> usize {
        self.width as usize * self.height as usize
    }
}

enum Kind {
    Png,
    Jpeg,
    Pnm,
    Hdr,
    Exr,
    Bmp,
    Tga,
    Data,
}

/// Reads the head of a picture: nothing of the picture's size is allocated. What it says is within the limits.
pub(super) fn header(bytes: &[u8], name: &str) -> Result<Header, String> {
    match kind(bytes, name)? {
        Kind::Png => png::header(bytes, MAX_TEXTURE_BYTES),
        Kind::Jpeg => jpeg::header(bytes, MAX_TEXTURE_BYTES),
        Kind::Pnm => pnm::header(bytes, MAX_TEXTURE_BYTES),
        Kind::Hdr => hdr::header(bytes, MAX_TEXTURE_BYTES),
        Kind::Exr => exr::header(bytes),
        Kind::Bmp => bmp::header(bytes),
        Kind::Tga => tga::header(bytes),
        Kind::Data => data::header(bytes, MAX_TEXTURE_BYTES),
    }
}

/// Decodes a picture.
pub(super) fn decode(bytes: &[u8], name: &str) -> Result<Picture, String> {
    match kind(bytes, name)? {
        Kind::Png => png::decode(bytes, MAX_TEXTURE_BYTES),
        Kind::Jpeg => jpeg::decode(bytes, MAX_TEXTURE_BYTES),
        Kind::Pnm => pnm::decode(bytes, MAX_TEXTURE_BYTES),
        Kind::Hdr => hdr::decode(bytes, MAX_TEXTURE_BYTES),
        Kind::Exr => exr::decode(bytes),
        Kind::Bmp => bmp::decode(bytes),
        Kind::Tga => tga::decode(bytes),
        Kind::Data => data::decode(bytes, MAX_TEXTURE_BYTES),
    }
}

/// The contents tell the kind; the name matters only for `.data` and TGA, which nothing in the file tells from other
/// bytes.
fn kind(bytes: &[u8], name: &str) -> Result<Kind, String> {
    Ok(match bytes {
        [0x89, b'P', b'N', b'G', ..] => Kind::Png,
        [0xff, 0xd8, 0xff, ..] => Kind::Jpeg,
        [b'P', b'1'..=b'6', b' ' | b'\t' | b'\r' | b'\n' | b'#', ..] => Kind::Pnm,
        [b'#', b'?', ..] => Kind::Hdr,
        [0x76, 0x2f, 0x31, 0x01, ..] => Kind::Exr,
        [b'B', b'M', ..] => Kind::Bmp,
        _ => match name.rsplit('.').next().map(str::to_ascii_lowercase).as_deref() {
            Some("data") => Kind::Data,
            Some("tga" | "targa") => Kind::Tga,
            _ => return Err(unknown(bytes)),
        },
    })
}

fn unknown(bytes: &[u8]) -> String {
    let kind = match bytes {
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => "WebP",
        [b'G', b'I', b'F', b'8', ..] => "GIF",
        [b'I', b'I', 42, 0, ..] | [b'M', b'M', 0, 42, ..] => "TIFF",
        [b'D', b'D', b'S', b' ', ..] => "DDS",
        [0xab, b'K', b'T', b'X', ..] => "KTX",
        _ => return format!("this is no picture of a kind that is read: {KINDS}"),
    };
    format!("{kind} pictures are not read; convert it to one of {KINDS}")
}

/// A number of 0 to `most` as one of 0 to 255, rounded; with 65,535 that is 16 bits as 8.
fn to_byte(value: u32, most: u32) -> u8 {
    ((value.min(most) * 255 + most / 2) / most) as u8
}
