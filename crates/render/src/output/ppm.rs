//! PPM, binary (P6).

use super::destination::Destination;
use super::encoder::ByteEncoder;
use super::metadata::{SOFTWARE, completeness};
use super::{ByteImage, Developed};
use std::io::{Error, Write};

/// The header up to the word that says whether the picture is complete.
const BEGIN: &str = "P6\n# ";

/// Writes pixels as they come.
pub(super) struct PpmEncoder {
    file: Destination,
}

impl PpmEncoder {
    pub(super) fn new(mut file: Destination, width: u32, height: u32) -> Result<PpmEncoder, Error> {
        let complete = completeness(true);
        write!(file, "{BEGIN}{complete} {SOFTWARE}\n{width} {height}\n255\n")?;
        Ok(PpmEncoder { file })
    }
}

impl ByteEncoder for PpmEncoder {
    fn rows(&mut self, rows: &Developed) -> Result<(), Error> {
        self.file.write_all(&rows.rgb)
    }

    fn finish(mut self: Box<Self>, complete: bool) -> Result<(), Error> {
        self.file.patch(BEGIN.len() as u64, completeness(complete).as_bytes())
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<ByteImage, String> {
    let mut rest = bytes.strip_prefix(b"P6").ok_or("it is not a binary PPM (P6)")?;
    let mut number = || header_number(&mut rest);
    let (width, height, most) = (number()?, number()?, number()?);
    ByteImage::check_size(width, height)?;
    if most != 255 {
        return Err(format!("its largest value is {most}; only 255 is read: save it with 8 bits a channel"));
    }
    // Exactly one white-space byte ends the header.
    let body = rest.get(1..).ok_or("the file is cut off; get it again")?;
    let length = width as usize * height as usize * 3;
    let body = body.get(..length).ok_or("the file is cut off; get it again")?;
    let rgba = body.as_chunks::<3>().0.iter().map(|&[r, g, b]| [r, g, b, 255]).collect();
    Ok(ByteImage { width, height, rgba })
}

/// The next number of the header; comments run from `#` to the end of the line.
fn header_number(rest: &mut &[u8]) -> Result<u32, String> {
    loop {
        *rest = rest.trim_ascii_start();
        if !rest.starts_with(b"#") {
            break;
        }
        let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        *rest = &rest[end..];
    }
    let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    let (number, after) = rest.split_at(digits);
    *rest = after;
    let text = std::str::from_utf8(number).unwrap_or_default();
    text.parse().map_err(|_| "the header needs width, height and 255; save it anew".to_owned())
}
