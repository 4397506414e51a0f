//! PPM, binary (P6).

use super::Developed;
use super::destination::Destination;
use super::encoder::ByteEncoder;
use super::metadata::{SOFTWARE, completeness};
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
