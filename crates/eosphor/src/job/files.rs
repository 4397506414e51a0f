//! Files by what they are, not by what they are called, and the folders that they go into.

use super::JobError;
use eosphor_picture::output::{OutputError, check_writable};
#[cfg(not(unix))]
use std::fs::canonicalize as identity_of;
use std::path::{Path, PathBuf};

/// Whether both names lead to one file that is there: through links of either kind or by different ways.
pub fn same_file(a: &Path, b: &Path) -> bool {
    identity_of(a).is_ok_and(|a| identity_of(b).is_ok_and(|b| a == b))
}

/// Whether both are names of one file, which need not be there yet, nor its folder.
pub fn same_place(a: &Path, b: &Path) -> bool {
    same_file(a, b) || resolved(a).is_some_and(|a| resolved(b).is_some_and(|b| a == b))
}

/// A path without links, as far as it is there.
fn resolved(path: &Path) -> Option<PathBuf> {
    let (folder, name) = (folder_of(path), path.file_name()?);
    let known = there(folder);
    let rest = folder.strip_prefix(known).unwrap_or(folder);
    Some(known.canonicalize().ok()?.join(rest).join(name))
}

/// The folder that a file lies in.
fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The part of a folder's path that is there.
fn there(folder: &Path) -> &Path {
    folder.ancestors().find(|folder| folder.exists()).unwrap_or(Path::new("."))
}

/// Fails where no picture can be written there, even with [`make_folder`]. Leaves nothing behind.
///
/// # Errors
///
/// [`OutputError::UnknownFormat`], [`OutputError::Write`].
pub fn check_output(file: &Path) -> Result<(), OutputError> {
    let (known, Some(name)) = (there(folder_of(file)), file.file_name()) else { return check_writable(file) };
    if known == folder_of(file) {
        return check_writable(file);
    }
    check_writable(&known.join(name)).map_err(|error| match error {
        OutputError::Write { source, .. } => OutputError::Write { path: file.to_owned(), source },
        error => error,
    })
}

/// Makes the folder of an output, where it is missing: once nothing is left that flags or scene could be wrong about.
///
/// # Errors
///
/// [`JobError::Folder`].
pub fn make_folder(file: &Path) -> Result<(), JobError> {
    let folder = folder_of(file);
    std::fs::create_dir_all(folder).map_err(|source| JobError::Folder { folder: folder.to_owned(), source })
}

/// Fails where one of the outputs is one of the files that the scene was read from
/// ([`eosphor_scene::LoadedScene::files_read`]), under whatever name.
///
/// # Errors
///
/// [`JobError::IsSource`].
pub fn check_sources(files_read: &[PathBuf], outputs: &[&Path]) -> Result<(), JobError> {
    for source_file in files_read {
        if let Some(output) = outputs.iter().find(|output| same_file(source_file, output)) {
            let (output, source_file) = (output.to_path_buf(), source_file.clone());
            return Err(JobError::IsSource { output, source_file });
        }
    }
    Ok(())
}

/// The shares of a picture that lie beside it, by their names.
pub(super) fn shares_beside(output: &Path) -> Result<Vec<PathBuf>, JobError> {
    let folder = folder_of(output);
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
    let entries =
        std::fs::read_dir(folder).map_err(|source| JobError::Search { folder: folder.to_owned(), source })?;
    let mut shares: Vec<PathBuf> =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_share).collect();
    shares.sort();
    match shares.is_empty() {
        true => Err(JobError::NoShares { output: output.to_owned() }),
        false => Ok(shares),
    }
}

/// Removes partial pictures of a still that is whole now. Those that are not there, or stay, do no harm.
pub(super) fn remove_all(files: &[PathBuf]) {
    files.iter().for_each(|file| drop(std::fs::remove_file(file)));
}

#[cfg(unix)]
fn identity_of(path: &Path) -> std::io::Result<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    std::fs::metadata(path).map(|data| (data.dev(), data.ino()))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn links_lead_to_the_same_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a"), "a").unwrap();
        fs::write(path("b"), "a").unwrap();
        fs::hard_link(path("a"), path("hard")).unwrap();
        std::os::unix::fs::symlink(path("a"), path("soft")).unwrap();
        for name in ["a", "hard", "soft"] {
            assert!(same_file(&path("a"), &path(name)), "{name}");
        }
        for name in ["b", "none"] {
            assert!(!same_file(&path("a"), &path(name)), "{name}");
        }
        assert!(!same_file(&path("none"), &path("none")));
        assert!(same_place(&path("none"), &path("./none")) && same_place(&path("a"), &path("hard")));
        assert!(!same_place(&path("a"), &path("b")) && !same_place(&path("none"), &path("nowhere/none")));
        assert!(same_place(&path("new/none"), &path("./new/none")));
        assert!(!same_place(&path("new/none"), &path("new/other")));
    }
}
