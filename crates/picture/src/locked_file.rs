//! A file that is locked for as long as it is open here.

use std::fs::File;
use std::ops::{Deref, DerefMut};

/// A file that this process has locked, or the only one to have it where the file system has no locks.
///
/// It is unlocked before it is closed. Closing alone is not enough: a child process that another thread is starting has
/// every open file too, until it runs its own program, and the lock would last until then.
pub(crate) struct LockedFile(File);

impl LockedFile {
    /// Takes charge of a file that was just locked.
    pub(crate) fn of(file: File) -> LockedFile {
        LockedFile(file)
    }
}

impl Deref for LockedFile {
    type Target = File;

    fn deref(&self) -> &File {
        &self.0
    }
}

impl DerefMut for LockedFile {
    fn deref_mut(&mut self) -> &mut File {
        &mut self.0
    }
}

impl Drop for LockedFile {
    fn drop(&mut self) {
        // Where there are no locks, there is nothing to do.
        let _ = self.0.unlock();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_a_child_still_has_open_is_free_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        let open = || File::options().create(true).truncate(false).write(true).open(&path).unwrap();
        let file = open();
        file.try_lock().unwrap();
        // As a child has it: the same open file.
        let of_a_child = file.try_clone().unwrap();
        drop(LockedFile::of(file));
        open().try_lock().unwrap();
        drop(of_a_child);
    }
}
