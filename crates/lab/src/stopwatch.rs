//! Times as processes measure them: of a clock on the wall, and of cores.

#[cfg(unix)]
use nix::time::{ClockId, clock_gettime};
use std::time::Instant;

/// A repetition that is being timed.
pub struct Stopwatch {
    start: Instant,
    cpu: Option<f64>,
}

/// The times of repetitions, in milliseconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Times {
    /// Of a clock on the wall.
    pub wall: Vec<f64>,
    /// Of cores, summed over them; empty where the system does not tell.
    pub cpu: Vec<f64>,
}

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Stopwatch {
        Stopwatch { cpu: cpu_milliseconds(), start: Instant::now() }
    }

    /// Adds the time since the start.
    pub fn stop(self, times: &mut Times) {
        let wall = self.start.elapsed().as_secs_f64() * 1e3;
        times.wall.push(wall);
        times.cpu.extend(self.cpu.zip(cpu_milliseconds()).map(|(before, after)| after - before));
    }
}

/// Milliseconds of cores that this process has taken.
#[cfg(unix)]
fn cpu_milliseconds() -> Option<f64> {
    let time = clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID).ok()?;
    Some(time.tv_sec() as f64 * 1e3 + time.tv_nsec() as f64 * 1e-6)
}

#[cfg(not(unix))]
fn cpu_milliseconds() -> Option<f64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_takes_time_of_the_wall_and_none_of_cores() {
        let mut times = Times::default();
        let watch = Stopwatch::start();
        std::thread::sleep(std::time::Duration::from_millis(30));
        watch.stop(&mut times);
        assert!(times.wall[0] >= 30.0, "{times:?}");
        // Other tests of this process take some.
        assert!(times.cpu.iter().all(|&cpu| cpu >= 0.0));
    }
}
