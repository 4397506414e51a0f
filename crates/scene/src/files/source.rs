//! Where the bytes of files come from.

use super::json::nearest::nearest;
use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

/// Of a folder, no more names are looked at.
const MOST_NAMES: usize = 10_000;

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
        let names: Vec<String> = match self {
            Source::Disk => {
                let folder =
                    path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
                let Ok(entries) = std::fs::read_dir(folder) else { return reason };
                let file = |entry: std::fs::DirEntry| entry.file_name().into_string().ok();
                entries.take(MOST_NAMES).filter_map(|entry| file(entry.ok()?)).collect()
            }
            Source::Memory(_) => return reason,
        };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        match nearest(&name, names.iter().map(String::as_str)) {
            Some(near) => io::Error::new(reason.kind(), format!("{reason}; did you mean {near}?")),
            None => reason,
        }
    }

    pub(crate) fn exists(&self, path: &Path) -> bool {
        match self {
            Source::Disk => path.is_file(),
            Source::Memory(files) => files.iter().any(|(name, _)| name == path),
        }
    }
}
