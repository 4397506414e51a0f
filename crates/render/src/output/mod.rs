//! Pictures in and out: developing a film to bytes, writing files that are whole or not there, reading them back.

mod atomic;
mod data;
mod develop;
mod error;
mod exr;
mod format;
mod picture;
mod png;
mod ppm;
mod save;

#[cfg(test)]
mod tests;

pub use develop::{DevelopSettings, Developed};
pub use error::OutputError;
pub use format::Format;
pub use picture::{ByteImage, Picture};
pub use save::{SaveOptions, check_writable, save, save_developed};

/// Longest side of a picture, in pixels.
pub const MAX_SIDE: u32 = 65_535;

/// What pictures say of the program that made them.
const SOFTWARE: &str = concat!("Eosphor ", env!("CARGO_PKG_VERSION"));
