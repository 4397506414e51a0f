//! A picture read from a file.

use super::{Format, MAX_SIDE, OutputError, data, exr, hdr, jpeg, png, ppm};
use crate::Film;
use std::path::Path;

/// A picture in bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ByteImage {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` pixels R, G, B, A, top row first; A is 255 where the file has none.
    pub rgba: Vec<[u8; 4]>,
}

impl ByteImage {
    pub(super) fn check_size(width: u32, height: u32) -> Result<(), String> {
        let sane = 1..=MAX_SIDE;
        match sane.contains(&width) && sane.contains(&height) {
            true => Ok(()),
            false => Err(format!("its size is {width} x {height}; sides must be 1 to {MAX_SIDE}")),
        }
    }
}

/// A picture read from a file: bytes, or linear floats.
#[derive(Clone, Debug, PartialEq)]
pub enum Picture {
    /// PNG, PPM, JPEG and `.data`.
    Bytes(ByteImage),
    /// EXR and HDR.
    Linear(Film),
}

impl Picture {
    /// Reads a PNG, PPM, JPEG, HDR, EXR or `.data` file. All but `.data` are told by their first bytes.
    pub fn read(path: &Path) -> Result<Picture, OutputError> {
        let read = || {
            // A device or a pipe might never end.
            if !std::fs::metadata(path)?.is_file() {
                return Err(std::io::Error::other("this is a folder, device or pipe, not a file"));
            }
            std::fs::read(path)
        };
        let bytes = read().map_err(|error| OutputError::read(path, error))?;
        let format = sniff(&bytes).map_or_else(|| Format::of(path), Ok)?;
        Picture::from_bytes(&bytes, format).map_err(|reason| OutputError::malformed(path, reason))
    }

    /// The picture in the contents of a file of this format; the error says what is wrong with them.
    pub fn from_bytes(bytes: &[u8], format: Format) -> Result<Picture, String> {
        match format {
            Format::Png => png::read(bytes).map(Picture::Bytes),
            Format::Ppm => ppm::read(bytes).map(Picture::Bytes),
            Format::Jpeg => jpeg::read(bytes).map(Picture::Bytes),
            Format::Data => data::read(bytes).map(Picture::Bytes),
            Format::Hdr => hdr::read(bytes).map(Picture::Linear),
            Format::Exr => exr::read(bytes).map(Picture::Linear),
        }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        match self {
            Picture::Bytes(image) => (image.width, image.height),
            Picture::Linear(film) => (film.width, film.height),
        }
    }
}

fn sniff(bytes: &[u8]) -> Option<Format> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some(Format::Png),
        [b'P', b'6', b' ' | b'\t' | b'\r' | b'\n' | b'#', ..] => Some(Format::Ppm),
        [0xff, 0xd8, 0xff, ..] => Some(Format::Jpeg),
        [b'#', b'?', ..] => Some(Format::Hdr),
        [0x76, 0x2f, 0x31, 0x01, ..] => Some(Format::Exr),
        _ => None,
    }
}
