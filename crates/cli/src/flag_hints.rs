//! Errors of the library, with the flags of this program that are the way out. The library names options and fields, as its users
//! have no flags.

use eosphor::SceneError;
use eosphor::frames::ManifestError;
use eosphor::job::JobError;
use eosphor::shares::ShareError;
use eosphor::still::{MergeError, SumsError};

/// How an interrupted render is continued, where it has to be told so.
pub(crate) const RESUME: &str = "the same with --resume goes on";
/// How processes that share the frames of a sequence are continued.
pub(crate) const SHARED: &str = "the same command goes on";

/// The text of an error of a job.
pub(crate) fn job(error: &JobError) -> String {
    match error {
        JobError::Scene(error) => scene(error),
        JobError::StillKept { error, checkpoint } => {
            format!("{}; {} has what was done: {RESUME}", job(error), checkpoint.display())
        }
        JobError::FramesKept { error, done, all, is_shared } => {
            let goes_on = if *is_shared { SHARED } else { RESUME };
            format!("{}; {done} of {all} frames are done: {goes_on}", job(error))
        }
        JobError::VideoKept { error, folder, done, all } => {
            format!("{}; {} has {done} of {all} frames: {RESUME}", job(error), folder.display())
        }
        error => match hint(error) {
            Some(hint) => format!("{error} ({hint})"),
            None => error.to_string(),
        },
    }
}

/// The text of an error of a scene.
pub(crate) fn scene(error: &SceneError) -> String {
    match error {
        SceneError::TextureMemory { .. } => format!("{error} (--texture-memory)"),
        error => error.to_string(),
    }
}

/// The flags that an error is about.
fn hint(error: &JobError) -> Option<String> {
    Some(match error {
        JobError::Sums(SumsError::Stale { .. } | SumsError::Malformed { .. })
        | JobError::Manifest(ManifestError::Stale { .. } | ManifestError::Malformed { .. }) => {
            "leave out --resume".into()
        }
        JobError::Merge(MergeError::NotWhole { .. } | MergeError::KeptStill { .. }) => RESUME.into(),
        JobError::Merge(MergeError::Missing { first, end, .. }) => format!("--sample-range {first}..{end}"),
        JobError::Share(ShareError::Missing { missing, count }) => format!("--tiles {missing}/{count}"),
        JobError::NoShares { .. } => "--tiles 1/N to --tiles N/N, or --sample-range".into(),
        JobError::Memory { .. } => "--size".into(),
        JobError::NoAnimation { .. } => "--orbit FRAMES".into(),
        JobError::FrameRate { .. } => "--fps".into(),
        _ => return None,
    })
}
