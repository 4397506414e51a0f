//! Shares of a picture: files that hold some of its rows as they were rendered, so that jobs that know nothing of each
//! other can render one picture. Share k of n has every n-th band of rows, from the k-th on.
//!
//! | part | bytes |
//! |---|---|
//! | beginning | `EOSSHAR2`, the length of the header |
//! | header | [`ShareHeader`] as JSON |
//! | bands, from the top | three floats a pixel, row after row; then, with layers or alpha, fourteen words of features a pixel |
//! | end | CRC-32 of all before it |
//!
//! Numbers are 32 bits, lowest byte first.

mod reader;
#[cfg(test)]
mod tests;
mod writer;

pub use reader::{ShareError, ShareReader, merge};
pub use writer::ShareWriter;

use super::SaveOptions;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};

const MAGIC: [u8; 8] = *b"EOSSHAR2";

/// Bytes of a pixel's colour: three floats.
const COLOR_BYTES: u64 = 12;
/// Bytes of a pixel's features: fourteen words.
const FEATURE_BYTES: u64 = 56;

/// Rows of a band: few, so that all shares have about as much work.
pub const BAND_ROWS: u32 = 8;

/// What a share is part of. All but its number is the same in all shares of a picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShareHeader {
    /// The program, and the version of its pictures.
    pub program: String,
    /// Width and height of the whole picture in pixels.
    pub size: (u32, u32),
    /// What the pixels depend on: [`crate::scene_hash`].
    pub scene: String,
    /// How the whole picture is to be saved.
    pub options: SaveOptions,
    /// Number of the share, from 1, and how many shares there are.
    pub share: (u32, u32),
}

impl ShareHeader {
    /// The bands of rows that it has.
    pub fn bands(&self) -> impl Iterator<Item = Range<u32>> + use<> {
        bands(self.size.1, self.share)
    }

    fn pixel_bytes(&self) -> u64 {
        COLOR_BYTES + if self.options.needs_features() { FEATURE_BYTES } else { 0 }
    }
}

/// The bands of rows of a share of a picture of this height.
pub(crate) fn bands(height: u32, (number, count): (u32, u32)) -> impl Iterator<Item = Range<u32>> {
    let (number, count) = (u64::from(number), u64::from(count.max(1)));
    let (height, rows) = (u64::from(height), u64::from(BAND_ROWS));
    (number.saturating_sub(1)..)
        .step_by(count as usize)
        .map(move |band| band * rows)
        .take_while(move |row| *row < height)
        .map(move |row| row as u32..(row + rows).min(height) as u32)
}

/// The file of a share of the picture at `path`: `out.png.3-of-8.share`.
pub fn share_path(path: &Path, (number, count): (u32, u32)) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".{number}-of-{count}.share"));
    name.into()
}
