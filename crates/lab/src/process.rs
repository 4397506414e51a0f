//! A fresh process that measures, and what else ran meanwhile.

use crate::load::{Load, clock_megahertz, core_times, rounded};
#[cfg(target_os = "linux")]
use nix::sched::{CpuSet, sched_getaffinity, sched_setaffinity};
#[cfg(unix)]
use nix::sys::resource::{UsageWho, getrusage};
#[cfg(unix)]
use nix::sys::time::TimeVal;
#[cfg(target_os = "linux")]
use nix::unistd::Pid;
use std::ffi::OsString;
use std::io::{Read, Write};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A process that has ended well.
pub(crate) struct Ended {
    /// What it printed.
    pub(crate) output: String,
    /// How long it ran, with all that it did besides measuring.
    pub(crate) wall_seconds: f64,
    /// The time that it took of cores.
    pub(crate) cpu_seconds: f64,
    /// What else ran; where the system does not tell, nothing.
    pub(crate) load: Option<Load>,
}

/// The most bytes that are read of what a process prints.
const MAX_OUTPUT: u64 = 4 << 20;

/// How long the load before a process is looked at.
const LOOK: Duration = Duration::from_millis(100);

/// Where `mpirun` is Open MPI's, it starts no more ranks than there are cores, and none for root (as in containers), unless it is
/// told.
const OPEN_MPI: [(&str, &str); 4] = [
    ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
    ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
    ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
    ("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe"),
];

/// Runs these words, a program and its arguments, on these cores.
///
/// # Errors
///
/// Why it did not end well, in a line.
pub(crate) fn run_process(words: &[OsString], input: Option<&str>, cores: &[usize]) -> Result<Ended, String> {
    let (program, arguments) = words.split_first().ok_or("there is no program to run")?;
    let everything = allowed_cores();
    let before_cores = load_before(cores);
    let clock_before = clock_megahertz(cores);
    let mut command = Command::new(program);
    command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.envs(OPEN_MPI);
    command.stdin(if input.is_some() { Stdio::piped() } else { Stdio::null() });
    stay_on(cores)?;
    let (before, children, start) = (core_times(cores), seconds_of_children(), Instant::now());
    let spawned = command.spawn();
    // A process keeps the cores that it was started on; this one may use all of its own again.
    stay_on(&everything)?;
    let mut child = spawned.map_err(|error| format!("cannot run {}: {error}", program.display()))?;
    // Small enough for a pipe: it does not wait for the process. One that reads nothing says so itself.
    let _ = child.stdin.take().zip(input).map(|(mut pipe, text)| pipe.write_all(text.as_bytes()));
    // Each on a thread of its own, so that neither fills its pipe while the other is read.
    let errors = child.stderr.take().map(|pipe| std::thread::spawn(move || read(pipe)));
    let output = child.stdout.take().map(read).unwrap_or_default();
    let errors = errors.and_then(|thread| thread.join().ok()).unwrap_or_default();
    let status = child.wait().map_err(|error| format!("cannot wait for it: {error}"))?;
    let (wall_seconds, after) = (rounded(start.elapsed().as_secs_f64()), core_times(cores));
    let clock_after = clock_megahertz(cores);
    // Processes run one after the other: what was added is that of this one.
    let cpu_seconds = rounded(seconds_of_children() - children);
    if !status.success() {
        let first = errors.lines().find(|line| !line.trim().is_empty()).unwrap_or("it said nothing");
        return Err(format!("{status}: {}", first.chars().take(300).collect::<String>()));
    }
    let load = before.zip(after).map(|(before, after)| Load {
        before_cores: before_cores.unwrap_or(0.0),
        megahertz: clock_before.zip(clock_after).map(|(before, after)| [before, after]),
        ..Load::between(before, after, cpu_seconds, wall_seconds)
    });
    Ok(Ended { output, wall_seconds, cpu_seconds, load })
}

/// Cores' worth of work on these cores while nothing is measured.
fn load_before(cores: &[usize]) -> Option<f64> {
    let (before, start) = (core_times(cores)?, Instant::now());
    std::thread::sleep(LOOK);
    Some(Load::between(before, core_times(cores)?, 0.0, start.elapsed().as_secs_f64()).other_cores)
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
    seconds_of(UsageWho::RUSAGE_CHILDREN)
}

#[cfg(unix)]
fn seconds_of(who: UsageWho) -> f64 {
    let Ok(usage) = getrusage(who) else { return 0.0 };
    let seconds = |time: TimeVal| time.tv_sec() as f64 + time.tv_usec() as f64 * 1e-6;
    seconds(usage.user_time()) + seconds(usage.system_time())
}

#[cfg(not(unix))]
fn seconds_of_children() -> f64 {
    0.0
}
