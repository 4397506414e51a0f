//! Files by what they are, not by what they are called.

#[cfg(not(unix))]
use std::fs::canonicalize as identity_of;
use std::path::{Path, PathBuf};

/// Whether both names lead to one file that is there: through links of either kind or by different ways.
pub(crate) fn same_file(a: &Path, b: &Path) -> bool {
    identity_of(a).is_ok_and(|a| identity_of(b).is_ok_and(|b| a == b))
}

/// Whether both are names of one file, which need not be there yet.
pub(crate) fn same_place(a: &Path, b: &Path) -> bool {
    let folder = |path: &Path| match path.parent() {
        Some(folder) if folder != Path::new("") => folder.to_owned(),
        _ => PathBuf::from("."),
    };
    same_file(a, b) || (a.file_name() == b.file_name() && same_file(&folder(a), &folder(b)))
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
    }
}
