//! Pictures into streams, as standard output: formats write over their headers at the end, which streams do not allow.

use super::OutputError;
use std::fs::File;
use std::io::{Error, Seek, Write, copy};
use std::path::{Path, PathBuf};

/// Where the bytes of a picture go that is not written to a file, such as standard output.
pub type Stream = Box<dyn Write + Send>;

/// A file without a name, which is copied to a stream when it is whole: it is gone however the program ends.
pub(super) struct Spool {
    file: File,
    stream: Stream,
    name: PathBuf,
}

impl Spool {
    /// An empty one, in the system's folder for temporary files.
    pub(super) fn new(stream: Stream, name: &Path) -> Result<Spool, Error> {
        Ok(Spool { file: tempfile::tempfile()?, stream, name: name.to_owned() })
    }

    /// To write to. All handles share one position.
    pub(super) fn handle(&self) -> Result<File, Error> {
        self.file.try_clone()
    }

    /// Copies it to the stream.
    pub(super) fn send(mut self) -> Result<(), OutputError> {
        let sent = self.file.rewind().and_then(|()| copy(&mut self.file, &mut self.stream));
        sent.and_then(|_| self.stream.flush()).map_err(|error| OutputError::write(&self.name, error))
    }
}
