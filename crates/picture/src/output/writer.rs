//! Writing a picture row by row.

use super::alpha;
use super::atomic::TemporaryFile;
use super::data::DataEncoder;
use super::destination::Destination;
use super::encoder::Encoder;
use super::exr::{Channel, ExrEncoder, Layout};
use super::hdr::HdrEncoder;
use super::jpeg::JpegEncoder;
use super::png::PngEncoder;
use super::ppm::PpmEncoder;
use super::stream::{Spool, Stream};
use super::{DevelopSettings, Developed, Format, MAX_SIDE, OutputError, SaveOptions, Window};
use eosphor_core::math::Vec3;
use eosphor_render::{FeatureRows, Film};
use std::fs::File;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

/// Pixels of the black rows that are written at a time.
const BLACK_PIXELS: u32 = 1 << 20;

/// Writes a picture of any size row by row, in the format of its name's ending, so that it need not be in memory.
///
/// The file is whole or not there: rows go to a temporary file in the same folder, which [`PictureWriter::finish`]
/// flushes to the disk and renames. Dropped before that, it is removed.
///
/// ```
/// # use eosphor_picture::output::{PictureWriter, SaveOptions};
/// # use eosphor_render::Film;
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("grey.png");
/// let mut writer = PictureWriter::open(&path, (640, 480), &SaveOptions::default())?;
/// for _ in 0..10 {
///     writer.write_rows(&Film::new(640, 48), None)?;
/// }
/// writer.finish()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PictureWriter {
    path: PathBuf,
    target: Target,
    destination: Destination,
    encoder: Encoder,
    develop: DevelopSettings,
    width: u32,
    height: u32,
    rows_written: u32,
    /// The radiance of the background that is left out.
    alpha: Option<Vec3>,
    needs_features: bool,
    /// An encoder failed: how much of the file there is nobody knows.
    broken: bool,
}

/// Where rows go until the picture is whole.
enum Target {
    /// A file that gets its name then.
    File(TemporaryFile),
    /// A file without a name, which is copied to a stream then.
    Stream(Spool),
}

impl Target {
    fn handle(&self) -> Result<File, Error> {
        match self {
            Target::File(file) => file.handle(),
            Target::Stream(spool) => spool.handle(),
        }
    }
}

impl PictureWriter {
    /// Begins a picture of this width and height.
    ///
    /// # Errors
    ///
    /// [`OutputError::UnknownFormat`], [`OutputError::NoLayers`] for layers in another format than EXR, and
    /// [`OutputError::Write`] where the file cannot be created or an option or side is out of range.
    pub fn open(path: &Path, size: (u32, u32), options: &SaveOptions) -> Result<PictureWriter, OutputError> {
        let format = Format::of(path)?;
        if !options.layers.is_empty() && !format.has_layers() {
            return Err(OutputError::NoLayers { path: path.to_owned() });
        }
        let target = || TemporaryFile::beside(path).map(Target::File);
        PictureWriter::begin(path, format, size, options, target)
            .map_err(|error| OutputError::write(path, error))
    }

    /// Begins a picture that goes to a stream, as standard output, when it is whole; until then it is in a file without a
    /// name in the system's folder for temporary files. `name` is what errors call the stream.
    ///
    /// # Errors
    ///
    /// As of [`PictureWriter::open`].
    pub fn open_stream(
        stream: Stream,
        name: &Path,
        format: Format,
        size: (u32, u32),
        options: &SaveOptions,
    ) -> Result<PictureWriter, OutputError> {
        if !options.layers.is_empty() && !format.has_layers() {
            return Err(OutputError::NoLayers { path: name.to_owned() });
        }
        // What can go wrong until it is copied goes wrong there.
        let folder = std::env::temp_dir();
        let target = || Spool::new(stream, name).map(Target::Stream);
        PictureWriter::begin(&folder, format, size, options, target)
            .map_err(|error| OutputError::write(&folder, error))
    }

    /// Begins a picture file that lies in another folder of the same file system until it is whole.
    pub(super) fn open_within(
        folder: &Path,
        path: &Path,
        size: (u32, u32),
        options: &SaveOptions,
    ) -> Result<PictureWriter, OutputError> {
        let (format, target) = (Format::of(path)?, || TemporaryFile::within(folder, path).map(Target::File));
        PictureWriter::begin(path, format, size, options, target)
            .map_err(|error| OutputError::write(path, error))
    }

    fn begin(
        path: &Path,
        format: Format,
        (width, height): (u32, u32),
        options: &SaveOptions,
        target: impl FnOnce() -> Result<Target, Error>,
    ) -> Result<PictureWriter, Error> {
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
            return Err(misuse(format!("{width} x {height} pixels: sides must be 1 to {MAX_SIDE}")));
        }
        if let Some(Window { region, whole }) = options.window
            && ((region.width, region.height) != (width, height) || !region.is_in(whole))
        {
            return Err(misuse(format!(
                "{width} x {height} pixels are not the part of a picture that they should be"
            )));
        }
        if !(1..=100).contains(&options.jpeg_quality) {
            return Err(misuse(format!("JPEG quality {}: it must be 1 to 100", options.jpeg_quality)));
        }
        let target = target()?;
        let destination = Destination::new(target.handle()?);
        let to = destination.clone();
        let encoder = match format {
            Format::Png => {
                let has_alpha = options.alpha.is_some();
                Encoder::Bytes(Box::new(PngEncoder::new(to, (width, height), has_alpha, &options.metadata)?))
            }
            Format::Ppm => Encoder::Bytes(Box::new(PpmEncoder::new(to, width, height)?)),
            Format::Jpeg => {
                Encoder::Bytes(Box::new(JpegEncoder::new(to, width, height, options.jpeg_quality)))
            }
            Format::Data => Encoder::Bytes(Box::new(DataEncoder::new(to, width, height)?)),
            Format::Hdr => Encoder::Linear(Box::new(HdrEncoder::new(to, width, height)?)),
            Format::Exr => {
                let channels = Channel::all(&options.layers, options.alpha.is_some(), options.exr_half);
                let layout = Layout { size: (width, height), window: options.window };
                Encoder::Linear(Box::new(ExrEncoder::new(to, layout, channels, &options.metadata)?))
            }
        };
        Ok(PictureWriter {
            path: path.to_owned(),
            target,
            destination,
            encoder,
            develop: options.develop,
            width,
            height,
            rows_written: 0,
            alpha: options.alpha,
            needs_features: options.needs_features(),
            broken: false,
        })
    }

    /// The file that is being written, if it has a name. A program that ends without dropping the writer should remove it.
    pub fn temporary_path(&self) -> Option<&Path> {
        match &self.target {
            Target::File(file) => Some(file.path()),
            Target::Stream(_) => None,
        }
    }

    /// Rows that are still to be written.
    pub fn rows_left(&self) -> u32 {
        self.height - self.rows_written
    }

    /// Writes the next rows, as many as the film has; with their features where the file has layers or alpha.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`], also where the rows are too many, of another width, or lack their features.
    pub fn write_rows(&mut self, film: &Film, features: Option<&FeatureRows>) -> Result<(), OutputError> {
        let sizes =
            features.map_or([film.pixels.len(); 3], |f| [film.pixels.len(), f.pixels.len(), f.work.len()]);
        let is_linear = matches!(self.encoder, Encoder::Linear(_));
        // (Whether there are as many features as colours is looked at below.)
        let without_background;
        let film = match (self.alpha, features) {
            (None, _) if is_linear => film,
            (None, _) => return self.write_developed(&Developed::new(film, &self.develop)),
            (Some(background), Some(features)) if is_linear => {
                without_background = alpha::premultiplied(film, features, background);
                &without_background
            }
            (Some(background), Some(features)) => {
                return self.write_developed(&alpha::developed(film, features, background, &self.develop));
            }
            (Some(_), None) => {
                let error = misuse("alpha is asked for without features");
                return Err(OutputError::write(&self.path, error));
            }
        };
        self.write((film.width, film.height), &sizes, |encoder| match encoder {
            Encoder::Linear(encoder) => encoder.rows(film, features),
            Encoder::Bytes(_) => Ok(()),
        })
    }

    /// Writes the next rows of a picture that is developed already.
    ///
    /// # Errors
    ///
    /// As [`PictureWriter::write_rows`]; linear formats take films only.
    pub fn write_developed(&mut self, rows: &Developed) -> Result<(), OutputError> {
        if let Encoder::Linear(_) = self.encoder {
            let error = misuse("this format takes linear pictures; use .png");
            return Err(OutputError::write(&self.path, error));
        }
        let alpha = if self.alpha.is_some() { rows.alpha.len() } else { rows.rgb.len() / 3 };
        self.write((rows.width, rows.height), &[rows.rgb.len() / 3, alpha], |encoder| match encoder {
            Encoder::Bytes(encoder) => encoder.rows(rows),
            Encoder::Linear(_) => Ok(()),
        })
    }

    /// Writes rows of this size, for which there are arrays of so many pixels.
    fn write(
        &mut self,
        (width, height): (u32, u32),
        pixels: &[usize],
        rows: impl FnOnce(&mut Encoder) -> Result<(), Error>,
    ) -> Result<(), OutputError> {
        let whole = pixels.iter().all(|&pixels| pixels as u64 == width as u64 * height as u64);
        let written = match whole && width == self.width && height <= self.rows_left() {
            true => rows(&mut self.encoder).inspect_err(|_| self.broken = true),
            false => Err(misuse(format!(
                "{height} rows of {width} pixels for a picture of {} a row with {} rows left",
                self.width,
                self.rows_left()
            ))),
        };
        written.map(|()| self.rows_written += height).map_err(|error| OutputError::write(&self.path, error))
    }

    /// Ends the picture and gives the file its name.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`], also where rows are missing.
    pub fn finish(self) -> Result<(), OutputError> {
        match self.rows_left() {
            0 => self.end(true),
            left => {
                let error = misuse(format!("{left} of its rows are missing"));
                Err(OutputError::write(&self.path, error))
            }
        }
    }

    /// Ends a picture of which some is missing, and gives the file another name in the same folder ([`partial_path`]): what
    /// is there under the picture's own name stays. The file says that it is incomplete (but for `.data`, which has no place
    /// for it), and rows that were not written are black; layers show nothing there.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`], also for streams, which have no other name.
    pub fn finish_partial(mut self, path: &Path) -> Result<(), OutputError> {
        let renamed = match &mut self.target {
            Target::File(file) => file.rename(path),
            Target::Stream(_) => Err(misuse("a stream takes whole pictures only")),
        };
        renamed.map_err(|error| OutputError::write(path, error))?;
        self.path = path.to_owned();
        while self.rows_left() > 0 {
            let rows = (BLACK_PIXELS / self.width).clamp(1, self.rows_left());
            let features = self.needs_features.then(|| FeatureRows::new(self.width, rows));
            self.write_rows(&Film::new(self.width, rows), features.as_ref())?;
        }
        self.end(false)
    }

    fn end(self, complete: bool) -> Result<(), OutputError> {
        let PictureWriter { path, target, destination, encoder, broken, .. } = self;
        if broken {
            return Err(OutputError::write(&path, misuse("some of its rows could not be written")));
        }
        let ended = match encoder {
            Encoder::Bytes(encoder) => encoder.finish(complete),
            Encoder::Linear(encoder) => encoder.finish(complete),
        };
        let failed = |error| OutputError::write(&path, error);
        ended.and_then(|()| destination.finish()).map_err(failed)?;
        match target {
            Target::File(file) => file.keep().map_err(failed),
            Target::Stream(spool) => spool.send(),
        }
    }
}

/// The path that a picture is written to that is not whole: beside its own, as `a.partial.png` beside `a.png`.
pub fn partial_path(path: &Path) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(".partial");
    if let Some(ending) = path.extension() {
        name.push(".");
        name.push(ending);
    }
    path.with_file_name(name)
}

fn misuse(message: impl Into<String>) -> Error {
    Error::new(ErrorKind::InvalidInput, message.into())
}
