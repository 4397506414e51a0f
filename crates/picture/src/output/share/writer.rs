//! Writing a share.

use super::super::atomic::TemporaryFile;
use super::super::{MAX_SIDE, OutputError};
use super::{BAND_ROWS, MAGIC, ShareHeader};
use eosphor_core::math::Vec3;
use eosphor_render::{CameraWork, FeatureRows, Film, PixelFeatures};
use std::fs::File;
use std::io::{BufWriter, Error, Write};
use std::path::{Path, PathBuf};

/// Writes a share, whose bands come one after another, in pieces of any height. The file is whole or not there.
pub struct ShareWriter {
    path: PathBuf,
    file: TemporaryFile,
    to: BufWriter<File>,
    sum: crc32fast::Hasher,
    width: u32,
    rows_written: u64,
    rows_left: u64,
    has_features: bool,
    /// Features of the band that is not whole yet: they come after its colours.
    features: Vec<u8>,
}

impl ShareWriter {
    /// Begins a share.
    ///
    /// # Errors
    ///
    /// Where the file cannot be made.
    pub fn open(path: &Path, header: &ShareHeader) -> Result<ShareWriter, OutputError> {
        let fail = |error| OutputError::write(path, error);
        let (width, height) = header.size;
        let sides = 1..=MAX_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) {
            return Err(fail(Error::other(format!("sides must be 1 to {MAX_SIDE}"))));
        }
        let file = TemporaryFile::beside(path).map_err(fail)?;
        let to = BufWriter::with_capacity(1 << 18, file.handle().map_err(fail)?);
        let mut writer = ShareWriter {
            path: path.to_owned(),
            file,
            to,
            sum: crc32fast::Hasher::new(),
            width,
            rows_written: 0,
            rows_left: header.bands().map(|rows| rows.len() as u64).sum(),
            has_features: header.options.needs_features(),
            features: Vec::new(),
        };
        let header = serde_json::to_vec(header).map_err(|error| fail(Error::other(error)))?;
        let begin = [&MAGIC[..], &(header.len() as u32).to_le_bytes(), &header].concat();
        writer.write(&begin).map_err(fail)?;
        Ok(writer)
    }

    /// The file that is being written. A program that ends without dropping the writer should remove it.
    pub fn temporary_path(&self) -> &Path {
        self.file.path()
    }

    /// The next rows of the share's bands, with features where the picture has layers or alpha.
    ///
    /// # Errors
    ///
    /// Where there is no room, or these are other rows than the share has.
    pub fn write_rows(&mut self, film: &Film, features: Option<&FeatureRows>) -> Result<(), OutputError> {
        let fits = film.width == self.width
            && u64::from(film.height) <= self.rows_left
            && features.is_some() == self.has_features
            && features.is_none_or(|features| features.pixels.len() == film.pixels.len());
        let written = match fits {
            true => (0..film.height).try_for_each(|row| self.write_row(film, features, row)),
            false => Err(Error::other("these are not the rows of the share")),
        };
        written.map_err(|error| OutputError::write(&self.path, error))
    }

    fn write_row(&mut self, film: &Film, features: Option<&FeatureRows>, row: u32) -> Result<(), Error> {
        let width = film.width as usize;
        let of_row = row as usize * width..(row as usize + 1) * width;
        let mut bytes = Vec::with_capacity(width * 12);
        film.pixels[of_row.clone()].iter().for_each(|&color| put_vector(&mut bytes, color));
        if let Some(FeatureRows { pixels, work, .. }) = features {
            for (pixel, work) in pixels[of_row.clone()].iter().zip(&work[of_row]) {
                put_features(&mut self.features, pixel, work);
            }
        }
        self.rows_written += 1;
        self.rows_left -= 1;
        // Only the last band of a picture has fewer rows.
        if self.rows_left == 0 || self.rows_written.is_multiple_of(u64::from(BAND_ROWS)) {
            bytes.append(&mut self.features);
        }
        self.write(&bytes)
    }

    /// Ends it, and gives it its name.
    ///
    /// # Errors
    ///
    /// Where rows are missing, or the file cannot be written.
    pub fn finish(mut self) -> Result<(), OutputError> {
        let finish = |writer: &mut ShareWriter| {
            if writer.rows_left > 0 {
                return Err(Error::other("rows are missing"));
            }
            let sum = writer.sum.clone().finalize();
            writer.to.write_all(&sum.to_le_bytes())?;
            writer.to.flush()
        };
        let done = finish(&mut self);
        done.and_then(|()| self.file.keep()).map_err(|error| OutputError::write(&self.path, error))
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.sum.update(bytes);
        self.to.write_all(bytes)
    }
}

fn put_vector(bytes: &mut Vec<u8>, v: Vec3) {
    for x in <[f32; 3]>::from(v) {
        bytes.extend_from_slice(&x.to_le_bytes());
    }
}

fn put_features(bytes: &mut Vec<u8>, pixel: &PixelFeatures, work: &CameraWork) {
    let &PixelFeatures { albedo, normal, depth, object, material, background } = pixel;
    put_vector(bytes, albedo);
    put_vector(bytes, normal);
    put_vector(bytes, background);
    for word in [depth.to_bits(), object, material, work.nodes, work.tests] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
}
