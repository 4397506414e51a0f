//! PPM, PGM and PBM, as text and as bytes.

use super::{Header, Picture, limits, to_byte};
use crate::model::TexelLayout;

pub(super) fn header(bytes: &[u8], most_bytes: u64) -> Result<Header, String> {
    Ok(open(bytes, most_bytes)?.header)
}

/// The largest value of a channel.
pub(super) fn largest_value(bytes: &[u8]) -> Result<u32, String> {
    Ok(open(bytes, u64::MAX)?.most)
}

/// What the head says, and the samples.
struct Opened<'a> {
    header: Header,
    /// The digit after the P, as a number.
    kind: u8,
    /// The largest sample.
    most: u32,
    reader: Reader<'a>,
}

fn open(bytes: &[u8], most_bytes: u64) -> Result<Opened<'_>, String> {
    let kind = bytes[1] - b'0';
    let mut reader = Reader { rest: &bytes[2..] };
    let (width, height) = (reader.header()?, reader.header()?);
    let most = if matches!(kind, 1 | 4) { 1 } else { reader.header()? };
    if !(1..=65_535).contains(&most) {
        return Err(format!("{most} is no largest value; it must be 1 to 65535"));
    }
    let channels = if matches!(kind, 3 | 6) { 3 } else { 1 };
    let header = limits::size(width.into(), height.into(), TexelLayout::Bytes(channels), most_bytes)?;
    let text = kind <= 3;
    if !text {
        // One byte of white space, then the samples.
        reader.rest = reader.rest.get(1..).unwrap_or(&[]);
    }
    let row = u64::from(width) * u64::from(channels);
    let needed = match kind {
        // A digit a sample.
        1 => row * u64::from(height),
        // A digit and a blank; the last needs none.
        2 | 3 => row * u64::from(height) * 2 - 1,
        4 => row.div_ceil(8) * u64::from(height),
        _ => row * u64::from(height) * if most > 255 { 2 } else { 1 },
    };
    limits::holds(needed, 1, reader.rest.len())?;
    Ok(Opened { header, kind, most, reader })
}

pub(super) fn decode(bytes: &[u8], most_bytes: u64) -> Result<Picture, String> {
    let Opened { header, kind, most, mut reader } = open(bytes, most_bytes)?;
    let columns = header.width as usize;
    Picture::of_bytes(&header, |bytes| {
        if kind == 4 {
            for row in bytes.chunks_exact_mut(columns) {
                let (bits, rest) = reader.rest.split_at(columns.div_ceil(8));
                reader.rest = rest;
                row.iter_mut().enumerate().for_each(|(x, byte)| *byte = ink(bits[x / 8] >> (7 - x % 8) & 1));
            }
            return Ok(());
        }
        for byte in bytes {
            *byte = match kind {
                1 => ink(reader.bit()?),
                2 | 3 => to_byte(reader.number()?, most),
                _ => to_byte(reader.binary(most)?, most),
            };
        }
        Ok(())
    })
}

/// In bitmaps 1 is black.
fn ink(bit: u8) -> u8 {
    if bit == 0 { 255 } else { 0 }
}

const CUT_SHORT: &str = "the file is cut short; get it again";

struct Reader<'a> {
    rest: &'a [u8],
}

impl Reader<'_> {
    /// A number of the header, which may have comments.
    fn header(&mut self) -> Result<u32, String> {
        self.skip_blanks();
        while self.rest.first() == Some(&b'#') {
            let end = self.rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(self.rest.len());
            self.rest = &self.rest[end..];
            self.skip_blanks();
        }
        self.number()
    }

    fn skip_blanks(&mut self) {
        self.rest = self.rest.trim_ascii_start();
    }

    fn number(&mut self) -> Result<u32, String> {
        self.skip_blanks();
        let length = self.rest.iter().position(|b| !b.is_ascii_digit()).unwrap_or(self.rest.len());
        let (digits, rest) = self.rest.split_at(length);
        self.rest = rest;
        let number = std::str::from_utf8(digits).ok().and_then(|digits| digits.parse().ok());
        number.ok_or_else(|| {
            if rest.is_empty() { CUT_SHORT.into() } else { "a number is missing or too large".into() }
        })
    }

    /// Digits of bitmaps need no blanks between them.
    fn bit(&mut self) -> Result<u8, String> {
        self.skip_blanks();
        match self.rest {
            [b @ (b'0' | b'1'), rest @ ..] => {
                self.rest = rest;
                Ok(b - b'0')
            }
            _ => Err("0 or 1 is missing".into()),
        }
    }

    fn binary(&mut self, most: u32) -> Result<u32, String> {
        let (value, rest) = match self.rest {
            [high, low, rest @ ..] if most > 255 => (u32::from(*high) << 8 | u32::from(*low), rest),
            [byte, rest @ ..] if most <= 255 => (u32::from(*byte), rest),
            _ => return Err(CUT_SHORT.into()),
        };
        self.rest = rest;
        Ok(value)
    }
}
