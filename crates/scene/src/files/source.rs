//! Where the bytes of files come from.

use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

/// The disk, or files held in memory (built-in scenes, tests).
pub(crate) enum Source {
    Disk,
    Memory(Vec<(PathBuf, Cow<'static, [u8]>)>),
}

impl Source {
    /// The whole file. Files are read whole, not mapped: a mapped file that changes underneath kills the process.
    pub(crate) fn read(&self, path: &Path) -> io::Result<Cow<'static, [u8]>> {
        match self {
            Source::Disk => {
                // A device or a pipe might never end.
                if !std::fs::metadata(path)?.is_file() {
                    return Err(io::Error::other("this is a folder, device or pipe, not a file"));
                }
                std::fs::read(path).map(Cow::Owned)
            }
            Source::Memory(files) => files
                .iter()
                .find(|(name, _)| name == path)
                .map(|(_, bytes)| bytes.clone())
                .ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "No such file")),
        }
    }

    pub(crate) fn exists(&self, path: &Path) -> bool {
        match self {
            Source::Disk => path.is_file(),
            Source::Memory(files) => files.iter().any(|(name, _)| name == path),
        }
    }
}
