//! `eosphor completions SHELL`.

use crate::arguments::{Arguments, CompletionsFlags};
use crate::failure::Failure;
use crate::streams;

pub(crate) fn completions(flags: &CompletionsFlags) -> Result<(), Failure> {
    // Into memory first: clap_complete panics where a pipe is closed.
    let mut script = Vec::new();
    clap_complete::generate(flags.shell, &mut Arguments::described(), "eosphor", &mut script);
    streams::result(&String::from_utf8_lossy(&script))
}
