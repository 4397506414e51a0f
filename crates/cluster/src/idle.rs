//! Waiting that costs next to no processor time, and next to no delay where things move.

use std::time::{Duration, Instant};

/// A look is one poll for messages. After a look that found something, so many follow without a pause.
const EAGER_LOOKS: u32 = 20;
/// A rest is this part of the time for which nothing has happened, so that no wait is longer by more than that.
const PART: u32 = 64;
const SHORTEST: Duration = Duration::from_micros(20);
/// 250 looks a second cost half a percent of a processor.
const LONGEST: Duration = Duration::from_millis(4);
/// While bytes are on their way: the library moves them only when it is called.
const LONGEST_MOVING: Duration = Duration::from_micros(50);

/// How long nothing has happened in a loop that looks for something.
pub(crate) struct Idle {
    looks: u32,
    since: Instant,
}

impl Idle {
    pub(crate) fn new() -> Idle {
        Idle { looks: 0, since: Instant::now() }
    }

    /// Waits before the next look. There is no wait if the last look found something (`moved`). Otherwise the wait
    /// grows with the time in which nothing has happened; its limit is lower while bytes are on their way (`moving`).
    /// `unpark` ends the wait.
    pub(crate) fn rest(&mut self, moved: bool, moving: bool) {
        if moved {
            *self = Idle::new();
            return;
        }
        self.looks += 1;
        if self.looks <= EAGER_LOOKS {
            std::thread::yield_now();
            return;
        }
        let longest = if moving { LONGEST_MOVING } else { LONGEST };
        std::thread::park_timeout((self.since.elapsed() / PART).clamp(SHORTEST, longest));
    }
}
