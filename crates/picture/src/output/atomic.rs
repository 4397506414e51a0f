//! Files that are whole or not there: written beside their final name, flushed to the disk, then renamed.

use std::fs::{self, File};
use std::io::{Error, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file in the making. Dropped before [`TemporaryFile::keep`], it is removed, and what was under the final name before
/// stays.
pub(super) struct TemporaryFile {
    file: NamedTempFile,
    target: PathBuf,
}

impl TemporaryFile {
    /// An empty file in the folder of `path`.
    pub(super) fn beside(path: &Path) -> Result<TemporaryFile, Error> {
        let target = resolve(path)?;
        let file = temporary_beside(&target)?;
        take_rights_of(&target, file.as_file(), 0);
        Ok(TemporaryFile { file, target })
    }

    /// A temporary file for `path` that lies in another folder of the same file system until it is whole, so that what a
    /// killed program leaves is
    /// found there.
    pub(super) fn within(folder: &Path, path: &Path) -> Result<TemporaryFile, Error> {
        let target = resolve(path)?;
        let file = temporary_in(folder)?;
        take_rights_of(&target, file.as_file(), 0);
        Ok(TemporaryFile { file, target })
    }

    /// Gives it another final name, in the same folder.
    pub(super) fn rename(&mut self, path: &Path) -> Result<(), Error> {
        self.target = resolve(path)?;
        Ok(())
    }

    /// Where it is for now.
    pub(super) fn path(&self) -> &Path {
        self.file.path()
    }

    /// To write to. All handles share one position.
    pub(super) fn handle(&self) -> Result<File, Error> {
        self.file.as_file().try_clone()
    }

    /// Flushes it to the disk and renames it to its final name.
    pub(super) fn keep(self) -> Result<(), Error> {
        self.file.as_file().sync_all()?;
        self.file.persist(&self.target).map_err(|e| e.error)?;
        sync_folder(&self.target);
        Ok(())
    }
}

/// A file that replaces another, or holds what will, is for the same people: from the start, since it may be secret. Who may
/// read it may enter it, where it is a folder. The owner has the rights `for_owner` in any case. What the system does not allow
/// stays as it is for any new file.
#[cfg(unix)]
pub(crate) fn take_rights_of(target: &Path, file: &File, for_owner: u32) {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    let (Ok(old), Ok(new)) = (fs::metadata(target), file.metadata()) else { return };
    let mut mode = old.mode() & 0o777 | for_owner;
    if new.is_dir() {
        mode |= (mode & 0o444) >> 2;
    }
    let (owner, group) = (Some(old.uid()), Some(old.gid()));
    let is_same = (old.uid(), old.gid()) == (new.uid(), new.gid());
    if !is_same && fchown(file, owner, group).is_err() && fchown(file, None, group).is_err() {
        // Of another group now: it gets no more than everybody.
        let everybody = (mode & 0o007) << 3;
        mode &= !0o070 | everybody;
    }
    let _ = file.set_permissions(fs::Permissions::from_mode(mode));
}

#[cfg(not(unix))]
pub(crate) fn take_rights_of(_target: &Path, _file: &File, _for_owner: u32) {}

/// The mode to create a file with that gets the rights of another one then; `usual` where that one is not there. Nobody gets in
/// before that.
#[cfg(unix)]
pub(crate) fn mode_before_rights(target: &Path, usual: u32) -> u32 {
    if fs::metadata(target).is_ok() { usual & 0o700 } else { usual }
}

/// Writes a file that is whole or not there.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let file = TemporaryFile::beside(path)?;
    file.handle()?.write_all(bytes)?;
    file.keep()
}

/// Whether a file could be created at `path`. It leaves nothing behind.
pub(super) fn check(path: &Path) -> Result<(), Error> {
    temporary_beside(&resolve(path)?)?.close()
}

/// The file to replace: links are followed, so that a link stays one. Only ordinary files are replaced; renaming over
/// a device such as `/dev/null` would remove it.
pub(super) fn resolve(path: &Path) -> Result<PathBuf, Error> {
    if path.as_os_str().as_encoded_bytes().ends_with(b"/") {
        return Err(ErrorKind::IsADirectory.into());
    }
    let target = match fs::canonicalize(path) {
        Ok(target) => target,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            // Nothing is there, or a link to what is not there yet.
            let Ok(link) = fs::read_link(path) else { return Ok(path.to_owned()) };
            return Ok(path.parent().unwrap_or(Path::new("")).join(link));
        }
        Err(error) => return Err(error),
    };
    let kind = fs::metadata(&target)?.file_type();
    match () {
        _ if kind.is_dir() => Err(ErrorKind::IsADirectory.into()),
        _ if !kind.is_file() => Err(Error::other("this is a device, not a file; choose another name")),
        _ => Ok(target),
    }
}

fn temporary_beside(target: &Path) -> Result<NamedTempFile, Error> {
    let folder = match target.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    temporary_in(folder)
}

/// How names of temporary files begin and end.
pub(super) const TEMPORARY: (&str, &str) = (".eosphor-", ".part");

fn temporary_in(folder: &Path) -> Result<NamedTempFile, Error> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY.0).suffix(TEMPORARY.1);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The system takes the umask away from these when it creates the file.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    // tempfile's own error names the temporary path; the reason alone is wanted here.
    builder.tempfile_in(folder).map_err(|error| match error.raw_os_error().or(os_error_inside(&error)) {
        Some(code) => Error::from_raw_os_error(code),
        None => error.kind().into(),
    })
}

/// tempfile wraps the system's error in one of its own.
fn os_error_inside(error: &Error) -> Option<i32> {
    let source = std::error::Error::source(error.get_ref()?)?;
    source.downcast_ref::<Error>()?.raw_os_error()
}

/// A rename is on the disk only once its folder is. Some file systems cannot do this; the picture is there anyway.
fn sync_folder(target: &Path) {
    if let Some(folder) = target.parent() {
        let _ = File::open(folder).and_then(|folder| folder.sync_all());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        entries.collect()
    }

    fn write(path: &Path, bytes: &[u8]) {
        let file = TemporaryFile::beside(path).unwrap();
        file.handle().unwrap().write_all(bytes).unwrap();
        file.keep().unwrap();
    }

    #[test]
    fn what_is_not_kept_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let begun = || {
            let file = TemporaryFile::beside(&path).unwrap();
            file.handle().unwrap().write_all(&[0; 1 << 20]).unwrap();
            assert_eq!(file.path().parent(), path.parent());
            drop(file);
        };
        begun();
        assert!(names(folder.path()).is_empty());
        write(&path, b"old");
        begun();
        assert_eq!(names(folder.path()), ["a.png"]);
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }

    #[test]
    fn check_leaves_nothing_and_knows_folders() {
        let folder = tempfile::tempdir().unwrap();
        check(&folder.path().join("a.png")).unwrap();
        assert!(names(folder.path()).is_empty());
        let kind = |path: PathBuf| check(&path).unwrap_err().kind();
        assert_eq!(kind(folder.path().join("no/a.png")), ErrorKind::NotFound);
        assert_eq!(kind(folder.path().to_owned()), ErrorKind::IsADirectory);
    }

    #[cfg(unix)]
    #[test]
    fn modes_are_those_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (plain, ours) = (folder.path().join("plain"), folder.path().join("ours"));
        fs::write(&plain, b"").unwrap();
        write(&ours, b"x");
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&plain), mode(&ours));
    }

    #[cfg(unix)]
    #[test]
    fn what_is_overwritten_keeps_its_mode() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        for mode in [0o600, 0o640, 0o664, 0o755] {
            fs::write(&path, b"old").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            let file = TemporaryFile::beside(&path).unwrap();
            // Nobody else may look at it while it is in the making, either.
            let mode_of = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
            assert_eq!(mode_of(file.path()), mode);
            file.keep().unwrap();
            assert_eq!(mode_of(&path), mode);
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links_and_devices_stay_devices() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, b"old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write(&link, b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");

        let (absent, early) = (folder.path().join("absent"), folder.path().join("early"));
        std::os::unix::fs::symlink("absent", &early).unwrap();
        write(&early, b"new");
        assert!(fs::symlink_metadata(&early).unwrap().is_symlink());
        assert_eq!(fs::read(&absent).unwrap(), b"new");

        let null = folder.path().join("null.png");
        std::os::unix::fs::symlink("/dev/null", &null).unwrap();
        assert!(check(&null).unwrap_err().to_string().contains("device"));
    }
}
