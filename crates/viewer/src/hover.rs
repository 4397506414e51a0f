//! The pixel under the pointer of a page.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// The pixel that a page has asked for last, while it is not answered.
#[derive(Default)]
pub(crate) struct Hover(Mutex<Asked>);

#[derive(Default)]
struct Asked {
    pixel: Option<[u32; 2]>,
    /// A thread answers.
    is_answered: bool,
}

impl Hover {
    fn asked(&self) -> MutexGuard<'_, Asked> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks for a pixel instead of the one that was asked for before. Whether nobody answers yet: then whoever calls this does.
    pub(crate) fn ask(&self, pixel: [u32; 2]) -> bool {
        let mut asked = self.asked();
        asked.pixel = Some(pixel);
        !std::mem::replace(&mut asked.is_answered, true)
    }

    /// The next pixel to answer. Where there is none, the one who answers is done.
    pub(crate) fn next(&self) -> Option<[u32; 2]> {
        let mut asked = self.asked();
        let pixel = asked.pixel.take();
        asked.is_answered = pixel.is_some();
        pixel
    }
}
