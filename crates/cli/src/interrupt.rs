//! Signals that ask the program to end: Ctrl-C, SIGTERM (Slurm, systemd, docker, `timeout`) and SIGHUP (a terminal that is
//! closed). The first asks the render to end and keeps what is done. A second Ctrl-C ends the program at once; of the others
//! a second one changes nothing, because senders repeat them.

use crate::failure::Failure;
use crate::first_signal::FIRST;
use crate::streams::Verbosity;
use eosphor::job::Cancel;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Asked by the first signal, and some time after that for the second time.
static CANCEL: Cancel = Cancel::new();

/// How long what is in work when a signal comes may take to its end. Whoever sends SIGTERM waits for some seconds.
const GRACE: Duration = Duration::from_secs(4);

/// The number of Ctrl-C, on every system.
const CTRL_C: u8 = 2;

/// Files in the making, which the second Ctrl-C removes.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Watches for signals from now on.
#[cfg(unix)]
pub(crate) fn watch(verbosity: Verbosity) -> Result<(), Failure> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let cannot = |error| Failure::Failed(format!("cannot watch for signals: {error}"));
    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| !is_ignored(signal));
    let mut signals = signal_hook::iterator::Signals::new(wanted).map_err(cannot)?;
    let watcher = move || signals.forever().for_each(|signal| asked_to_end(signal as u8, verbosity));
    std::thread::Builder::new().name("signals".into()).spawn(watcher).map(drop).map_err(cannot)
}

/// Whether whoever started the program wants the signal to be ignored, as `nohup` does.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    // SAFETY: all zeros are a valid action, and nothing is changed where there is no new one.
    unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        libc::sigaction(signal, std::ptr::null(), &mut action) == 0 && action.sa_sigaction == libc::SIG_IGN
    }
}

/// Watches for Ctrl-C from now on.
#[cfg(not(unix))]
pub(crate) fn watch(verbosity: Verbosity) -> Result<(), Failure> {
    ctrlc::set_handler(move || asked_to_end(CTRL_C, verbosity))
        .map_err(|error| Failure::Failed(format!("cannot watch for Ctrl-C: {error}")))
}

fn asked_to_end(signal: u8, verbosity: Verbosity) {
    if FIRST.compare_exchange(0, signal, Ordering::SeqCst, Ordering::SeqCst).is_err() {
        if signal != CTRL_C {
            return;
        }
        for file in UNFINISHED.lock().iter().flat_map(|files| files.iter()) {
            // It may have got its final name just now.
            let _ = std::fs::remove_file(file);
        }
        std::process::exit(128 + i32::from(signal));
    }
    CANCEL.ask();
    let overdue = || {
        std::thread::sleep(GRACE);
        CANCEL.give_up();
    };
    if std::thread::Builder::new().spawn(overdue).is_err() {
        CANCEL.give_up();
    }
    let why = match signal {
        CTRL_C => "interrupting",
        1 => "the terminal is gone (SIGHUP)",
        _ => "asked to end (SIGTERM)",
    };
    let line = format!(
        "eosphor: {why}; keeping what is done (Ctrl-C{} to end at once)",
        match signal {
            CTRL_C => " again",
            _ => "",
        }
    );
    verbosity.say(Verbosity::Normal, &line);
}

/// Names a file in the making.
pub(crate) fn note_unfinished(file: &Path) {
    UNFINISHED.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(file.to_owned());
}

/// How signals cancel a job. The first signal asks that nothing more is begun. Work that is not done `GRACE` later is
/// given up.
pub(crate) fn cancel() -> &'static Cancel {
    &CANCEL
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
