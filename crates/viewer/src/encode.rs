//! Frames as bytes.

use eosphor::{Developed, Film, Format, OutputError, PictureWriter, SaveOptions};
use std::io::{Error, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// A picture as a JPEG; strips of it are encoded side by side.
pub(crate) fn jpeg(picture: &Developed, quality: u8) -> Result<Vec<u8>, OutputError> {
    let options = SaveOptions { jpeg_quality: quality, ..SaveOptions::default() };
    encoded(picture, Format::Jpeg, &options)
}

/// A picture as the PNG that `eosphor render --no-metadata` writes.
pub(crate) fn png(picture: &Developed, options: &SaveOptions) -> Result<Vec<u8>, OutputError> {
    encoded(picture, Format::Png, options)
}

/// A film as the EXR that `eosphor render --no-metadata` writes.
pub(crate) fn exr(film: &Film, options: &SaveOptions) -> Result<Vec<u8>, OutputError> {
    let bytes = Bytes::default();
    let mut writer = PictureWriter::open_stream(
        Box::new(bytes.clone()),
        Path::new("a picture"),
        Format::Exr,
        (film.width, film.height),
        options,
    )?;
    writer.write_rows(film, None)?;
    writer.finish()?;
    Ok(bytes.take())
}

fn encoded(picture: &Developed, format: Format, options: &SaveOptions) -> Result<Vec<u8>, OutputError> {
    let bytes = Bytes::default();
    let size = (picture.width, picture.height);
    let mut writer =
        PictureWriter::open_stream(Box::new(bytes.clone()), Path::new("a frame"), format, size, options)?;
    writer.write_developed(picture)?;
    writer.finish()?;
    Ok(bytes.take())
}

/// A stream into memory.
#[derive(Clone, Default)]
struct Bytes(Arc<Mutex<Vec<u8>>>);

impl Bytes {
    fn take(&self) -> Vec<u8> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Write for Bytes {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Error> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Error> {
        Ok(())
    }
}
