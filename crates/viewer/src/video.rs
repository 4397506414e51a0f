//! Moving frames as H.264, for lines that do not hold JPEGs: the same picture for a fifth of the bytes.

use eosphor::Developed;
#[cfg(feature = "video")]
use eosphor::video::LiveEncoder;
use std::io::Error;
#[cfg(feature = "video")]
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The encoder of a page, while its camera moves: 30 MB for frames of 1920 x 1080.
#[derive(Default)]
pub(crate) struct Video(#[cfg(feature = "video")] Mutex<Option<LiveEncoder>>);

/// An encoded frame, and whether it needs none before it.
pub(crate) struct VideoFrame {
    pub(crate) bytes: Vec<u8>,
    pub(crate) is_key: bool,
}

#[cfg(feature = "video")]
impl Video {
    fn encoder(&self) -> MutexGuard<'_, Option<LiveEncoder>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next frame; the first one of a size or quantiser is a key frame.
    pub(crate) fn encode(&self, picture: &Developed, quantiser: u8) -> Result<VideoFrame, Error> {
        let size = (picture.width, picture.height);
        let mut encoder = self.encoder();
        let mut now = match encoder.take() {
            Some(encoder) if encoder.is_for(size, quantiser) => encoder,
            _ => LiveEncoder::new(size, quantiser)?,
        };
        let frame = now.encode(picture)?;
        *encoder = Some(now);
        Ok(VideoFrame { bytes: frame.bytes, is_key: frame.is_key })
    }

    /// Whether the next frame may need those before it.
    pub(crate) fn is_running(&self) -> bool {
        self.encoder().is_some()
    }

    /// The next frame is a key frame.
    pub(crate) fn end(&self) {
        *self.encoder() = None;
    }
}

#[cfg(not(feature = "video"))]
impl Video {
    pub(crate) fn encode(&self, _: &Developed, _: u8) -> Result<VideoFrame, Error> {
        Err(std::io::ErrorKind::Unsupported.into())
    }

    pub(crate) fn is_running(&self) -> bool {
        false
    }

    pub(crate) fn end(&self) {}
}
