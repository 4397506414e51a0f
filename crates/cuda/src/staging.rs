//! The way back from a device: through page-locked memory, in pieces, so that the next piece travels while threads copy the
//! last one to where it belongs. (Straight to ordinary memory the driver copies on one thread, and waits for each page of a
//! new film to be given to the process.)

use cudarc::driver::{CudaContext, CudaEvent, CudaStream, DriverError, result};
use eosphor_core::math::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Colours of a piece: 3 MB.
const PIECE: usize = 1 << 18;

/// Colours that a thread copies at a time.
const SHARE: usize = 1 << 13;

/// Two pieces of page-locked memory.
pub(crate) struct Staging {
    /// For copies alone.
    stream: Arc<CudaStream>,
    pieces: [*mut Vec3; 2],
}

// SAFETY: the memory is this one's alone.
unsafe impl Send for Staging {}

impl Staging {
    pub(crate) fn new(context: &Arc<CudaContext>) -> Result<Staging, DriverError> {
        let stream = context.new_stream()?;
        let mut staging = Staging { stream, pieces: [std::ptr::null_mut(); 2] };
        for piece in &mut staging.pieces {
            // SAFETY: the memory is freed once, by `drop`; the new stream has made the context this thread's.
            *piece = unsafe { result::malloc_host(PIECE * size_of::<Vec3>(), 0) }?.cast();
        }
        Ok(staging)
    }

    /// Copies as many colours as `to` has room for from the device's memory at `from`, which nobody writes meanwhile.
    pub(crate) fn copy_back(&self, from: u64, to: &mut [Vec3]) -> Result<(), DriverError> {
        self.stream.context().bind_to_thread()?;
        let last = to.len().div_ceil(PIECE).saturating_sub(1);
        let mut arriving: Option<(CudaEvent, &mut [Vec3])> = None;
        for (number, part) in to.chunks_mut(PIECE).enumerate() {
            let piece = self.pieces[number % 2];
            // SAFETY: the piece is as long as any part; whoever read it before is done, as one piece is taken at a time.
            let staged = unsafe { std::slice::from_raw_parts_mut(piece, part.len()) };
            let from = from + (number * PIECE * size_of::<Vec3>()) as u64;
            // SAFETY: the device's memory holds all of `to`, and the piece stays until the event below has come.
            unsafe { result::memcpy_dtoh_async(staged, from, self.stream.cu_stream()) }?;
            let arrived = self.stream.record_event(None)?;
            if let Some((before, part)) = arriving.replace((arrived, part)) {
                before.synchronize()?;
                take(self.pieces[(number + 1) % 2], part);
            }
        }
        if let Some((arrived, part)) = arriving {
            arrived.synchronize()?;
            take(self.pieces[last % 2], part);
        }
        Ok(())
    }

    /// Copies a few numbers.
    pub(crate) fn copy_numbers(&self, from: u64, to: &mut [u64]) -> Result<(), DriverError> {
        // SAFETY: the device's memory holds all of `to`, which stays until the copy is over.
        unsafe { result::memcpy_dtoh_async(to, from, self.stream.cu_stream()) }?;
        self.stream.synchronize()
    }
}

/// Copies from a piece, on all threads.
fn take(piece: *const Vec3, to: &mut [Vec3]) {
    // SAFETY: so many colours have arrived there.
    let arrived = unsafe { std::slice::from_raw_parts(piece, to.len()) };
    to.par_chunks_mut(SHARE).zip(arrived.par_chunks(SHARE)).for_each(|(to, from)| to.copy_from_slice(from));
}

impl Drop for Staging {
    fn drop(&mut self) {
        // What a copy that failed has left under way; there is nobody to tell of errors.
        let _ = self.stream.synchronize();
        for piece in self.pieces.iter().filter(|piece| !piece.is_null()) {
            // SAFETY: it was allocated so, and nothing uses it any more.
            let _ = unsafe { result::free_host(piece.cast()) };
        }
    }
}
