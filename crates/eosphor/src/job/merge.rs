//! The picture that shares of it make.

use super::JobError;
use super::files::{check_output, make_folder, shares_beside};
use eosphor_picture::output::merge as merge_rows;
use eosphor_picture::still::merge_samples;
use std::path::{Path, PathBuf};

/// Writes the picture that shares of it make ([`crate::job::Share`]), as one job would have written it. Where none are named,
/// they are those beside the output that have its name. Its folder is made where it is missing. How many shares it has.
///
/// # Errors
///
/// Where the output cannot be written, shares are missing, not whole, of several kinds or of different pictures.
pub fn merge(shares: &[PathBuf], output: &Path) -> Result<usize, JobError> {
    let found = match shares.is_empty() {
        true => shares_beside(output)?,
        false => Vec::new(),
    };
    let shares = if shares.is_empty() { &found } else { shares };
    let is_sums = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "sums");
    check_output(output)?;
    if let Some(missing) = shares.iter().find(|share| !share.exists()) {
        return Err(JobError::NoSuchShare { path: missing.clone() });
    }
    make_folder(output)?;
    match (shares.iter().any(is_sums), shares.iter().all(is_sums)) {
        (false, _) => merge_rows(shares, output)?,
        (true, true) => merge_samples(shares, output)?,
        (true, false) => return Err(JobError::MixedShares),
    }
    Ok(shares.len())
}
