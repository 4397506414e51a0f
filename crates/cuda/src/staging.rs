//! The way back from a device: through page-locked memory, in pieces, so that the next piece travels while threads copy the
//! last one to where it belongs. (Straight to ordinary memory the driver copies on one thread, and waits for each page of a
//! new film to be given to the process.)

use cudarc::driver::{CudaContext, CudaEvent, CudaStream, DriverError, result};
use eosphor_core::device::RayTotals;
use rayon::prelude::*;
use std::ffi::c_void;
use std::sync::Arc;

/// Bytes of a piece.
const PIECE: usize = 3 << 20;

/// Bytes that a thread copies at a time.
const SHARE: usize = 96 << 10;

/// Two pieces of page-locked memory.
pub(crate) struct Staging {
    /// For copies alone.
    stream: Arc<CudaStream>,
    pieces: [*mut c_void; 2],
}

// SAFETY: the memory is this one's alone.
unsafe impl Send for Staging {}

impl Staging {
    pub(crate) fn new(context: &Arc<CudaContext>) -> Result<Staging, DriverError> {
        let stream = context.new_stream()?;
        let mut staging = Staging { stream, pieces: [std::ptr::null_mut(); 2] };
        for piece in &mut staging.pieces {
            // SAFETY: the memory is freed once, by `drop`; the new stream has made the context this thread's.
            *piece = unsafe { result::malloc_host(PIECE, 0) }?;
        }
        Ok(staging)
    }

    /// Copies as many items as `to` has room for from the device's memory at `from`, which nobody writes meanwhile.
    ///
    /// # Safety
    ///
    /// So many items are there, and any bytes are an item.
    pub(crate) unsafe fn copy_back<T: Copy + Send + Sync>(
        &self,
        from: u64,
        to: &mut [T],
    ) -> Result<(), DriverError> {
        self.stream.context().bind_to_thread()?;
        let items = PIECE / size_of::<T>();
        let last = to.len().div_ceil(items).saturating_sub(1);
        let mut arriving: Option<(CudaEvent, &mut [T])> = None;
        for (number, part) in to.chunks_mut(items).enumerate() {
            let piece = self.pieces[number % 2].cast::<T>();
            // SAFETY: the piece is as long as any part; whoever read it before is done, as one piece is taken at a time.
            let staged = unsafe { std::slice::from_raw_parts_mut(piece, part.len()) };
            let from = from + (number * items * size_of::<T>()) as u64;
            // SAFETY: the device's memory holds all of `to`, and the piece stays until the event below has come.
            unsafe { result::memcpy_dtoh_async(staged, from, self.stream.cu_stream()) }?;
            let arrived = self.stream.record_event(None)?;
            if let Some((before, part)) = arriving.replace((arrived, part)) {
                before.synchronize()?;
                take(self.pieces[(number + 1) % 2].cast(), part);
            }
        }
        if let Some((arrived, part)) = arriving {
            arrived.synchronize()?;
            take(self.pieces[last % 2].cast(), part);
        }
        Ok(())
    }

    /// Copies a launch's totals, which are at `from`.
    pub(crate) fn copy_totals(&self, from: u64) -> Result<RayTotals, DriverError> {
        let mut totals = [RayTotals::default()];
        // SAFETY: the device's memory holds them; any bytes are totals; `totals` stays until the copy is over.
        unsafe { result::memcpy_dtoh_async(&mut totals, from, self.stream.cu_stream()) }?;
        self.stream.synchronize()?;
        Ok(totals[0])
    }
}

/// Copies from a piece, on all threads.
fn take<T: Copy + Send + Sync>(piece: *const T, to: &mut [T]) {
    // SAFETY: so many items have arrived there.
    let arrived = unsafe { std::slice::from_raw_parts(piece, to.len()) };
    let share = SHARE / size_of::<T>();
    to.par_chunks_mut(share).zip(arrived.par_chunks(share)).for_each(|(to, from)| to.copy_from_slice(from));
}

impl Drop for Staging {
    fn drop(&mut self) {
        // What a copy that failed has left under way; there is nobody to tell of errors.
        let _ = self.stream.synchronize();
        for piece in self.pieces.iter().filter(|piece| !piece.is_null()) {
            // SAFETY: it was allocated so, and nothing uses it any more.
            let _ = unsafe { result::free_host(*piece) };
        }
    }
}
