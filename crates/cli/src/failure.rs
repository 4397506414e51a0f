//! Why a command ended without success, and what the shell is told.

use crate::{first_signal, flag_hints};
use eosphor::compare::CompareError;
use eosphor::job::JobError;
use eosphor::{BackendError, OutputError, SceneError, Snippet};
use std::fmt::Display;
use std::process::ExitCode;

/// Why a command ended without success.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The work failed: what, where, what to do.
    Failed(String),
    /// The scene is wrong.
    Scene(SceneError),
    /// The flags ask for something that does not exist.
    Usage(String),
    /// A signal, and what became of the work.
    Interrupted(String),
    /// Two pictures differ; this has been said on stdout.
    Different,
}

impl Failure {
    /// The one line for stderr.
    pub(crate) fn line(&self) -> Option<String> {
        match self {
            Failure::Failed(text) | Failure::Usage(text) | Failure::Interrupted(text) => Some(one_line(text)),
            Failure::Scene(error) => Some(one_line(&flag_hints::scene(error))),
            Failure::Different => None,
        }
    }

    /// The line of a file that is wrong, to be shown below.
    pub(crate) fn snippet(&self) -> Option<&Snippet> {
        match self {
            Failure::Scene(error) => error.snippet(),
            _ => None,
        }
    }

    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Failure::Usage(_) | Failure::Scene(SceneError::NoSuchCamera { .. }) => ExitCode::from(2),
            Failure::Failed(_) | Failure::Scene(_) | Failure::Different => ExitCode::from(1),
            Failure::Interrupted(_) => first_signal::exit_code(),
        }
    }

    /// For `map_err`: the work failed for this reason.
    pub(crate) fn because(reason: impl Display) -> Failure {
        Failure::Failed(reason.to_string())
    }

    /// For `map_err`, of an output that the command line names: an ending that means no format is wrong usage.
    pub(crate) fn of_output(error: OutputError) -> Failure {
        match error {
            OutputError::UnknownFormat { .. } => Failure::usage(error),
            error => error.into(),
        }
    }

    /// For `map_err`: the flags are to blame.
    pub(crate) fn usage(reason: impl Display) -> Failure {
        Failure::Usage(reason.to_string())
    }
}

/// Libraries may say more than one line, and file names may hold anything. Numbers of the system's errors say nothing to people.
fn one_line(text: &str) -> String {
    let mut text = text.to_owned();
    while let Some((start, rest)) = text.split_once(" (os error ") {
        let Some((_, end)) = rest.split_once(')') else { break };
        text = format!("{start}{end}");
    }
    let words = text.split(|c: char| c.is_control()).map(str::trim);
    words.filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

macro_rules! fails {
    ($($error:ty),+) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Failure {
                Failure::because(error)
            }
        })+
    };
}
fails!(BackendError, OutputError, CompareError);

impl From<JobError> for Failure {
    /// What flags are about is said with their names.
    fn from(error: JobError) -> Failure {
        match error {
            JobError::Scene(error) => error.into(),
            JobError::Cancelled => {
                Failure::Interrupted("interrupted before the first pixel; no picture was written".into())
            }
            JobError::SameOutput { .. } => Failure::Usage(format!("-o: {error}")),
            JobError::NotInPicture { .. } | JobError::NoSuchFrames { .. } => {
                Failure::Usage(format!("--{error}"))
            }
            JobError::NoAnimation { .. }
            | JobError::Pattern(_)
            | JobError::FrameRate { .. }
            | JobError::MixedShares => Failure::usage(flag_hints::job(&error)),
            JobError::NoSuchSamples { samples, all } => {
                let (first, end) = (samples.start, samples.end);
                Failure::Usage(format!("--sample-range {first}..{end}: a pixel has {all} samples"))
            }
            error => Failure::because(flag_hints::job(&error)),
        }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Failure {
        Failure::Scene(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_one_line() {
        assert_eq!(Failure::because("a\n  b\tc\r\n").line().unwrap(), "a b c");
        assert_eq!(Failure::because("a: No such file (os error 2); b").line().unwrap(), "a: No such file; b");
    }
}
