//! Where a picture goes: files, or streams.

use super::files::{check_output, make_folder, same_place};
use super::{Event, JobControl, JobError};
use eosphor_picture::output::{Format, OutputError, PictureWriter, SaveOptions, Stream, partial_path};
use eosphor_render::{FeatureRows, Film};
use std::fmt;
use std::path::{Path, PathBuf};

/// Where a picture goes, and how it is written there.
pub enum Output {
    /// A file. It is whole or not there.
    File(PathBuf, Format),
    /// A stream, which gets the picture when it is whole.
    Stream {
        /// What messages call it, as "standard output".
        name: String,
        /// How the picture is written.
        format: Format,
        /// Where it is written to.
        stream: Stream,
    },
}

impl Output {
    /// A file, whose name says the format.
    ///
    /// # Errors
    ///
    /// [`OutputError::UnknownFormat`].
    pub fn file(path: &Path) -> Result<Output, OutputError> {
        Ok(Output::File(path.to_owned(), Format::of(path)?))
    }

    /// The format that the picture is written in.
    pub fn format(&self) -> Format {
        match self {
            Output::File(_, format) | Output::Stream { format, .. } => *format,
        }
    }

    /// The path, where it is a file.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Output::File(path, _) => Some(path),
            Output::Stream { .. } => None,
        }
    }

    /// Whether both are one place, under whatever name.
    fn is_same(&self, other: &Output) -> bool {
        match (self, other) {
            (Output::File(one, _), Output::File(other, _)) => same_place(one, other),
            (Output::Stream { name: one, .. }, Output::Stream { name: other, .. }) => one == other,
            (Output::File(..), Output::Stream { .. }) | (Output::Stream { .. }, Output::File(..)) => false,
        }
    }

    /// Makes its folder, where that is missing.
    pub(super) fn make_folder(&self) -> Result<(), JobError> {
        self.path().map_or(Ok(()), make_folder)
    }

    /// Begins a picture.
    pub(super) fn open(
        self,
        size: (u32, u32),
        options: &SaveOptions,
        control: &JobControl,
    ) -> Result<OpenOutput, OutputError> {
        let (writer, partial) = match self {
            Output::File(path, _) => (PictureWriter::open(&path, size, options)?, Some(partial_path(&path))),
            Output::Stream { name, format, stream } => {
                (PictureWriter::open_stream(stream, Path::new(&name), format, size, options)?, None)
            }
        };
        if let Some(path) = writer.temporary_path() {
            control.tell(Event::FileBegun(path));
        }
        Ok(OpenOutput { writer, partial })
    }
}

impl fmt::Display for Output {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Output::File(path, _) => path.display().fmt(f),
            Output::Stream { name, .. } => f.write_str(name),
        }
    }
}

impl fmt::Debug for Output {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "Output({self}, {:?})", self.format())
    }
}

/// Fails where two outputs are one place.
///
/// # Errors
///
/// [`JobError::SameOutput`].
pub fn check_apart(outputs: &[Output]) -> Result<(), JobError> {
    for (number, output) in outputs.iter().enumerate() {
        if let Some(first) = outputs[..number].iter().find(|first| output.is_same(first)) {
            let (first, second) = (first.to_string(), output.to_string());
            return Err(JobError::SameOutput { first, second });
        }
    }
    Ok(())
}

/// Fails where one of the outputs is a file that cannot be written, even in a folder that is made for it. Leaves nothing behind.
/// Jobs ask it, too: this is for who wants to know before a scene is loaded.
///
/// # Errors
///
/// [`OutputError::Write`].
pub fn check_writable(outputs: &[Output]) -> Result<(), OutputError> {
    outputs.iter().filter_map(Output::path).try_for_each(check_output)
}

/// A picture in the making.
pub(super) struct OpenOutput {
    writer: PictureWriter,
    /// The name of one that is not complete. `None` for a stream.
    partial: Option<PathBuf>,
}

impl OpenOutput {
    pub(super) fn write_rows(
        &mut self,
        film: &Film,
        features: Option<&FeatureRows>,
    ) -> Result<(), OutputError> {
        self.writer.write_rows(film, features)
    }

    /// Ends it; one that is not complete gets another name.
    pub(super) fn end(self, complete: bool) -> Result<(), OutputError> {
        match self.partial {
            _ if complete => self.writer.finish(),
            Some(partial) => self.writer.finish_partial(&partial),
            // Whoever reads a stream wants whole pictures.
            None => Ok(()),
        }
    }

    pub(super) fn is_stream(&self) -> bool {
        self.partial.is_none()
    }
}
