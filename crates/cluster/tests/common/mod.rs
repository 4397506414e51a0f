//! Starts this test program again, as the ranks of a job, under the MPIs of this machine.
#![allow(dead_code)] // each test program uses its own part

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Says to a process which case it is a rank of.
const CASE: &str = "EOSPHOR_TEST_CASE";
/// Where ranks leave their process numbers.
const FOLDER: &str = "EOSPHOR_TEST_FOLDER";
/// No job of these tests lasts nearly as long, however slow the machine.
const LONGEST: Duration = Duration::from_secs(180);

/// The case that this process is a rank of.
pub fn case() -> Option<String> {
    std::env::var(CASE).ok()
}

/// An MPI with its launcher.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Mpich,
    OpenMpi,
    Mpich5,
}

pub const KINDS: [Kind; 3] = [Kind::Mpich, Kind::OpenMpi, Kind::Mpich5];

impl Kind {
    /// The launcher, if it is installed. Says so where it is not; with REQUIRE_MPI=1 that is a failure.
    pub fn launcher(self) -> Option<PathBuf> {
        let found = match self {
            Kind::Mpich => on_path("mpirun.mpich"),
            Kind::OpenMpi => on_path("mpirun.openmpi"),
            Kind::Mpich5 => mpich5(),
        };
        if found.is_none() {
            let text = format!("skipped: {self:?}: no launcher: .ci/install-mpi installs it");
            assert!(std::env::var("REQUIRE_MPI").as_deref() != Ok("1"), "{text}");
            // Not by eprintln, which the test harness keeps to itself when a test passes.
            std::io::stderr().write_all(format!("{text}\n").as_bytes()).unwrap();
        }
        found
    }

    /// How its library calls itself.
    pub fn library(self) -> &'static str {
        match self {
            Kind::Mpich => "MPICH Version: ",
            Kind::OpenMpi => "Open MPI v",
            Kind::Mpich5 => "MPICH Version: 5.",
        }
    }
}

fn on_path(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(name)).find(|program| program.is_file())
}

fn mpich5() -> Option<PathBuf> {
    let this = std::env::current_exe().unwrap();
    // target/debug/deps/program
    let target = this.ancestors().nth(3).unwrap().join("mpich5");
    let roots = std::env::var_os("EOSPHOR_TEST_MPICH5").map(PathBuf::from).into_iter().chain([target]);
    roots.map(|root| root.join("bin/mpirun")).find(|program| program.is_file())
}

/// A job that is running.
pub struct Job {
    child: Child,
    output: std::thread::JoinHandle<String>,
    errors: std::thread::JoinHandle<String>,
    folder: Folder,
    _one_at_a_time: MutexGuard<'static, ()>,
}

/// What a job left.
pub struct Outcome {
    pub status: ExitStatus,
    pub output: String,
    pub errors: String,
}

/// Starts a case under a launcher.
pub fn start(launcher: &Path, ranks: u32, case: &str, variables: &[(&str, &str)]) -> Job {
    let mut command = Command::new(launcher);
    command.args(["-n", &ranks.to_string()]).arg(std::env::current_exe().unwrap());
    start_command(command, case, variables)
}

/// Starts a case without a launcher.
pub fn start_alone(case: &str, variables: &[(&str, &str)]) -> Job {
    start_command(Command::new(std::env::current_exe().unwrap()), case, variables)
}

fn start_command(mut command: Command, case: &str, variables: &[(&str, &str)]) -> Job {
    // Two cores do not bear several jobs at a time.
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let one_at_a_time = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = Folder::new(case);
    command.args(["rank_of_a_job", "--exact", "--nocapture", "--test-threads=1"]);
    command.env(CASE, case).env(FOLDER, &folder.0).env_remove("EOSPHOR_MPI");
    // Open MPI refuses to run as root, and more ranks than cores, unless it is told to.
    for name in ["OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"] {
        command.env(name, "1");
    }
    command
        .env("OMPI_MCA_rmaps_base_oversubscribe", "1")
        .env("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe");
    command.envs(variables.iter().copied());
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let (output, errors) = (read(child.stdout.take().unwrap()), read(child.stderr.take().unwrap()));
    Job { child, output, errors, folder, _one_at_a_time: one_at_a_time }
}

fn read(mut pipe: impl Read + Send + 'static) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        pipe.read_to_end(&mut bytes).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

impl Job {
    /// Waits for the end. A job that does not come to one is a failure; it is killed.
    pub fn end(self) -> Outcome {
        self.end_within(LONGEST)
    }

    /// The same, with a limit of its own, and for all ranks: none may outlive the launcher.
    pub fn end_within(mut self, limit: Duration) -> Outcome {
        let start = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            if start.elapsed() > limit {
                self.child.kill().unwrap();
                self.ranks().for_each(|rank| signal(rank, libc::SIGKILL));
                panic!("the job still runs after {limit:?}: {}", self.errors.join().unwrap());
            }
            std::thread::sleep(Duration::from_millis(10));
        };
        while let Some(rank) = self.ranks().find(|rank| is_running(*rank)) {
            if start.elapsed() > limit {
                self.ranks().for_each(|rank| signal(rank, libc::SIGKILL));
                panic!("process {rank} still runs {limit:?} after the launcher's end");
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        Outcome { status, output: self.output.join().unwrap(), errors: self.errors.join().unwrap() }
    }

    fn ranks(&self) -> impl Iterator<Item = i32> {
        (0..64).filter_map(|rank| self.process(rank))
    }

    /// The process of a rank, if it has said so.
    fn process(&self, rank: u32) -> Option<i32> {
        std::fs::read_to_string(self.folder.0.join(format!("rank{rank}"))).ok()?.parse().ok()
    }

    /// Waits until all ranks are at work, and gives the process of one.
    pub fn wait_for_process(&self, ranks: u32, rank: u32) -> i32 {
        let start = Instant::now();
        while !(0..ranks).all(|rank| self.process(rank).is_some()) {
            assert!(start.elapsed() < LONGEST, "not all ranks came to work");
            std::thread::sleep(Duration::from_millis(10));
        }
        self.process(rank).unwrap()
    }
}

impl Outcome {
    /// Lines on stderr that the program itself wrote of an error.
    pub fn error_lines(&self) -> Vec<&str> {
        self.errors.lines().filter(|line| line.starts_with("error: ")).collect()
    }

    /// The job ended well.
    pub fn assert_success(&self) {
        assert!(self.status.success(), "{}\n{}\n{}", self.status, self.output, self.errors);
    }

    /// The job ended with one line of error, which has these parts.
    pub fn assert_one_error(&self, parts: &[&str]) {
        assert!(!self.status.success(), "no failure: {}\n{}", self.output, self.errors);
        let lines = self.error_lines();
        assert!(lines.len() == 1, "{} error lines: {}", lines.len(), self.errors);
        for part in parts {
            assert!(lines[0].contains(part), "{part} is not in: {}", lines[0]);
        }
    }
}

/// A folder that is gone after the test.
struct Folder(PathBuf);

impl Folder {
    fn new(case: &str) -> Folder {
        static COUNT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
        let number = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let name = format!("eosphor-cluster-{}-{number}-{case}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).unwrap();
        Folder(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Called by ranks: leaves the process number for the test.
pub fn say_process(rank: u32) {
    let folder = PathBuf::from(std::env::var_os(FOLDER).unwrap());
    // Renamed, so that the test never reads half a number.
    std::fs::write(folder.join(format!("new{rank}")), std::process::id().to_string()).unwrap();
    std::fs::rename(folder.join(format!("new{rank}")), folder.join(format!("rank{rank}"))).unwrap();
}

pub fn signal(process: i32, signal: i32) {
    // SAFETY: it takes numbers only; the process is one that this test has started.
    unsafe { libc::kill(process, signal) };
}

/// Whether a process is there, and not just waiting for its parent to hear that it has ended.
fn is_running(process: i32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    stat.rsplit(')').next().is_some_and(|rest| !rest.trim().is_empty() && !rest.trim().starts_with('Z'))
}
