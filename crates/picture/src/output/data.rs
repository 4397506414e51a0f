//! `.data`: little-endian `i32` width and height, then R, G, B, A bytes, top row first.

use super::Developed;
use super::destination::Destination;
use super::encoder::ByteEncoder;
use std::io::{Error, Write};

/// Writes pixels as they come.
pub(super) struct DataEncoder {
    file: Destination,
}

impl DataEncoder {
    pub(super) fn new(mut file: Destination, width: u32, height: u32) -> Result<DataEncoder, Error> {
        file.write_all(&(width as i32).to_le_bytes())?;
        file.write_all(&(height as i32).to_le_bytes())?;
        Ok(DataEncoder { file })
    }
}

impl ByteEncoder for DataEncoder {
    fn rows(&mut self, rows: &Developed) -> Result<(), Error> {
        for y in 0..rows.height {
            let row: Vec<u8> =
                rows.row(y).as_chunks::<3>().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
            self.file.write_all(&row)?;
        }
        Ok(())
    }

    /// The format has no place for `complete`.
    fn finish(self: Box<Self>, _complete: bool) -> Result<(), Error> {
        Ok(())
    }
}
