//! Wall time and the CPU time of the process, in milliseconds.

use std::time::Instant;

pub(crate) struct Clock {
    wall: Instant,
    cpu: f64,
}

impl Clock {
    pub fn start() -> Self {
        Self { cpu: process_milliseconds(), wall: Instant::now() }
    }

    /// Since the start: wall, CPU.
    pub fn read(&self) -> (f64, f64) {
        let wall = self.wall.elapsed().as_secs_f64() * 1e3;
        (wall, process_milliseconds() - self.cpu)
    }
}

/// On a machine with other work, CPU time is steadier than wall time. All threads count, a library's own too.
fn process_milliseconds() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `time` is a valid place to write to.
    let status = unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &mut time) };
    assert_eq!(status, 0, "the system has no clock for the CPU time of a process");
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}
