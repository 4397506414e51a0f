//! Why a job failed.

use super::memory::bytes_in_words;
use eosphor_render::output::{OutputError, explain};
use eosphor_render::still::SumsError;
use eosphor_render::{BackendError, Region};
use eosphor_scene::SceneError;
use std::ops::Range;
use std::path::PathBuf;

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
        "not enough memory: what is rendered at a time needs {}, and {} are free: end other programs, or choose a smaller --size",
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
    /// A still ended early by an error, and what was done is kept.
    #[error("{error}; {} has what was done: the same with --resume goes on", checkpoint.display())]
    StillKept {
        /// Why it ended.
        error: Box<JobError>,
        /// The file that keeps what was done.
        checkpoint: PathBuf,
    },
}
