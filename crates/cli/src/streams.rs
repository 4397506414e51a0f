//! Writing to stdout and stderr. Neither may panic: a pipe may be closed and a disk may be full.

use crate::failure::Failure;
use eosphor::explain;
use serde::Serialize;
use std::io::{ErrorKind, Write, stderr, stdout};

/// A result. A closed pipe (`| head`) is no failure: nobody wants the rest.
pub(crate) fn result(text: &str) -> Result<(), Failure> {
    let mut out = stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Failed(format!("cannot write the result: stdout: {}", explain(&error))))
        }
        _ => Ok(()),
    }
}

/// A result for programs.
pub(crate) fn json(value: &impl Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(value).map_err(Failure::because)?;
    text.push('\n');
    result(&text)
}

/// The line that says why the program failed.
pub(crate) fn error(line: &str) {
    message(&format!("eosphor: {line}"));
}

/// A line on stderr.
pub(crate) fn message(line: &str) {
    let _ = writeln!(stderr().lock(), "{line}");
}

/// How much is said on stderr besides failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Verbosity {
    /// Nothing.
    Quiet,
    /// Warnings, progress and statistics.
    Normal,
    /// And every note, and the files that were read.
    Verbose,
}

impl Verbosity {
    /// A line at this level and above.
    pub(crate) fn say(self, at_least: Verbosity, line: &str) {
        if self >= at_least {
            message(line);
        }
    }
}
