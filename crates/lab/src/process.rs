//! A fresh process that measures, and what else ran meanwhile.

use crate::load::{Load, core_times};
use crate::quantity::{Quantity, read_quantities};
#[cfg(target_os = "linux")]
use nix::sched::{CpuSet, sched_getaffinity, sched_setaffinity};
#[cfg(unix)]
use nix::sys::resource::{UsageWho, getrusage};
#[cfg(unix)]
use nix::sys::time::TimeVal;
#[cfg(target_os = "linux")]
use nix::unistd::Pid;
use serde::{Deserialize, Serialize};
use std::ffi::OsString;
use std::io::Read;
use std::process::{Command, Stdio};
use std::time::Instant;

/// A process that has measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Measured {
    /// What it printed.
    pub quantities: Vec<Quantity>,
    /// How long it ran, with all that it did besides.
    pub wall_seconds: f64,
    /// The time that it took of cores.
    pub cpu_seconds: f64,
    /// What else ran; where the system does not tell, nothing.
    pub load: Option<Load>,
}

/// The most bytes that are read of what a process prints.
const MAX_OUTPUT: u64 = 4 << 20;

/// Runs a program on these cores.
///
/// # Errors
///
/// Why there is no measurement, in a line.
pub fn measure(program: &OsString, arguments: &[String], cores: &[usize]) -> Result<Measured, String> {
    let everything = allowed_cores();
    stay_on(cores)?;
    let (before, children, start) = (core_times(cores), seconds_of_children(), Instant::now());
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let spawned = command.spawn();
    // A process keeps the cores that it was started on; this one may use all of its own again.
    stay_on(&everything)?;
    let mut child = spawned.map_err(|error| format!("cannot run {}: {error}", program.display()))?;
    // Each on a thread of its own, so that neither fills its pipe while the other is read.
    let errors = child.stderr.take().map(|pipe| std::thread::spawn(move || read(pipe)));
    let output = child.stdout.take().map(read).unwrap_or_default();
    let errors = errors.and_then(|thread| thread.join().ok()).unwrap_or_default();
    let status = child.wait().map_err(|error| format!("cannot wait for it: {error}"))?;
    let (wall_seconds, after) = (start.elapsed().as_secs_f64(), core_times(cores));
    // Processes run one after the other: what was added is that of this one.
    let cpu_seconds = seconds_of_children() - children;
    if !status.success() {
        let first = errors.lines().find(|line| !line.trim().is_empty()).unwrap_or("it said nothing");
        return Err(format!("{status}: {}", first.chars().take(300).collect::<String>()));
    }
    let load =
        before.zip(after).map(|(before, after)| Load::between(before, after, cpu_seconds, wall_seconds));
    Ok(Measured { quantities: read_quantities(&output)?, wall_seconds, cpu_seconds, load })
}

fn read(pipe: impl Read) -> String {
    let mut bytes = Vec::new();
    // What was read is what there is.
    let _ = pipe.take(MAX_OUTPUT).read_to_end(&mut bytes);
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The cores that this process may use.
#[cfg(target_os = "linux")]
pub fn allowed_cores() -> Vec<usize> {
    let Ok(set) = sched_getaffinity(Pid::from_raw(0)) else { return Vec::new() };
    (0..CpuSet::count()).filter(|&core| set.is_set(core).unwrap_or(false)).collect()
}

/// Where the system binds no processes to cores: none are known.
#[cfg(not(target_os = "linux"))]
pub fn allowed_cores() -> Vec<usize> {
    Vec::new()
}

/// Keeps this thread, and the processes that it starts, on these cores, if any are named.
#[cfg(target_os = "linux")]
fn stay_on(cores: &[usize]) -> Result<(), String> {
    if cores.is_empty() {
        return Ok(());
    }
    let mut set = CpuSet::new();
    let bound = cores.iter().try_for_each(|&core| set.set(core));
    bound
        .and_then(|()| sched_setaffinity(Pid::from_raw(0), &set))
        .map_err(|error| format!("cannot bind it to cores {cores:?}: {error}"))
}

#[cfg(not(target_os = "linux"))]
fn stay_on(_: &[usize]) -> Result<(), String> {
    Ok(())
}

/// Seconds of cores that the processes which have ended took.
#[cfg(unix)]
fn seconds_of_children() -> f64 {
    let Ok(usage) = getrusage(UsageWho::RUSAGE_CHILDREN) else { return 0.0 };
    let seconds = |time: TimeVal| time.tv_sec() as f64 + time.tv_usec() as f64 * 1e-6;
    seconds(usage.user_time()) + seconds(usage.system_time())
}

#[cfg(not(unix))]
fn seconds_of_children() -> f64 {
    0.0
}
