//! The threads of a rank that compute.

use crate::abort::Abort;
use crate::job::Compute;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Condvar, Mutex, PoisonError};
use std::thread::Thread;
use std::time::Instant;

/// A unit that was computed.
pub(crate) struct Done {
    pub(crate) unit: u64,
    pub(crate) result: Vec<u8>,
    pub(crate) seconds: f64,
}

/// Units for the threads of this rank, and their results.
pub(crate) struct Crew<'a> {
    compute: Compute<'a>,
    abort: Abort,
    /// The thread that calls MPI, which sleeps while nothing happens.
    messenger: Thread,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    next: VecDeque<(u64, Vec<u8>)>,
    done: Vec<Done>,
    is_closed: bool,
}

impl<'a> Crew<'a> {
    /// For the calling thread.
    pub(crate) fn new(compute: Compute<'a>, abort: Abort) -> Crew<'a> {
        let messenger = std::thread::current();
        Crew { compute, abort, messenger, state: Mutex::default(), changed: Condvar::new() }
    }

    /// A unit to compute.
    pub(crate) fn push(&self, unit: u64, description: Vec<u8>) {
        self.lock().next.push_back((unit, description));
        self.changed.notify_one();
    }

    /// Units that were computed since the last call.
    pub(crate) fn take_done(&self) -> Vec<Done> {
        std::mem::take(&mut self.lock().done)
    }

    /// When what this gives is dropped, threads end after the unit that they are at.
    pub(crate) fn closing(&self) -> impl Drop + use<'_, 'a> {
        struct Closing<'c, 'a>(&'c Crew<'a>);
        impl Drop for Closing<'_, '_> {
            fn drop(&mut self) {
                self.0.lock().is_closed = true;
                self.0.changed.notify_all();
            }
        }
        Closing(self)
    }

    /// What a thread of the crew does.
    pub(crate) fn work(&self) {
        while let Some((unit, description)) = self.next() {
            let start = Instant::now();
            let result =
                run_or_abort(&self.abort, &format!("unit {unit}"), || (self.compute)(unit, &description));
            let seconds = start.elapsed().as_secs_f64();
            self.lock().done.push(Done { unit, result, seconds });
            self.messenger.unpark();
        }
    }

    fn next(&self) -> Option<(u64, Vec<u8>)> {
        let wait = |state: &mut State| state.next.is_empty() && !state.is_closed;
        let state = self.changed.wait_while(self.lock(), wait);
        state.unwrap_or_else(PoisonError::into_inner).next.pop_front()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What a function of the caller gives. Its error or panic ends the job.
pub(crate) fn run_or_abort<T>(abort: &Abort, doing: &str, run: impl FnOnce() -> Result<T, String>) -> T {
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(value)) => value,
        Ok(Err(reason)) => abort.now(&format!("{doing}: {reason}")),
        // The panic hook has printed the message and the place.
        Err(_) => abort.now(&format!("{doing}: panic: its message stands above")),
    }
}
