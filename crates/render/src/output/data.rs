//! `.data`: little-endian `i32` width and height, then R, G, B, A bytes, top row first.

use super::{ByteImage, Developed};
use std::io::{Error, Write};

pub(super) fn write(mut writer: impl Write, picture: &Developed) -> Result<(), Error> {
    writer.write_all(&(picture.width as i32).to_le_bytes())?;
    writer.write_all(&(picture.height as i32).to_le_bytes())?;
    for &[r, g, b] in picture.rgb.as_chunks::<3>().0 {
        writer.write_all(&[r, g, b, 255])?;
    }
    Ok(())
}

pub(super) fn read(bytes: &[u8]) -> Result<ByteImage, String> {
    let (header, body) = bytes.split_at_checked(8).ok_or("the file is cut off")?;
    let side = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
    let (width, height) = (side(0), side(4));
    ByteImage::check_size(width, height)?;
    if body.len() != width as usize * height as usize * 4 {
        return Err(format!("{} bytes do not make {width} x {height} pixels", body.len()));
    }
    Ok(ByteImage { width, height, rgba: body.as_chunks::<4>().0.to_vec() })
}
