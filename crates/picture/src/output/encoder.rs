//! What formats have in common: rows in, from the top.

use super::Developed;
use eosphor_render::{FeatureRows, Film};
use std::io::Result;

/// Writes a picture row by row. It is asked for exactly the rows that the picture has.
pub(super) enum Encoder {
    /// Takes developed rows.
    Bytes(Box<dyn ByteEncoder>),
    /// Takes linear rows.
    Linear(Box<dyn LinearEncoder>),
}

/// Writes developed rows.
pub(super) trait ByteEncoder: Send {
    /// The next rows.
    fn rows(&mut self, rows: &Developed) -> Result<()>;

    /// Writes what follows the last row. `complete`: all of the picture was rendered.
    fn finish(self: Box<Self>, complete: bool) -> Result<()>;
}

/// Writes linear rows.
pub(super) trait LinearEncoder: Send {
    /// The next rows; features where the file has layers of them.
    fn rows(&mut self, film: &Film, features: Option<&FeatureRows>) -> Result<()>;

    /// Writes what follows the last row. `complete`: all of the picture was rendered.
    fn finish(self: Box<Self>, complete: bool) -> Result<()>;
}
