//! Where the standard test scenes are.

use std::io::Write;
use std::path::PathBuf;

/// The folder of test scenes beside the checkout. A clone alone does not have it: then the test is skipped, and says so
/// even where the harness keeps what passing tests print to itself.
pub(crate) fn scenes() -> Option<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes");
    if folder.is_dir() {
        return Some(folder);
    }
    let test = std::thread::current().name().unwrap_or_default().to_string();
    let line = format!("SKIPPED {test}: {} is not there\n", folder.display());
    let _ = std::io::stderr().write_all(line.as_bytes());
    None
}
