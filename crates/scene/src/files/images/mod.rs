//! Decoding of pictures: PNG, JPEG, PPM, Radiance HDR, OpenEXR, `.data`, TGA and BMP.
//!
//! Texels reach pixels, so a file must decode to the same bits on every machine. PNG, PPM, `.data`, TGA and BMP are
//! moves of whole numbers; `jpeg.rs` and `exr.rs` say how they keep to it.

mod broken;
mod data;
mod exr;
mod float;
mod hdr;
mod jpeg;
mod limits;
mod old;
mod png;
mod pnm;
#[cfg(test)]
pub(super) mod tests;

use crate::model::Texels;

pub use broken::broken_picture;

/// A decoded picture, top row first.
#[derive(Debug)]
pub(super) struct Picture {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) texels: Texels,
}

/// What is read, for messages.
const KINDS: &str = "PNG, JPEG, PPM, HDR, EXR, BMP, TGA and .data";

/// Decodes a picture. The contents tell the kind; the name matters only for `.data` and TGA, which nothing in the
/// file tells from other bytes.
pub(super) fn decode(bytes: &[u8], name: &str) -> Result<Picture, String> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => png::decode(bytes),
        [0xff, 0xd8, 0xff, ..] => jpeg::decode(bytes),
        [b'P', b'1'..=b'6', b' ' | b'\t' | b'\r' | b'\n' | b'#', ..] => pnm::decode(bytes),
        [b'#', b'?', ..] => hdr::decode(bytes),
        [0x76, 0x2f, 0x31, 0x01, ..] => exr::decode(bytes),
        [b'B', b'M', ..] => old::decode_bmp(bytes),
        _ => match name.rsplit('.').next().map(str::to_ascii_lowercase).as_deref() {
            Some("data") => data::decode(bytes),
            Some("tga" | "targa") => old::decode_tga(bytes),
            _ => Err(unknown(bytes)),
        },
    }
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

/// R, G, B and A as one word, R in the low byte.
fn rgba(r: u8, g: u8, b: u8, a: u8) -> u32 {
    u32::from_le_bytes([r, g, b, a])
}

/// A number of 0 to `most` as one of 0 to 255, rounded; with 65,535 that is 16 bits as 8.
fn to_byte(value: u32, most: u32) -> u8 {
    ((value.min(most) * 255 + most / 2) / most) as u8
}
