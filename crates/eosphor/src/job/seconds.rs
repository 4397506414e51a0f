//! The time that the phases of a job take.

use cpu_time::ProcessTime;
use std::time::Instant;

/// Wall-clock seconds of the phases of a still, and CPU seconds of rendering.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StillSeconds {
    /// The scene to flat arrays.
    pub flatten: f64,
    /// The hierarchy, and whatever else the device needs.
    pub build: f64,
    /// Seconds of tracing rays.
    pub render: f64,
    /// Finding what layers show. `None` where there are none.
    pub layers: Option<f64>,
    /// Developing, encoding, writing, and hashing the scene for the file.
    pub write: f64,
    /// CPU seconds of all threads of this process while rays were traced; `None` where the system does not say.
    pub render_cpu: Option<f64>,
}

/// CPU seconds of this process so far, of all its threads. `None` where the system does not say.
pub fn process_cpu_seconds() -> Option<f64> {
    ProcessTime::try_now().ok().map(|time| time.as_duration().as_secs_f64())
}

/// Calls `work` and adds the seconds that it took.
pub(super) fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    *seconds += start.elapsed().as_secs_f64();
    done
}
