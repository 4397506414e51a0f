//! The signal that ended the program, for its exit code.

use std::process::ExitCode;
use std::sync::atomic::{AtomicU8, Ordering};

/// The number of the signal that came first; 0 before.
pub(crate) static FIRST: AtomicU8 = AtomicU8::new(0);

/// What the shell is told of a program that a signal ended: 128 and the signal's number.
pub(crate) fn exit_code() -> ExitCode {
    ExitCode::from(128 + FIRST.load(Ordering::SeqCst))
}
