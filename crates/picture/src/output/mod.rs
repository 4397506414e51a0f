//! Pictures in and out: writing files row by row that are whole or not there, reading them back.

mod alpha;
mod atomic;
mod data;
mod destination;
mod encoder;
mod error;
mod exr;
mod format;
mod hdr;
mod jpeg;
mod metadata;
mod picture;
mod png;
mod ppm;
mod save;
mod share;
mod stream;
#[cfg(feature = "video")]
mod video;
mod writer;

#[cfg(test)]
mod tests;

#[cfg(unix)]
pub(crate) use atomic::mode_before_rights;
pub(crate) use atomic::{take_rights_of, write_whole};
pub use eosphor_render::{DevelopSettings, Developed};
pub use error::{OutputError, explain};
pub use exr::Layer;
pub use format::Format;
pub use metadata::{Metadata, PICTURE_VERSION};
pub use picture::{ByteImage, Picture};
pub use save::{
    SaveOptions, Window, check_writable, save, save_developed, save_developed_within, save_within,
};
pub(crate) use share::bands;
pub use share::{BAND_ROWS, ShareError, ShareHeader, ShareReader, ShareWriter, merge, share_path};
pub use stream::Stream;
#[cfg(feature = "video")]
pub use video::{
    FfmpegOptions, FfmpegPipe, FrameRate, InvalidFrameRate, LiveEncoder, LiveFrame, MAX_FRAMES,
    SEGMENT_FRAMES, VideoOptions, VideoWriter, check_video_size, padded_size,
};
pub use writer::{PictureWriter, partial_path};

/// Longest side of a picture, in pixels.
pub const MAX_SIDE: u32 = 65_535;
