//! Why a job failed.

use super::memory::bytes_in_words;
use eosphor_picture::frames::{ManifestError, PatternError};
use eosphor_picture::output::{OutputError, ShareError, explain};
use eosphor_picture::still::{MergeError, SumsError};
use eosphor_render::{BackendError, Region};
use eosphor_scene::{SceneError, near_name};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Why a job failed. Its text is one line: what, where, what to do. A job that was cancelled has not failed: its outcome says
/// so, but for [`JobError::Cancelled`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JobError {
    /// The scene contradicts itself, or a setting is out of range.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The device failed.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// What is done of a still cannot be gone on with, or not be kept.
    #[error(transparent)]
    Sums(#[from] SumsError),
    /// Frames cannot be gone on with, or no account be kept of them.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// A path names no frames.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// Shares of rows make no picture.
    #[error(transparent)]
    Share(#[from] ShareError),
    /// Shares of samples make no picture.
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// The job was cancelled before the first pixel, and nothing is kept.
    #[error("cancelled before the first pixel; no picture was written")]
    Cancelled,
    /// The folder of an output cannot be made.
    #[error("cannot make the folder of the output: {}: {}", folder.display(), explain(source))]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// What is rendered at a time does not fit.
    #[error(
        "not enough memory: what is rendered at a time needs {}, and {} are free: end other programs, or choose a smaller size",
        bytes_in_words(*needed),
        bytes_in_words(*free)
    )]
    Memory {
        /// Bytes.
        needed: u64,
        /// Bytes that the system says are free.
        free: u64,
    },
    /// There is no output.
    #[error("the picture has no name: give it an output")]
    NoOutput,
    /// Two outputs are one file, or both are streams of one name.
    #[error("{first} and {second} are the same: name it once")]
    SameOutput {
        /// The first one's name.
        first: String,
        /// The other's.
        second: String,
    },
    /// An output is a file that the scene is read from.
    #[error(
        "cannot write the picture: {}: this is {}, which the scene is read from: choose another name",
        output.display(),
        source_file.display()
    )]
    IsSource {
        /// The output.
        output: PathBuf,
        /// The file of the scene.
        source_file: PathBuf,
    },
    /// The part is not in the picture.
    #[error(
        "region {},{},{}x{}: the picture has {} x {} pixels, the upper left one is 0,0",
        region.x, region.y, region.width, region.height, size.0, size.1
    )]
    NotInPicture {
        /// The part.
        region: Region,
        /// Width and height of the picture in pixels.
        size: (u32, u32),
    },
    /// A pixel has fewer samples.
    #[error("samples {}..{}: a pixel has {all} samples", samples.start, samples.end)]
    NoSuchSamples {
        /// The samples that are wanted.
        samples: Range<u32>,
        /// How many there are.
        all: u32,
    },
    /// A share of the rows, or of the samples, has no file to go to, or more than one.
    #[error("a share of a picture goes to one file: name one")]
    ShareOutput,
    /// There is no such share of the rows.
    #[error("share {number} of {count}: shares of rows have numbers from 1 on, and there are at most 500")]
    ShareNumber {
        /// The number that is wanted.
        number: u32,
        /// How many there are to be.
        count: u32,
    },
    /// Shares of samples are to have layers or alpha.
    #[error("samples of a picture have neither layers nor alpha: leave these out, or share out rows")]
    SampleLayers,
    /// A still ended early by an error, and what was done is kept.
    #[error("{error}; {} has what was done: resuming goes on with it", checkpoint.display())]
    StillKept {
        /// Why it ended.
        error: Box<JobError>,
        /// The file that keeps what was done.
        checkpoint: PathBuf,
    },
    /// Frames are asked for, and the scene has no animation.
    #[error(
        "nothing moves in this scene: {} needs an animation: give the scene one, or a turntable",
        output.display()
    )]
    NoAnimation {
        /// Where the frames were to go.
        output: PathBuf,
    },
    /// The animation has fewer frames.
    #[error("frames {}..{}: the animation has {all} frames, 0..{all}", frames.start, frames.end)]
    NoSuchFrames {
        /// The frames that are wanted.
        frames: Range<u32>,
        /// How many there are.
        all: u32,
    },
    /// A video cannot have so many frames a second.
    #[error("{fps} frames a second: {reason}: choose a simpler number, as 24 or 29.97")]
    FrameRate {
        /// Frames a second.
        fps: f32,
        /// What is wrong with that.
        reason: String,
    },
    /// A sequence ended early by an error, and there are numbered files of the frames that were done.
    #[error("{error}; {done} of {all} frames are done: {}", how_to_go_on(*is_shared))]
    FramesKept {
        /// Why it ended.
        error: Box<JobError>,
        /// How many frames are done.
        done: usize,
        /// How many frames were asked for.
        all: usize,
        /// Several processes share the frames.
        is_shared: bool,
    },
    /// A video ended early by an error, and the frames that were done are kept.
    #[error("{error}; {} has {done} of {all} frames: resuming goes on with them", folder.display())]
    VideoKept {
        /// Why it ended.
        error: Box<JobError>,
        /// The folder that keeps the frames.
        folder: PathBuf,
        /// How many frames it has.
        done: usize,
        /// How many frames were asked for.
        all: usize,
    },
    /// A share to be merged is not there.
    #[error("{}: no such file: {}", path.display(), instead_of(path))]
    NoSuchShare {
        /// The file of the share that is not there.
        path: PathBuf,
    },
    /// Nobody named shares, and none lie beside the output.
    #[error(
        "there are no shares of {}: render them, or name their files",
        output.display()
    )]
    NoShares {
        /// The picture that they were to make.
        output: PathBuf,
    },
    /// The folder of the output cannot be searched for shares.
    #[error("cannot look for shares in {}: {source}", folder.display())]
    Search {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Some shares are of rows and some of samples.
    #[error("these are shares of rows (.share) and of samples (.sums): name those of one kind")]
    MixedShares,
}

/// What renders the frames that are left: a job that shares its frames keeps those that are there without being told to.
fn how_to_go_on(is_shared: bool) -> &'static str {
    if is_shared { "the same job goes on with them" } else { "resuming goes on with them" }
}

/// What to do about a share that is not there.
fn instead_of(path: &Path) -> String {
    match near_name(path) {
        Some(near) => format!("did you mean {near}?"),
        None => "check the path of the share".into(),
    }
}
