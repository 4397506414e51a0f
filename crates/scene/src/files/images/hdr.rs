//! Radiance pictures (RGBE): a shared exponent a texel, with either of the two run-length codes or none.

use super::{Header, Picture, limits};
use crate::model::TexelLayout;

/// Longer headers are no headers.
const MAX_HEADER: usize = 1 << 16;

/// The newer code packs 127 texels into 8 bytes. The older one could pack a row into 12, but nobody needs that.
const TEXELS_A_BYTE: u64 = 1024;

const CUT_SHORT: &str = "the file is cut short; get it again";

pub(super) fn header(bytes: &[u8], most_bytes: u64) -> Result<Header, String> {
    Ok(open(bytes, most_bytes)?.0)
}

/// What the head says, and the rows.
fn open(bytes: &[u8], most_bytes: u64) -> Result<(Header, Size, &[u8]), String> {
    let mut lines = Lines { rest: &bytes[..bytes.len().min(MAX_HEADER)], taken: 0 };
    loop {
        match lines.next().ok_or("the header does not end")? {
            b"" => break,
            b"FORMAT=32-bit_rle_xyze" => return Err("XYZE colours are not read; convert it to RGBE".into()),
            _ => {}
        }
    }
    let size = lines.next().ok_or("the header does not end")?;
    let size = Size::parse(size)?;
    let header = limits::size(size.width, size.height, TexelLayout::Rgbe, most_bytes)?;
    limits::holds(size.width * size.height, TEXELS_A_BYTE, bytes.len())?;
    Ok((header, size, &bytes[lines.taken..]))
}

pub(super) fn decode(bytes: &[u8], most_bytes: u64) -> Result<Picture, String> {
    let (header, Size { from_bottom, from_right, .. }, mut rest) = open(bytes, most_bytes)?;
    let (columns, rows) = (header.width as usize, header.height as usize);
    let mut words = vec![0; columns * rows];
    let mut row = vec![[0; 4]; columns];
    for y in 0..rows {
        rest = read_row(rest, &mut row)?;
        if from_right {
            row.reverse();
        }
        let y = if from_bottom { rows - 1 - y } else { y };
        for (word, code) in words[y * columns..][..columns].iter_mut().zip(&row) {
            *word = u32::from_le_bytes(*code);
        }
    }
    Ok(Picture::new(&header, words))
}

struct Lines<'a> {
    rest: &'a [u8],
    taken: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Option<&'a [u8]> {
        let end = self.rest.iter().position(|&b| b == b'\n')?;
        let line = &self.rest[..end];
        self.rest = &self.rest[end + 1..];
        self.taken += end + 1;
        Some(line.trim_ascii())
    }
}

struct Size {
    width: u64,
    height: u64,
    from_bottom: bool,
    from_right: bool,
}

impl Size {
    /// `-Y height +X width`, with either sign of both.
    fn parse(line: &[u8]) -> Result<Size, String> {
        let text = String::from_utf8_lossy(line);
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        if let [y @ ("-Y" | "+Y"), height, x @ ("+X" | "-X"), width] = words[..]
            && let (Ok(height), Ok(width)) = (height.parse::<u32>(), width.parse::<u32>())
        {
            let (width, height) = (width.into(), height.into());
            return Ok(Size { width, height, from_bottom: y == "+Y", from_right: x == "-X" });
        }
        let line: String = text.chars().take(80).collect();
        Err(format!("\"{line}\" is no size that is read; it must be: -Y HEIGHT +X WIDTH"))
    }
}

/// Reads a row of texels; what comes after it.
fn read_row<'a>(bytes: &'a [u8], row: &mut [[u8; 4]]) -> Result<&'a [u8], String> {
    let width = row.len();
    match bytes {
        &[2, 2, high, low, ref rest @ ..] if high < 128 && (8..32_768).contains(&width) => {
            if usize::from(high) << 8 | usize::from(low) == width {
                return read_channels(rest, row);
            }
            Err("a row is not as long as the header says; the file is damaged; get it again".into())
        }
        _ => read_texels(bytes, row),
    }
}

/// The newer code: one channel after the other, in runs and literal stretches.
fn read_channels<'a>(mut bytes: &'a [u8], row: &mut [[u8; 4]]) -> Result<&'a [u8], String> {
    for channel in 0..4 {
        let mut x = 0;
        while x < row.len() {
            let (&count, rest) = bytes.split_first().ok_or(CUT_SHORT)?;
            let (length, is_run) = if count > 128 { (count - 128, true) } else { (count, false) };
            let length = usize::from(length);
            let stretch = row.get_mut(x..x + length).filter(|s| !s.is_empty());
            let stretch = stretch.ok_or("a run does not fit its row; the file is damaged; get it again")?;
            let used = if is_run { 1 } else { length };
            let values = rest.get(..used).ok_or(CUT_SHORT)?;
            for (i, texel) in stretch.iter_mut().enumerate() {
                texel[channel] = values[if is_run { 0 } else { i }];
            }
            bytes = &rest[used..];
            x += length;
        }
    }
    Ok(bytes)
}

/// The older code: texels, where (1, 1, 1, n) repeats the one before n times; further ones at once count 256-fold.
fn read_texels<'a>(mut bytes: &'a [u8], row: &mut [[u8; 4]]) -> Result<&'a [u8], String> {
    let (mut x, mut shift) = (0, 0);
    while x < row.len() {
        let (&texel, rest) = bytes.split_first_chunk::<4>().ok_or(CUT_SHORT)?;
        bytes = rest;
        let [1, 1, 1, count] = texel else {
            row[x] = texel;
            (x, shift) = (x + 1, 0);
            continue;
        };
        // Rows have fewer than 2^16 texels, so that shifts of 16 and more fit only where the count is 0.
        let length = if shift < 16 { usize::from(count) << shift } else { row.len() };
        let before = x.checked_sub(1).map(|before| row[before]);
        let (Some(before), Some(stretch)) = (before, row.get_mut(x..x + length)) else {
            return Err("a run does not fit its row; the file is damaged; get it again".into());
        };
        stretch.fill(before);
        (x, shift) = (x + length, shift + 8);
    }
    Ok(bytes)
}
