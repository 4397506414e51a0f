//! Videos: frames in any order become H.264 in an MP4 file, by the program itself.
//!
//! [`VideoWriter`] owns a folder beside the file, `OUT.mp4.part`. Frames are stored there without loss as they come;
//! whenever the [`SEGMENT_FRAMES`] frames of a segment are all there, a thread encodes them, each segment by an encoder
//! of its own, and removes them; at the end the segments are joined. So nothing that was rendered is lost when a run
//! ends early, and the file's bytes depend on the frames alone: not on their order, the number of threads or how often
//! the run was interrupted.
//!
//! | file of this folder | has |
//! |---|---|
//! | `rate.rs`, `settings.rs` | what a video is: rate, size, number of frames, quality |
//! | `planes.rs` | colours of a screen to those of video |
//! | `encoder.rs` | frames of a segment to samples |
//! | `segment.rs` | the file of an encoded segment |
//! | `frame.rs` | the file of a frame |
//! | `folder.rs` | the folder: its names, what is whole in it, its end |
//! | `queue.rs` | what encoding threads and callers share |
//! | `writer.rs` | all of it together |
//! | `mp4.rs` | segments to the file |
//! | `ffmpeg.rs` | the other way: frames in order to a program that is installed |
//! | `live.rs` | no file: frames of a live picture |

mod encoder;
mod ffmpeg;
mod folder;
mod frame;
mod live;
mod mp4;
mod planes;
mod queue;
mod rate;
mod segment;
mod settings;
mod writer;

#[cfg(test)]
mod tests;

pub use ffmpeg::{FfmpegOptions, FfmpegPipe};
pub use live::{LiveEncoder, LiveFrame};
pub use rate::{FrameRate, InvalidFrameRate};
pub use settings::{MAX_FRAMES, VideoOptions, check_video_size, padded_size};
pub use writer::VideoWriter;

/// Frames of a segment: between pictures that do not need others to be decoded, so players can go to them. Part of the
/// format of the folder.
pub const SEGMENT_FRAMES: u32 = 30;

use std::io::{Error, ErrorKind};

fn misuse(message: impl Into<String>) -> Error {
    Error::new(ErrorKind::InvalidInput, message.into())
}

/// What is in a file is not what was written.
fn damaged(message: impl Into<String>) -> Error {
    Error::new(ErrorKind::InvalidData, message.into())
}
