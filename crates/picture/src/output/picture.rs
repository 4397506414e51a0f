//! A picture read from a file.

use super::{Format, OutputError, exr, hdr};
use eosphor_render::Film;
use eosphor_scene::{PicturePixels, read_data, read_jpeg, read_png, read_ppm};
use std::path::Path;

/// A picture of 8 bits per channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ByteImage {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// `width * height` pixels R, G, B, A, top row first; A is 255 where the file has none.
    pub rgba: Vec<[u8; 4]>,
}

impl From<PicturePixels> for ByteImage {
    fn from(picture: PicturePixels) -> ByteImage {
        ByteImage { width: picture.width, height: picture.height, rgba: picture.pixels }
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
        let of_bytes = |pixels: Result<PicturePixels, String>| Ok(Picture::Bytes(pixels?.into()));
        match format {
            Format::Png => of_bytes(read_png(bytes)),
            Format::Ppm => of_bytes(read_ppm(bytes)),
            Format::Jpeg => of_bytes(read_jpeg(bytes)),
            Format::Data => of_bytes(read_data(bytes)),
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
