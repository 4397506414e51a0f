//! Decoding of texture pictures.

use crate::model::Texels;
use image::{ImageReader, Limits};
use std::io::Cursor;

/// A decoded picture, top row first.
pub(super) struct Picture {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) texels: Texels,
}

/// Decodes a PNG, JPEG or PPM picture. The kind is told by the contents, not by the name.
pub(super) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let mut limits = Limits::default();
    limits.max_image_width = Some(65_535);
    limits.max_image_height = Some(65_535);
    limits.max_alloc = Some(2 << 30);
    let mut reader = ImageReader::new(Cursor::new(bytes));
    reader.limits(limits);
    let reader = reader.with_guessed_format().map_err(|e| e.to_string())?;
    if reader.format().is_none() {
        return Err("not a PNG, JPEG or PPM picture".into());
    }
    let picture = reader.decode().map_err(|e| e.to_string())?.into_rgba8();
    let (width, height) = picture.dimensions();
    if width == 0 || height == 0 {
        return Err("the picture is empty".into());
    }
    let texels =
        picture.as_raw().chunks_exact(4).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]])).collect();
    Ok(Picture { width, height, texels: Texels::Rgba8(texels) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ppm_bytes_keep_their_order() {
        let picture = decode(b"P6\n2 1\n255\n\x01\x02\x03\xff\x80\x00").unwrap();
        assert_eq!((picture.width, picture.height), (2, 1));
        assert_eq!(picture.texels, Texels::Rgba8(vec![0xff03_0201, 0xff00_80ff]));
    }

    #[test]
    fn what_is_no_picture_is_an_error() {
        assert_eq!(decode(b"hello").err().unwrap(), "not a PNG, JPEG or PPM picture");
        assert!(decode(b"P6\n60000 60000\n255\n").is_err());
    }
}
