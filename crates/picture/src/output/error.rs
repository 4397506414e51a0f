//! What can go wrong with picture files.

use super::Format;
use eosphor_scene::near_name;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

/// Why a picture could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The file's ending is no format that Eosphor knows.
    #[error("unknown picture format: {}: use a file name that ends in {}; videos end in .mp4", path.display(), Format::list())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// Layers are asked for in a format that has none.
    #[error("no layers in this format: {}: only EXR files have them: use a name that ends in .exr", path.display())]
    NoLayers {
        /// The file.
        path: PathBuf,
    },
    /// The file could not be written; nothing is left under its name that was not there before.
    #[error("cannot write the picture: {}: {}", path.display(), explain(source))]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: Error,
    },
    /// The video could not be written. What was rendered of it is kept in its folder.
    #[error("cannot write the video: {}: {}", path.display(), explain(source))]
    Video {
        /// The video, or the file of its folder that is in the way.
        path: PathBuf,
        /// The reason.
        source: Error,
    },
    /// The file could not be read.
    #[error("cannot read the picture: {}: {}", path.display(), explain_reading(path, source))]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: Error,
    },
    /// The file's contents are not what its format asks for.
    #[error("cannot read the picture: {}: {reason}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

impl OutputError {
    pub(crate) fn write(path: &Path, source: Error) -> OutputError {
        OutputError::Write { path: path.to_owned(), source }
    }

    #[cfg(feature = "video")]
    pub(crate) fn video(path: &Path, source: Error) -> OutputError {
        OutputError::Video { path: path.to_owned(), source }
    }

    pub(crate) fn read(path: &Path, source: Error) -> OutputError {
        OutputError::Read { path: path.to_owned(), source }
    }

    pub(crate) fn malformed(path: &Path, reason: impl ToString) -> OutputError {
        OutputError::Malformed { path: path.to_owned(), reason: reason.to_string() }
    }
}

/// What is wrong with a file that is to be read, and what to do.
fn explain_reading(path: &Path, error: &Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => match near_name(path) {
            Some(near) => format!("no such file; did you mean {near}?"),
            None => "no such file; check the path".into(),
        },
        ErrorKind::PermissionDenied => "permission denied; it must be readable for you".into(),
        _ => explain(error),
    }
}

/// The system's reason why a file could not be written, and what to do about it.
pub fn explain(error: &Error) -> String {
    let advice = match error.kind() {
        ErrorKind::NotFound => "no such file or folder; check the path, or create the folder first",
        ErrorKind::PermissionDenied => "permission denied; choose a folder that you may write to",
        ErrorKind::ReadOnlyFilesystem => "the file system is read-only; choose another folder",
        ErrorKind::StorageFull => "no space left on the device; free some, or choose another folder",
        ErrorKind::FileTooLarge => {
            "files may not become so large there; raise the limit (ulimit -f), or choose another folder"
        }
        ErrorKind::QuotaExceeded => "your disk quota is used up; free some space, or choose another folder",
        ErrorKind::NotADirectory => "a part of the path is a file, not a folder",
        ErrorKind::BrokenPipe => "whoever was to read it has closed the pipe",
        ErrorKind::IsADirectory => "this is a folder; add a file name",
        ErrorKind::InvalidFilename => "the file system does not take this file name; choose a shorter one",
        _ => {
            let text = error.to_string();
            return match text.split_once(" (os error ") {
                Some((reason, _)) => format!("{reason}; look what is wrong there, or choose another folder"),
                None => text,
            };
        }
    };
    advice.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn no_reason_is_a_number_alone() {
        for (code, words) in [
            (28, "no space left"),
            (27, "ulimit -f"),
            (122, "quota"),
            (5, "choose another folder"),
            (24, "choose"),
        ] {
            let said = explain(&Error::from_raw_os_error(code));
            assert!(said.contains(words) && !said.contains("os error"), "{said}");
        }
        assert_eq!(explain(&Error::other("as it was said")), "as it was said");
    }
}
