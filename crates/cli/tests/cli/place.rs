//! Running the real program.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of its own and the program.
pub(crate) struct Place {
    folder: tempfile::TempDir,
}

/// What a run gave.
pub(crate) struct Run {
    /// Exit code.
    pub(crate) code: Option<i32>,
    /// Standard output.
    pub(crate) stdout: String,
    /// Standard error.
    pub(crate) stderr: String,
}

impl Place {
    /// An empty one.
    pub(crate) fn new() -> Place {
        Place { folder: tempfile::tempdir().unwrap() }
    }

    /// A path inside.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Names inside.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The program in this folder.
    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_eosphor"));
        command.args(arguments).current_dir(self.folder.path());
        #[cfg(unix)]
        obey_signals(&mut command);
        command
    }

    /// Runs it.
    pub(crate) fn run(&self, arguments: &[&str]) -> Run {
        self.command(arguments).output().unwrap().into()
    }

    /// Renders a tiny Cornell box.
    pub(crate) fn render(&self, name: &str, more: &[&str]) -> Run {
        let tiny = ["render", "builtin:cornell", "-o", name, "--size", "16x12", "--samples", "1"];
        self.run(&[&tiny[..], &["--light-samples", "1"], more].concat())
    }
}

impl From<Output> for Run {
    fn from(output: Output) -> Run {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Run { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

impl Run {
    /// Exit 0, or a panic with what it said.
    pub(crate) fn succeeded(self) -> Run {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        self
    }

    /// Exit 1 and exactly one line on stderr, which holds all of `words`; nothing on stdout. Below it may stand a line
    /// of the file that is wrong, with a caret.
    pub(crate) fn failed_with(&self, words: &[&str]) {
        let shown = &self.stderr;
        assert_eq!(self.code, Some(1), "{shown}");
        let lines: Vec<&str> = shown.lines().collect();
        let is_snippet = |below: &[&str]| below[0].starts_with(' ') && below[1].ends_with('^');
        assert!(lines.len() == 1 || lines.len() == 3 && is_snippet(&lines[1..]), "{shown}");
        assert!(shown.starts_with("eosphor: ") && self.stdout.is_empty(), "{shown}");
        assert!(words.iter().all(|word| shown.contains(word)), "{shown} has not all of {words:?}");
    }

    /// Exit 2, with `words` on stderr and no panic.
    pub(crate) fn is_wrong_usage(&self, words: &[&str]) {
        let shown = &self.stderr;
        assert_eq!(self.code, Some(2), "{shown}");
        assert!(words.iter().all(|word| shown.contains(word)), "{shown} has not all of {words:?}");
        assert!(!shown.contains("panicked"), "{shown}");
    }

    /// stdout as JSON.
    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {}", self.stdout))
    }
}

/// Lets a program end by signals. Shells start what runs in the background with SIGINT ignored, and `nohup` with SIGHUP; programs
/// that the tests start would inherit that.
#[cfg(unix)]
fn obey_signals(command: &mut Command) {
    use std::os::unix::process::CommandExt;
    let to_default = || {
        for signal in [libc::SIGHUP, libc::SIGINT, libc::SIGQUIT, libc::SIGTERM] {
            // SAFETY: sets what a signal does to its default, which needs no memory and no lock.
            unsafe { libc::signal(signal, libc::SIG_DFL) };
        }
        Ok(())
    };
    // SAFETY: between fork and exec the closure calls nothing but `signal`, which is async-signal-safe.
    unsafe { command.pre_exec(to_default) };
}

/// Whether a file holds these bytes somewhere.
pub(crate) fn holds(path: &Path, text: &str) -> bool {
    let bytes = std::fs::read(path).unwrap();
    bytes.windows(text.len()).any(|window| window == text.as_bytes())
}
