//! PPM, PGM and PBM, as text and as bytes.

use super::{Header, Picture, limits, rgba, to_byte};
use crate::model::Texels;

pub(super) fn header(bytes: &[u8]) -> Result<Header, String> {
    Ok(open(bytes)?.header)
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

fn open(bytes: &[u8]) -> Result<Opened<'_>, String> {
    let kind = bytes[1] - b'0';
    let mut reader = Reader { rest: &bytes[2..] };
    let (width, height) = (reader.header()?, reader.header()?);
    let most = if matches!(kind, 1 | 4) { 1 } else { reader.header()? };
    if !(1..=65_535).contains(&most) {
        return Err(format!("{most} is no largest value; it must be 1 to 65535"));
    }
    let header = limits::size(width.into(), height.into(), limits::RGBA8)?;
    let text = kind <= 3;
    let channels: u64 = if matches!(kind, 3 | 6) { 3 } else { 1 };
    if !text {
        // One byte of white space, then the samples.
        reader.rest = reader.rest.get(1..).unwrap_or(&[]);
    }
    let row = u64::from(width) * channels;
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

pub(super) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let Opened { header: Header { width, height, .. }, kind, most, mut reader } = open(bytes)?;
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    let sample = |value: u32| to_byte(value, most);
    for _ in 0..height {
        if kind == 4 {
            let (bits, rest) = reader.rest.split_at(width.div_ceil(8) as usize);
            reader.rest = rest;
            texels.extend((0..width as usize).map(|x| grey(ink(bits[x / 8] >> (7 - x % 8) & 1))));
            continue;
        }
        for _ in 0..width {
            texels.push(match kind {
                1 => grey(ink(reader.bit()?)),
                3 => rgba(sample(reader.number()?), sample(reader.number()?), sample(reader.number()?), 255),
                2 => grey(sample(reader.number()?)),
                6 => {
                    let [r, g, b] = [reader.binary(most)?, reader.binary(most)?, reader.binary(most)?];
                    rgba(sample(r), sample(g), sample(b), 255)
                }
                _ => grey(sample(reader.binary(most)?)),
            });
        }
    }
    Ok(Picture { width, height, texels: Texels::Rgba8(texels) })
}

fn grey(value: u8) -> u32 {
    rgba(value, value, value, 255)
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
