//! `.data`: width and height as 32-bit little-endian numbers, then R, G, B and A of each texel, top row first.

use super::{Header, Picture, limits};
use crate::model::TexelLayout;

pub(super) fn header(bytes: &[u8], most_bytes: u64) -> Result<Header, String> {
    let Some(([w0, w1, w2, w3, h0, h1, h2, h3], body)) = bytes.split_first_chunk::<8>() else {
        return Err("a .data picture begins with its width and height, 8 bytes; the file is shorter".into());
    };
    let side = |bytes: [u8; 4]| {
        let side = i32::from_le_bytes(bytes);
        u64::try_from(side).map_err(|_| format!("{side} is no width or height"))
    };
    let (width, height) = (side([*w0, *w1, *w2, *w3])?, side([*h0, *h1, *h2, *h3])?);
    let header = limits::size(width, height, TexelLayout::Bytes(4), most_bytes)?;
    let needed = width * height * 4;
    if body.len() as u64 != needed {
        let have = body.len();
        return Err(format!(
            "{width} x {height} texels take {needed} bytes after the first 8; there are {have}"
        ));
    }
    Ok(header)
}

pub(super) fn decode(bytes: &[u8], most_bytes: u64) -> Result<Picture, String> {
    let header = header(bytes, most_bytes)?;
    let words = bytes[8..].chunks_exact(4).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]));
    Ok(Picture::new(&header, words.collect()))
}
