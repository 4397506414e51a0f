//! The end of a job that cannot go on.

use crate::mpi::{Handle, Mpi};
use std::backtrace::{Backtrace, BacktraceStatus};
use std::ffi::c_int;
use std::io::Write;
use std::panic::PanicHookInfo;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How long the launcher has to read our line before MPI kills the processes.
const TIME_TO_READ: Duration = Duration::from_millis(100);
/// How long MPI has for that before this process ends by itself, at which the launcher ends the others.
const TIME_TO_ABORT: Duration = Duration::from_secs(2);

/// Ends all processes of a job, from any thread.
#[derive(Clone)]
pub struct Abort(Arc<Job>);

struct Job {
    rank: u32,
    size: u32,
    host: String,
    abort: unsafe extern "C" fn(Handle, c_int) -> c_int,
    world: Handle,
    /// Whether MPI has ended already, so that it must not be called.
    is_over: AtomicBool,
}

impl Job {
    fn who(&self) -> String {
        let Job { rank, size, host, .. } = self;
        format!("rank {rank} of {size} on {host}")
    }
}

impl Abort {
    pub(crate) fn new(mpi: &Mpi) -> Abort {
        Abort(Arc::new(Job {
            rank: mpi.rank,
            size: mpi.size,
            host: mpi.host.clone(),
            abort: mpi.functions.abort,
            world: mpi.constants.world,
            is_over: AtomicBool::new(false),
        }))
    }

    pub(crate) fn set_over(&self) {
        self.0.is_over.store(true, Ordering::SeqCst);
    }

    /// Prints one line to stderr, with this rank, its host and the reason, and ends all processes of the job. Of several
    /// threads that call it the first does so.
    pub fn now(&self, reason: &str) -> ! {
        end(&self.0.who(), reason, || {
            if !self.0.is_over.load(Ordering::SeqCst) {
                // SAFETY: MPI has started and not ended; the call is made once, and the process ends whether it returns
                // or not.
                unsafe { (self.0.abort)(self.0.world, 1) };
            }
        })
    }

    /// This rank and its host, in words.
    pub(crate) fn who(&self) -> String {
        self.0.who()
    }

    /// From now on a panic, in any thread, ends the job with its message and place. Also with its backtrace where
    /// RUST_BACKTRACE asks for one.
    pub fn on_panic(&self) {
        let abort = self.clone();
        std::panic::set_hook(Box::new(move |panic| abort.now(&panic_text(panic))));
    }
}

fn panic_text(panic: &PanicHookInfo) -> String {
    let place = panic.location().map_or_else(String::new, |place| format!(" at {place}"));
    let message = panic.payload_as_str().unwrap_or("no message");
    let mut text = format!("panic{place}: {message}");
    let backtrace = Backtrace::capture();
    if backtrace.status() == BacktraceStatus::Captured {
        text.push_str(&format!("\n{backtrace}"));
    }
    text
}

/// Prints one line to stderr, gives `abort` a while to end all processes, and ends this one, which ends the others, too. Of
/// several threads that call it the first does so.
pub(crate) fn end(who: &str, reason: &str, abort: impl FnOnce()) -> ! {
    static IS_ENDING: AtomicBool = AtomicBool::new(false);
    if IS_ENDING.swap(true, Ordering::SeqCst) {
        loop {
            std::thread::park();
        }
    }
    // MPI promises nothing for a thread that is not its own: it may wait for a lock for ever.
    let _ = std::thread::Builder::new().spawn(|| {
        std::thread::sleep(TIME_TO_READ + TIME_TO_ABORT);
        exit();
    });
    // One write, so that lines of several ranks do not mix.
    let _ = std::io::stderr().write_all(format!("error: {who}: {}\n", reason.trim_end()).as_bytes());
    std::thread::sleep(TIME_TO_READ);
    abort();
    exit();
}

/// Ends this process at once, without the code that runs at a usual end and might wait for another thread.
fn exit() -> ! {
    // SAFETY: _exit takes a number, touches no memory of this program, and does not return.
    unsafe { libc::_exit(1) }
}
