//! How large pictures may be. It is asked before anything is allocated, so that a small file that claims to be a huge
//! picture costs nothing.

use super::Header;
use crate::model::TexelLayout;

/// Texels a row, and rows.
const MAX_SIDE: u64 = 65_535;

/// Bytes of one decoded texture: 2 GiB.
pub(super) const MAX_TEXTURE_BYTES: u64 = 2 << 30;

/// The header of a picture, if its sides are within the limits, and its bytes are at most so many.
pub(super) fn size(width: u64, height: u64, layout: TexelLayout, most_bytes: u64) -> Result<Header, String> {
    if width == 0 || height == 0 {
        return Err("the picture is empty; save it anew".into());
    }
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(format!("its size is {width} x {height}; sides must be at most {MAX_SIDE}"));
    }
    let bytes = layout.bytes(width * height);
    if bytes > most_bytes {
        let gib = most_bytes >> 30;
        return Err(format!("{width} x {height} texels take more than {gib} GiB; use a smaller picture"));
    }
    Ok(Header { width: width as u32, height: height as u32, layout, bytes })
}

/// Whether a file of this size can hold so much: a format packs no more than `most` units into a byte.
pub(super) fn holds(units: u64, most: u64, file_bytes: usize) -> Result<(), String> {
    if units <= (file_bytes as u64).saturating_mul(most) {
        return Ok(());
    }
    Err("the file is too small for the size that it claims; it is cut short or damaged; get it again".into())
}
