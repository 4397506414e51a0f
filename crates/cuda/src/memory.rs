//! Arrays of core's types on the device.

use cudarc::driver::{CudaSlice, CudaStream, DeviceRepr, DriverError};
use std::sync::Arc;

/// A value that lies in the device's memory as it does in ours: core's types are `repr(C)` without pointers, and
/// host and device agree on sizes, alignment and byte order.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct Plain<T: Copy>(T);

// SAFETY: this crate puts only types of the kernels' parameters inside, which fulfil what the type says.
unsafe impl<T: Copy> DeviceRepr for Plain<T> {}

/// An array on the device.
pub(crate) type DeviceArray<T> = CudaSlice<Plain<T>>;

/// Copies an array to the device. An empty one becomes a place that is never read, because kernels take references.
pub(crate) fn upload<T: Copy>(stream: &Arc<CudaStream>, items: &[T]) -> Result<DeviceArray<T>, DriverError> {
    if items.is_empty() {
        return allocate(stream, 1);
    }
    // SAFETY: Plain is a transparent wrapper.
    let plain = unsafe { std::slice::from_raw_parts(items.as_ptr().cast::<Plain<T>>(), items.len()) };
    stream.clone_htod(plain)
}

/// Room for an array that a kernel writes.
pub(crate) fn allocate<T: Copy>(
    stream: &Arc<CudaStream>,
    length: usize,
) -> Result<DeviceArray<T>, DriverError> {
    // SAFETY: it is written before it is read, by a kernel, or never read.
    unsafe { stream.alloc(length) }
}

/// Copies an array that a kernel has written completely back from the device.
pub(crate) fn download<T: Copy>(
    stream: &Arc<CudaStream>,
    array: &DeviceArray<T>,
    items: &mut [T],
) -> Result<(), DriverError> {
    // SAFETY: Plain is a transparent wrapper.
    let plain = unsafe { std::slice::from_raw_parts_mut(items.as_mut_ptr().cast::<Plain<T>>(), items.len()) };
    stream.memcpy_dtoh(array, plain)?;
    stream.synchronize()
}
