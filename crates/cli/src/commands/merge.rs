//! `eosphor merge SHARE... -o OUT`.

use crate::arguments::MergeFlags;
use crate::failure::Failure;
use crate::streams;
use eosphor::job::{self, JobError};

pub(crate) fn merge(flags: &MergeFlags) -> Result<(), Failure> {
    let count = job::merge(&flags.shares, &flags.output).map_err(|error| match error {
        JobError::Output(error) => Failure::of_output(error),
        error => error.into(),
    })?;
    if !flags.quiet {
        streams::message(&format!("{}: of {count} shares", flags.output.display()));
    }
    Ok(())
}
