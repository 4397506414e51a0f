//! Calls of MPI that return only when all ranks have made them: what if one never does.

use crate::abort::end;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// When several ranks wait for one, rank 0 says so first, then rank 1, and the others only where these have not ended the job by
/// then. Open MPI takes more than a second for that.
const PATIENCE: Duration = Duration::from_millis(1500);

/// Makes such a call. Where it takes longer than `limit`, this process ends with a line that begins with `who`, and with it
/// the job: MPI itself would wait for ever for a process that is stopped.
pub(crate) fn patiently<T>(
    call: &'static str,
    limit: Option<Duration>,
    rank: u32,
    who: String,
    function: impl FnOnce() -> T,
) -> T {
    let Some(limit) = limit else { return function() };
    let limit = limit + PATIENCE * rank.min(2);
    let (_returned, has_returned) = channel();
    // Where there can be no thread, nobody watches.
    let _ = std::thread::Builder::new().spawn(move || {
        if is_longer(limit, &has_returned) {
            let seconds = limit.as_secs_f64();
            end(
                &who,
                &format!(
                    "{call} has waited for other ranks for {seconds:.1} s: is one stopped, or its host gone?"
                ),
                || {},
            );
        }
    });
    function()
}

/// Waits for the end of a call, and not for longer. Time in which this process itself was stopped is nobody's fault.
fn is_longer(limit: Duration, has_returned: &Receiver<()>) -> bool {
    let look = (limit / 20).clamp(Duration::from_millis(10), Duration::from_millis(250));
    let mut waited = Duration::ZERO;
    while waited <= limit {
        let start = Instant::now();
        match has_returned.recv_timeout(look) {
            Err(RecvTimeoutError::Timeout) => waited += start.elapsed().min(2 * look),
            _ => return false,
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_call_that_returns_is_let_be() {
        let limit = Some(Duration::from_secs(60));
        assert_eq!(patiently("MPI_Init_thread", limit, 1, "rank 1".into(), || 7), 7);
        assert_eq!(patiently("MPI_Init_thread", None, 1, "rank 1".into(), || 7), 7);
    }

    #[test]
    fn a_call_that_does_not_return_is_longer_than_any_limit() {
        let (_returned, has_returned) = channel();
        assert!(is_longer(Duration::from_millis(30), &has_returned));
    }
}
