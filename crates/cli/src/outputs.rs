//! Where a picture goes, as the command line says it.

use crate::failure::Failure;
use eosphor::Format;
use eosphor::job::{Output, check_apart, check_writable};
use std::io::{IsTerminal, stdout};
use std::path::{Path, PathBuf};

/// What stands for standard output.
const STDOUT: &str = "-";

/// Whether an output is standard output.
pub(crate) fn is_stdout(output: &Path) -> bool {
    output.as_os_str() == STDOUT
}

/// Each place once; `format` was asked for standard output.
pub(crate) fn outputs(paths: &[PathBuf], format: Option<Format>) -> Result<Vec<Output>, Failure> {
    let output = |path: &PathBuf| match is_stdout(path) {
        true => Ok(Output::Stream {
            name: "standard output".into(),
            format: format.unwrap_or(Format::Png),
            stream: Box::new(stdout()),
        }),
        false => Output::file(path).map_err(Failure::of_output),
    };
    let outputs = paths.iter().map(output).collect::<Result<Vec<Output>, Failure>>()?;
    check_apart(&outputs)?;
    Ok(outputs)
}

/// Fails where nothing can be written.
pub(crate) fn check(outputs: &[Output]) -> Result<(), Failure> {
    if outputs.iter().any(|output| output.path().is_none()) && stdout().is_terminal() {
        return Err(Failure::Usage(
            "-o -: standard output is a terminal: lead it into a pipe or a file, as in -o - > picture.png"
                .into(),
        ));
    }
    Ok(check_writable(outputs)?)
}

/// Names of several, for messages.
pub(crate) fn names<T: ToString>(all: impl IntoIterator<Item = T>) -> String {
    all.into_iter().map(|one| one.to_string()).collect::<Vec<String>>().join(", ")
}
