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
    /// 8 bits a channel, compressed with loss.
    Jpeg,
    /// Linear colours of 8 bits a channel with a shared exponent, in run lengths (Radiance RGBE).
    Hdr,
    /// Linear floats of 32 or 16 bits, compressed without loss (OpenEXR).
    Exr,
    /// Little-endian `i32` width and height, then R, G, B, A bytes, top row first: the format of PLATO's course.
    Data,
}

impl Format {
    /// All formats.
    pub const ALL: [Format; 6] =
        [Format::Png, Format::Ppm, Format::Jpeg, Format::Hdr, Format::Exr, Format::Data];

    /// The format that a file name asks for, whatever the case of its letters.
    pub fn of(path: &Path) -> Result<Format, OutputError> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        let ends = |format: &Format| format.extensions().iter().any(|e| extension.eq_ignore_ascii_case(e));
        let known = Format::ALL.into_iter().find(ends);
        known.ok_or_else(|| OutputError::UnknownFormat { path: path.to_owned() })
    }

    /// The ends of file names, without the dot; the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Format::Png => &["png"],
            Format::Ppm => &["ppm"],
            Format::Jpeg => &["jpg", "jpeg"],
            Format::Hdr => &["hdr"],
            Format::Exr => &["exr"],
            Format::Data => &["data"],
        }
    }

    /// Whether files hold linear colours instead of developed bytes.
    pub fn is_linear(self) -> bool {
        matches!(self, Format::Exr | Format::Hdr)
    }

    /// Whether files can hold layers besides the colours.
    pub fn has_layers(self) -> bool {
        self == Format::Exr
    }

    /// Whether files can say how much of a pixel is covered.
    pub fn has_alpha(self) -> bool {
        matches!(self, Format::Png | Format::Exr)
    }

    /// Whether files say what they are made of: [`super::Metadata`].
    pub fn has_metadata(self) -> bool {
        matches!(self, Format::Png | Format::Exr)
    }

    /// For messages: `.png, .ppm, .jpg, .hdr, .exr or .data`.
    pub(crate) fn list() -> String {
        let names = Format::ALL.map(|format| format!(".{}", format.extensions()[0]));
        let (last, others) = names.split_last().expect("there are formats");
        format!("{} or {last}", others.join(", "))
    }
}
