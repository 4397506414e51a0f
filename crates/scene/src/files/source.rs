//! Where the bytes of files come from.

use super::json::nearest::nearest;
use crate::error::system_words;
use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

/// Most names of a folder that are looked at.
const MAX_FOLDER_NAMES: usize = 10_000;

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

    /// Of a file that is not there, with the name in its folder that is most like it.
    pub(crate) fn explain(&self, path: &Path, reason: io::Error) -> io::Error {
        if reason.kind() != io::ErrorKind::NotFound {
            return reason;
        }
        match self.near(path) {
            Some(near) => {
                io::Error::new(reason.kind(), format!("{}; did you mean {near}?", system_words(&reason)))
            }
            None => reason,
        }
    }

    /// The name in a file's folder that is most like its own.
    pub(crate) fn near(&self, path: &Path) -> Option<String> {
        match self {
            Source::Disk => near_name(path),
            Source::Memory(_) => None,
        }
    }

    /// Why there is nothing of this name; nothing where there is.
    pub(crate) fn why_missing(&self, path: &Path) -> Option<io::Error> {
        match self {
            Source::Disk => std::fs::metadata(path).err(),
            Source::Memory(_) => self.read(path).err(),
        }
    }

    pub(crate) fn exists(&self, path: &Path) -> bool {
        match self {
            Source::Disk => path.is_file(),
            Source::Memory(files) => files.iter().any(|(name, _)| name == path),
        }
    }
}

/// The name in a file's folder that is most like its own, to be asked for where the file is missing.
pub fn near_name(path: &Path) -> Option<String> {
    let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let file = |entry: std::fs::DirEntry| entry.file_name().into_string().ok();
    let entries = std::fs::read_dir(folder).ok()?.take(MAX_FOLDER_NAMES);
    let names: Vec<String> = entries.filter_map(|entry| file(entry.ok()?)).collect();
    let name = path.file_name()?.to_string_lossy();
    nearest(&name, names.iter().map(String::as_str)).map(str::to_owned)
}
