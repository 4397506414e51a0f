//! `eosphor merge SHARE... -o OUT`.

use crate::arguments::MergeFlags;
use crate::failure::Failure;
use crate::streams;
use eosphor::job::{check_output, make_folder};
use eosphor::near_name;
use eosphor::shares::merge as merge_shares;
use eosphor::still::merge_samples;
use std::path::{Path, PathBuf};

pub(crate) fn merge(flags: &MergeFlags) -> Result<(), Failure> {
    let shares = match flags.shares.is_empty() {
        true => shares_beside(&flags.output)?,
        false => flags.shares.clone(),
    };
    let is_sums = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "sums");
    check_output(&flags.output).map_err(Failure::of_output)?;
    if let Some(missing) = shares.iter().find(|share| !share.exists()) {
        let near = near_name(missing).map(|near| format!("did you mean {near}?"));
        let advice = near.unwrap_or_else(|| "check the path of the share".into());
        let message = format!("{}: no such file: {advice}", missing.display());
        return Err(Failure::Failed(message));
    }
    make_folder(&flags.output)?;
    match (shares.iter().any(is_sums), shares.iter().all(is_sums)) {
        (false, _) => merge_shares(&shares, &flags.output).map_err(Failure::because)?,
        (_, true) => merge_samples(&shares, &flags.output).map_err(Failure::because)?,
        _ => {
            let message = "these are shares of rows (.share) and of samples (.sums): name those of one kind";
            return Err(Failure::Usage(message.into()));
        }
    }
    if !flags.quiet {
        streams::message(&format!("{}: of {} shares", flags.output.display(), shares.len()));
    }
    Ok(())
}

/// The shares of a picture, by their names.
fn shares_beside(output: &Path) -> Result<Vec<PathBuf>, Failure> {
    let folder = output.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    // Bytes, for names need not be Unicode.
    let begin = [output.file_name().unwrap_or_default().as_encoded_bytes(), b"."].concat();
    let is_share = |path: &PathBuf| {
        let other = path.file_name().unwrap_or_default().as_encoded_bytes();
        let rest = other.strip_prefix(&begin[..]).and_then(|rest| std::str::from_utf8(rest).ok());
        let Some(rest) = rest else { return false };
        let of_rows = rest.strip_suffix(".share").and_then(|numbers| numbers.split_once("-of-"));
        let of_samples = || rest.strip_suffix(".sums").and_then(|numbers| numbers.split_once('-'));
        of_rows.or_else(of_samples).is_some_and(|(k, n)| k.parse::<u32>().is_ok() && n.parse::<u32>().is_ok())
    };
    let cannot = |error| Failure::Failed(format!("cannot look for shares in {}: {error}", folder.display()));
    let entries = std::fs::read_dir(folder).map_err(cannot)?;
    let mut shares: Vec<PathBuf> =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_share).collect();
    shares.sort();
    match shares.is_empty() {
        true => Err(Failure::Failed(format!(
            "there are no shares of {}: render them with --tiles 1/N to --tiles N/N, or with --sample-range, or name \
             their files",
            output.display()
        ))),
        false => Ok(shares),
    }
}
