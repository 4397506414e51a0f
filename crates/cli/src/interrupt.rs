//! Ctrl-C: the first asks the render to end and keeps what is done, the second ends the program at once.

use crate::failure::Failure;
use crate::streams::Verbosity;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// A file in the making, which the second Ctrl-C removes.
static UNFINISHED: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Watches for Ctrl-C from now on.
pub(crate) fn watch(verbosity: Verbosity) -> Result<(), Failure> {
    let handler = move || {
        if INTERRUPTED.swap(true, Ordering::SeqCst) {
            if let Ok(Some(file)) = UNFINISHED.lock().as_deref() {
                // It may have got its final name just now.
                let _ = std::fs::remove_file(file);
            }
            std::process::exit(130);
        }
        let line = "eosphor: interrupting; keeping what is done (Ctrl-C again to end at once)";
        verbosity.say(Verbosity::Normal, line);
    };
    ctrlc::set_handler(handler).map_err(|error| Failure::Failed(format!("cannot watch for Ctrl-C: {error}")))
}

/// Names the file in the making.
pub(crate) fn note_unfinished(file: &Path) {
    *UNFINISHED.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = Some(file.to_owned());
}

/// Raised by Ctrl-C.
pub(crate) fn flag() -> &'static AtomicBool {
    &INTERRUPTED
}

/// Ends a command between two phases.
pub(crate) fn check() -> Result<(), Failure> {
    match INTERRUPTED.load(Ordering::SeqCst) {
        true => {
            Err(Failure::Interrupted("interrupted before the first pixel; no picture was written".into()))
        }
        false => Ok(()),
    }
}

/// Where the system limits the size of files (`ulimit -f`), writing fails with an error instead of ending the program,
/// which would leave a part of a file behind.
pub(crate) fn report_file_size_limits() {
    #[cfg(unix)]
    // SAFETY: no other thread runs yet, and ignoring a signal runs no code.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}
