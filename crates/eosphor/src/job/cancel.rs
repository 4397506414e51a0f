//! Asking a job to end early.

use std::sync::atomic::{AtomicBool, Ordering};

/// Asks a job to end early, from any thread, in two steps. One can be shared by many jobs; nothing takes it back.
#[derive(Debug, Default)]
pub struct Cancel {
    asked: AtomicBool,
    overdue: AtomicBool,
}

impl Cancel {
    /// A flag that is not raised: the job runs.
    pub const fn new() -> Cancel {
        Cancel { asked: AtomicBool::new(false), overdue: AtomicBool::new(false) }
    }

    /// The first step: nothing more is begun. What is in work of a still comes to its end, which takes some seconds at most,
    /// and all that is done is kept. Frames in work are given up.
    pub fn ask(&self) {
        self.asked.store(true, Ordering::SeqCst);
    }

    /// The second step: what is in work is given up, too. What was done before is kept all the same.
    pub fn give_up(&self) {
        self.ask();
        self.overdue.store(true, Ordering::SeqCst);
    }

    /// Whether the job has been asked to end.
    pub fn is_asked(&self) -> bool {
        self.asked.load(Ordering::SeqCst)
    }

    /// Raised by the first step, for [`crate::RenderControl::cancel`].
    pub fn asked(&self) -> &AtomicBool {
        &self.asked
    }

    /// Raised by the second step, for [`crate::RenderControl::cancel`].
    pub fn overdue(&self) -> &AtomicBool {
        &self.overdue
    }
}
