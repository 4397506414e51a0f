//! Follows the files of a scene: when one of them changes, the scene is read again. Devices that pages ask for are opened here,
//! too, since that takes time.

use crate::renderer::Shared;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, SystemTime};

/// Between two looks at the files.
const PAUSE: Duration = Duration::from_millis(250);

/// What tells that a file has changed.
type Mark = Option<(SystemTime, u64)>;

fn marks(files: &[PathBuf]) -> Vec<Mark> {
    let mark = |path: &PathBuf| {
        let metadata = std::fs::metadata(path).ok()?;
        Some((metadata.modified().ok()?, metadata.len()))
    };
    files.iter().map(mark).collect()
}

/// Looks at the files, and for what pages ask, until the viewer ends.
pub(crate) fn watch(shared: &Shared) {
    let mut files = shared.stage().files.clone();
    let mut seen = marks(&files);
    while !shared.is_over.load(Ordering::Relaxed) {
        std::thread::sleep(PAUSE);
        shared.switch_device();
        let now = marks(&files);
        if now == seen {
            continue;
        }
        // An editor may still be writing: read when nothing has changed for a while.
        seen = now;
        std::thread::sleep(PAUSE);
        let now = marks(&files);
        if now != seen {
            // The next look finds the change again.
            seen = vec![None; files.len()];
            continue;
        }
        shared.read_again();
        let read = shared.stage().files.clone();
        // Marks from before the reading: what has changed since is found at the next look.
        seen = if read == files { now } else { marks(&read) };
        files = read;
    }
}
