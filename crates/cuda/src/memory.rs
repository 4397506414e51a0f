//! A device's memory: what a scene needs of it is known before any is taken.

use crate::parameters::Parameters;
use cudarc::driver::{CudaSlice, CudaStream, DevicePtrMut, DriverError, result};
use eosphor_render::BackendError;
use std::mem::MaybeUninit;
use std::sync::Arc;

/// What rendering needs on a device, in bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Needs {
    /// The scene's arrays and the hierarchy's.
    pub(crate) scene: u64,
    /// The film of the largest band.
    pub(crate) film: u64,
    /// What the driver sets aside for the stacks of all threads that run at a time.
    pub(crate) stacks: u64,
    /// Paths in queues and their sums; 0 where no kernel works on them.
    pub(crate) queues: u64,
}

impl Needs {
    /// All together.
    pub(crate) fn all(&self) -> u64 {
        [self.film, self.stacks, self.queues].into_iter().fold(self.scene, u64::saturating_add)
    }

    /// Whether so much is free, or, if it `is_limited`, allowed.
    ///
    /// # Errors
    ///
    /// [`BackendError::OutOfMemory`] with all numbers where it is not.
    pub(crate) fn check(&self, free: u64, device: &str, is_limited: bool) -> Result<(), BackendError> {
        let needed = self.all();
        if needed <= free {
            return Ok(());
        }
        let [needed, free, scene, film, stacks] =
            [needed, free, self.scene, self.film.saturating_add(self.queues), self.stacks].map(bytes);
        Err(BackendError::OutOfMemory(format!(
            "not enough memory on {}: {needed} are needed ({scene} for the scene and its hierarchy, {film} for the \
             rows that are rendered at a time, {stacks} for the threads' stacks) and {free} are {}: render on the CPU, \
             which gives the same picture, or choose another --accel or device",
            device,
            if is_limited { "allowed" } else { "free" }
        )))
    }
}

/// With a unit of 1000, as the program writes them everywhere.
fn bytes(number: u64) -> String {
    match number as f64 {
        n if n < 999.5e3 => format!("{:.1} kB", n / 1e3),
        n if n < 999.5e6 => format!("{:.1} MB", n / 1e6),
        n => format!("{:.1} GB", n / 1e9),
    }
}

/// Copies the arrays to the device. Gives back the memory, to be kept, and its address there.
pub(crate) fn upload(
    stream: &Arc<CudaStream>,
    parameters: &Parameters,
) -> Result<(CudaSlice<u8>, u64), DriverError> {
    // SAFETY: what is not written below is never read.
    let mut memory = unsafe { stream.alloc::<u8>(parameters.bytes() as usize) }?;
    let (base, written) = memory.device_ptr_mut(stream);
    for piece in parameters.pieces().iter().filter(|piece| !piece.bytes.is_empty()) {
        // SAFETY: the layout keeps pieces inside the memory; the source lives until the stream is waited for below.
        unsafe { result::memcpy_htod_async(base + piece.offset, piece.bytes, stream.cu_stream()) }?;
    }
    stream.synchronize()?;
    drop(written);
    Ok((memory, base))
}

/// Copies items to an array on the device, from this number on, and waits for it.
///
/// # Safety
///
/// The array is there and has these items, and no kernel reads them now.
pub(crate) unsafe fn write<T: Copy>(
    stream: &Arc<CudaStream>,
    array: u64,
    first: u32,
    items: &[T],
) -> Result<(), DriverError> {
    if items.is_empty() {
        return Ok(());
    }
    // SAFETY: any memory can be looked at as bytes that need not be initialised.
    let bytes =
        unsafe { std::slice::from_raw_parts(items.as_ptr().cast::<MaybeUninit<u8>>(), size_of_val(items)) };
    let at = array + u64::from(first) * size_of::<T>() as u64;
    // Allocating does that by itself, copying to an address does not.
    stream.context().bind_to_thread()?;
    // SAFETY: the array has these items (the contract of this function); the source lives until the stream is waited for.
    unsafe { result::memcpy_htod_async(at, bytes, stream.cu_stream()) }?;
    stream.synchronize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_said_with_its_numbers() {
        let needs = Needs { scene: 70_000_000_000, film: 100_663_296, stacks: 1_900_000_000, queues: 0 };
        assert!(needs.check(72_000_663_296, "cuda:0", false).is_ok());
        let message = needs.check(71_999_000_000, "cuda:0 (H100)", false).unwrap_err().to_string();
        let parts = [
            "cuda:0 (H100)",
            "72.0 GB are needed",
            "70.0 GB for",
            "100.7 MB for",
            "1.9 GB for",
            "72.0 GB are free",
        ];
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
        assert!(
            Needs { scene: u64::MAX, film: 1, stacks: 1, queues: 1 }.check(1 << 40, "cuda:0", true).is_err()
        );
    }
}
