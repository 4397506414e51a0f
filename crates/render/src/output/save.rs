//! Saving a film under a name.

use super::atomic::{self, FileWriter};
use super::{DevelopSettings, Developed, Format, OutputError, data, exr, png, ppm};
use crate::Film;
use eosphor_scene::RenderSettings;
use std::io::Error;
use std::path::Path;

/// How a film is saved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SaveOptions {
    /// How it becomes bytes; EXR files are linear and take no notice of it.
    pub develop: DevelopSettings,
    /// False marks the picture as incomplete: a text `Comment: incomplete` in PNG, a comment in PPM, the attribute
    /// `incomplete` in EXR. `.data` files have no place for it.
    pub complete: bool,
}

impl Default for SaveOptions {
    fn default() -> SaveOptions {
        SaveOptions { develop: DevelopSettings::default(), complete: true }
    }
}

impl From<&RenderSettings> for SaveOptions {
    fn from(settings: &RenderSettings) -> SaveOptions {
        SaveOptions { develop: settings.into(), complete: true }
    }
}

/// Saves a film in the format of the file name's ending. The file is whole or not there: it is written beside its
/// final name, flushed to the disk, then renamed.
pub fn save(film: &Film, path: &Path, options: &SaveOptions) -> Result<(), OutputError> {
    match Format::of(path)? {
        Format::Exr => write(path, |w| exr::write(w, film, options.complete)),
        _ => save_developed(&Developed::new(film, &options.develop), path, options.complete),
    }
}

/// As [`save`], for a picture that is developed already. EXR files take linear films only and are refused.
pub fn save_developed(picture: &Developed, path: &Path, complete: bool) -> Result<(), OutputError> {
    match Format::of(path)? {
        Format::Png => write(path, |w| png::write(w, picture, complete)),
        Format::Ppm => write(path, |w| ppm::write(w, picture, complete)),
        Format::Data => write(path, |w| data::write(w, picture)),
        Format::Exr => Err(OutputError::write(path, Error::other("EXR takes linear pictures; use .png"))),
    }
}

/// Whether [`save`] could write there: a known ending, a folder that exists and may be written to. It leaves nothing
/// behind. Call it before minutes of rendering.
pub fn check_writable(path: &Path) -> Result<(), OutputError> {
    Format::of(path)?;
    atomic::check(path).map_err(|error| OutputError::write(path, error))
}

fn write<F>(path: &Path, write: F) -> Result<(), OutputError>
where
    F: FnOnce(&mut FileWriter) -> Result<(), Error>,
{
    atomic::write_atomically(path, write).map_err(|error| OutputError::write(path, error))
}
