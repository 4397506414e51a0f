//! Picture formats, told by the end of the file name.

use super::OutputError;
use std::path::Path;

/// Formats that pictures are written in and read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8 bits a channel, compressed without loss.
    Png,
    /// 8 bits a channel, binary (P6).
    Ppm,
    /// Linear 32-bit floats, compressed without loss (OpenEXR).
    Exr,
    /// Little-endian `i32` width and height, then R, G, B, A bytes, top row first: the format of PLATO's course.
    Data,
}

impl Format {
    /// All of them.
    pub const ALL: [Format; 4] = [Format::Png, Format::Ppm, Format::Exr, Format::Data];

    /// The format that a file name asks for, whatever the case of its letters.
    pub fn of(path: &Path) -> Result<Format, OutputError> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        let known = Format::ALL.into_iter().find(|format| extension.eq_ignore_ascii_case(format.extension()));
        known.ok_or_else(|| OutputError::UnknownFormat { path: path.to_owned() })
    }

    /// The end of file names, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Png => "png",
            Format::Ppm => "ppm",
            Format::Exr => "exr",
            Format::Data => "data",
        }
    }

    /// Whether files hold linear floats instead of developed bytes.
    pub fn is_linear(self) -> bool {
        self == Format::Exr
    }

    /// For messages: `.png, .ppm, .exr or .data`.
    pub(crate) fn list() -> String {
        let names = Format::ALL.map(|format| format!(".{}", format.extension()));
        let (last, others) = names.split_last().expect("there are formats");
        format!("{} or {last}", others.join(", "))
    }
}
