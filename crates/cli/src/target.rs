//! Where a picture goes: files, or standard output.

use crate::failure::Failure;
use crate::files::{check_output, make_folder, same_place};
use crate::interrupt;
use eosphor::{Format, OutputError, PictureWriter, SaveOptions};
use std::fmt;
use std::io::{IsTerminal, stdout};
use std::path::{Path, PathBuf};

/// What stands for standard output.
const STDOUT: &str = "-";

/// Where a picture goes, and how it is written there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// A file, whose name says the format.
    File(PathBuf, Format),
    /// Standard output, which gets a picture when it is whole.
    Stdout(Format),
}

/// Whether an output is standard output.
pub(crate) fn is_stdout(output: &Path) -> bool {
    output.as_os_str() == STDOUT
}

impl Target {
    /// Of an output as it was given, and the format that was asked for standard output.
    pub(crate) fn new(output: &Path, format: Option<Format>) -> Result<Target, Failure> {
        match is_stdout(output) {
            true => Ok(Target::Stdout(format.unwrap_or(Format::Png))),
            false => Ok(Target::File(output.to_owned(), Format::of(output).map_err(Failure::of_output)?)),
        }
    }

    pub(crate) fn format(&self) -> Format {
        match self {
            Target::File(_, format) | Target::Stdout(format) => *format,
        }
    }

    /// The file, if it is one.
    pub(crate) fn file(&self) -> Option<&Path> {
        match self {
            Target::File(path, _) => Some(path),
            Target::Stdout(_) => None,
        }
    }

    /// Fails where nothing can be written there.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        match self {
            Target::File(path, _) => Ok(check_output(path)?),
            Target::Stdout(_) if stdout().is_terminal() => Err(Failure::Usage(
                "-o -: standard output is a terminal: lead it into a pipe or a file, as in -o - > picture.png".into(),
            )),
            Target::Stdout(_) => Ok(()),
        }
    }

    /// Makes its folder, where that is missing.
    pub(crate) fn make_folder(&self) -> Result<(), Failure> {
        self.file().map_or(Ok(()), make_folder)
    }

    /// Begins a picture.
    pub(crate) fn open(&self, size: (u32, u32), options: &SaveOptions) -> Result<PictureWriter, OutputError> {
        let writer = match self {
            Target::File(path, _) => PictureWriter::open(path, size, options)?,
            Target::Stdout(format) => {
                let name = Path::new("standard output");
                PictureWriter::open_stream(Box::new(stdout()), name, *format, size, options)?
            }
        };
        if let Some(path) = writer.temporary_path() {
            interrupt::note_unfinished(path);
        }
        Ok(writer)
    }
}

/// Where a picture goes, each place once.
pub(crate) fn targets(outputs: &[PathBuf], format: Option<Format>) -> Result<Vec<Target>, Failure> {
    let targets =
        outputs.iter().map(|output| Target::new(output, format)).collect::<Result<Vec<Target>, Failure>>()?;
    for (number, target) in targets.iter().enumerate() {
        let is_same = |other: &&Target| match (target.file(), other.file()) {
            (Some(one), Some(other)) => same_place(one, other),
            (one, other) => one.is_none() && other.is_none(),
        };
        if let Some(other) = targets[..number].iter().find(is_same) {
            let message = format!("-o: {other} and {target} are the same: name it once");
            return Err(Failure::Usage(message));
        }
    }
    Ok(targets)
}

/// Names of several, for messages.
pub(crate) fn names<T: ToString>(all: impl IntoIterator<Item = T>) -> String {
    all.into_iter().map(|one| one.to_string()).collect::<Vec<String>>().join(", ")
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Target::File(path, _) => path.display().fmt(f),
            Target::Stdout(_) => f.write_str("standard output"),
        }
    }
}
