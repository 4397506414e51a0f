//! What can go wrong, and what is worth saying when nothing did.

use crate::snippet::Snippet;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Why a scene could not be read or prepared. Every message says where, what and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A file that cannot be opened or read.
    #[error("{}: cannot read: {}", path.display(), system_words(reason))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// A file whose contents are wrong.
    #[error("{place}: {message}")]
    Invalid {
        /// Where.
        place: Place,
        /// What is wrong and what to do.
        message: String,
        /// The line, where the file is one that people write.
        snippet: Option<Box<Snippet>>,
    },
    /// A file of a kind that is not read.
    #[error("{}: {message}", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// What is read.
        message: String,
    },
    /// [`crate::LoadOptions::camera`] is none of the file's.
    #[error("{}: {message}", path.display())]
    NoSuchCamera {
        /// The file.
        path: PathBuf,
        /// Which cameras it has.
        message: String,
    },
    /// Textures beyond [`crate::LoadOptions::texture_memory_bytes`].
    #[error(
        "{}: all textures together need {} of memory, their budget is {}: give them more, or use smaller \
         pictures",
        one_line(picture),
        size(*needed_bytes),
        size(*budget_bytes)
    )]
    TextureMemory {
        /// The first picture that did not fit.
        picture: String,
        /// What all textures of the scene need, in the depth that their files have.
        needed_bytes: u64,
        /// What they may take.
        budget_bytes: u64,
    },
    /// No built-in scene has this name.
    #[error("there is no built-in scene \"{name}\"; there is {known}")]
    UnknownBuiltin {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// A scene that contradicts itself, or a setting out of range.
    #[error(transparent)]
    Problem(#[from] Problem),
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub path: PathBuf,
    /// Line of the file, from 1; `None` where the file has no lines or the error none.
    pub line: Option<u32>,
    /// Column in bytes, from 1.
    pub column: Option<u32>,
}

impl Place {
    pub(crate) fn file(path: &Path) -> Place {
        Place { path: path.to_path_buf(), line: None, column: None }
    }

    pub(crate) fn line(path: &Path, line: u32) -> Place {
        Place { line: Some(line), ..Place::file(path) }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", one_line(self.path.to_string_lossy()))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        Ok(())
    }
}

impl SceneError {
    pub(crate) fn at(path: &Path, line: u32, message: impl Into<String>) -> SceneError {
        SceneError::invalid(Place::line(path, line), message)
    }

    pub(crate) fn invalid(place: Place, message: impl Into<String>) -> SceneError {
        SceneError::Invalid { place, message: one_line(message), snippet: None }
    }

    /// The line of the file that the error speaks of, to be shown below its message.
    pub fn snippet(&self) -> Option<&Snippet> {
        match self {
            SceneError::Invalid { snippet, .. } => snippet.as_deref(),
            _ => None,
        }
    }
}

/// Something in a [`crate::Scene`] that cannot be rendered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}: {message}")]
pub struct Problem {
    /// The part of the scene that is wrong: `camera`, `settings.depth`, `material "glass"`.
    pub what: String,
    /// What is wrong and what would be right.
    pub message: String,
}

impl Problem {
    pub(crate) fn new(what: impl Into<String>, message: impl Into<String>) -> Problem {
        Problem { what: one_line(what), message: one_line(message) }
    }
}

/// What the system says, without its number of the error.
pub(crate) fn system_words(reason: &io::Error) -> String {
    let words = reason.to_string();
    match words.rsplit_once(" (os error ") {
        Some((words, _)) => words.to_owned(),
        None => words,
    }
}

/// A number of bytes in words: binary units, and the exact number.
fn size(bytes: u64) -> String {
    const UNITS: [&str; 4] = ["KiB", "MiB", "GiB", "TiB"];
    let (mut value, mut unit) = (bytes as f64, None);
    for name in UNITS {
        if value < 1024.0 {
            break;
        }
        (value, unit) = (value / 1024.0, Some(name));
    }
    unit.map_or_else(|| format!("{bytes} bytes"), |unit| format!("{value:.1} {unit} ({bytes} bytes)"))
}

/// Messages quote files, which may hold anything: line ends and other control characters become blanks, and
/// what is endless is cut.
pub(crate) fn one_line(message: impl Into<String>) -> String {
    const MAX: usize = 2000;
    let mut message = message.into();
    if message.len() > MAX {
        let end = (0..=MAX).rev().find(|&i| message.is_char_boundary(i)).unwrap_or(0);
        message.truncate(end);
        message.push_str("...");
    }
    if message.contains(char::is_control) { message.replace(char::is_control, " ") } else { message }
}

/// Something odd in a file that did not stop it from being read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Where the odd thing was met first.
    pub place: Place,
    /// What is odd and what was done about it.
    pub message: String,
    /// How often it was met, 1 at least.
    pub count: u32,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)?;
        if self.count > 1 {
            write!(f, " ({} times in this file)", self.count)?;
        }
        Ok(())
    }
}
