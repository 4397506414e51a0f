//! Moving frames as H.264, for lines that are too slow for JPEGs: the same picture for a fifth of the bytes.

use eosphor::Developed;
#[cfg(feature = "video")]
use eosphor::video::LiveEncoder;
use std::io::Error;
#[cfg(feature = "video")]
use std::sync::atomic::{AtomicUsize, Ordering};
#[cfg(feature = "video")]
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Encoders that there may be at a time, of all pages: each has some 30 MB for frames of 1920 x 1080. Other pages get JPEGs.
#[cfg(feature = "video")]
const MAX_ENCODERS: usize = 8;

/// Encoders that there are.
#[cfg(feature = "video")]
static ENCODERS: AtomicUsize = AtomicUsize::new(0);

/// The encoder of a page, while its camera moves.
#[derive(Default)]
pub(crate) struct Video(#[cfg(feature = "video")] Mutex<Option<CountedEncoder>>);

/// An encoder that counts.
#[cfg(feature = "video")]
struct CountedEncoder(LiveEncoder);

/// An encoded frame, and whether it needs none before it.
pub(crate) struct VideoFrame {
    pub(crate) bytes: Vec<u8>,
    pub(crate) is_key: bool,
}

#[cfg(feature = "video")]
impl CountedEncoder {
    fn new(size: (u32, u32), quantiser: u8) -> Result<CountedEncoder, Error> {
        let add = |count: usize| (count < MAX_ENCODERS).then_some(count + 1);
        match ENCODERS.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add) {
            Ok(_) => LiveEncoder::new(size, quantiser).map(CountedEncoder).inspect_err(|_| uncount()),
            Err(_) => Err(Error::other("all encoders are in use")),
        }
    }
}

#[cfg(feature = "video")]
impl Drop for CountedEncoder {
    fn drop(&mut self) {
        uncount();
    }
}

#[cfg(feature = "video")]
fn uncount() {
    ENCODERS.fetch_sub(1, Ordering::Relaxed);
}

#[cfg(feature = "video")]
impl Video {
    fn encoder(&self) -> MutexGuard<'_, Option<CountedEncoder>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next frame; the first one of a size or quantiser is a key frame.
    pub(crate) fn encode(&self, picture: &Developed, quantiser: u8) -> Result<VideoFrame, Error> {
        let size = (picture.width, picture.height);
        let mut encoder = self.encoder();
        // One for another size or quantiser ends before the next one is made.
        let same = encoder.take().filter(|encoder| encoder.0.is_for(size, quantiser));
        let mut now = same.map_or_else(|| CountedEncoder::new(size, quantiser), Ok)?;
        let frame = now.0.encode(picture)?;
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

#[cfg(all(test, feature = "video"))]
mod tests {
    use super::*;

    #[test]
    fn encoders_are_limited_and_come_back() {
        let picture = Developed { width: 32, height: 32, rgb: vec![90; 32 * 32 * 3], alpha: Vec::new() };
        let pages: Vec<Video> = (0..MAX_ENCODERS).map(|_| Video::default()).collect();
        for page in &pages {
            assert!(page.encode(&picture, 30).unwrap().is_key && page.is_running());
            assert!(!page.encode(&picture, 30).unwrap().is_key);
        }
        let one_more = Video::default();
        assert!(one_more.encode(&picture, 30).is_err() && !one_more.is_running());
        // Another quantiser takes the place of the page's own.
        assert!(pages[0].encode(&picture, 34).unwrap().is_key);
        pages[0].end();
        assert!(one_more.encode(&picture, 30).unwrap().is_key);
        drop(pages);
        // A size that no encoder takes is not counted.
        let wrong = Developed { width: 2, height: 2, rgb: vec![0; 12], alpha: Vec::new() };
        for _ in 0..2 * MAX_ENCODERS {
            assert!(one_more.encode(&wrong, 30).is_err());
        }
        assert_eq!(ENCODERS.load(Ordering::Relaxed), 0);
    }
}
