//! What launches write on a device.

use crate::device::Device;
use crate::queue_room::{QueueRoom, QueueSize};
use crate::staging::Staging;
use cudarc::driver::{CudaSlice, CudaStream, DriverError};
use eosphor_core::device::RayTotals;
use std::sync::Arc;

/// A device's room for what launches write: two bands, so that one is rendered while the other travels back.
pub(crate) struct LaunchBuffers {
    pub(crate) bands: [Band; 2],
    pub(crate) staging: Staging,
}

/// A band's room on the device.
pub(crate) struct Band {
    /// Of its own, so that a band begins while threads of the one before are still at work.
    pub(crate) stream: Arc<CudaStream>,
    /// What kernels make of each pixel.
    pub(crate) pixels: CudaSlice<u64>,
    /// [`RayTotals`].
    pub(crate) totals: CudaSlice<u64>,
    /// Where kernels take paths from queues.
    pub(crate) paths: Option<QueueRoom>,
}

/// Bands that [`LaunchBuffers`] holds.
pub(crate) const BANDS: u64 = 2;

impl LaunchBuffers {
    /// For bands whose pixels take at most this many bytes, with queues of such a size.
    pub(crate) fn new(
        device: &Device,
        bytes: usize,
        queue: Option<QueueSize>,
    ) -> Result<LaunchBuffers, DriverError> {
        let band = || {
            let stream = device.stream.context().new_stream()?;
            let pixels = stream.alloc_zeros(bytes.div_ceil(size_of::<u64>()))?;
            let totals = stream.alloc_zeros(size_of::<RayTotals>() / size_of::<u64>())?;
            let paths = queue.map(|size| QueueRoom::new(&stream, size)).transpose()?;
            Ok(Band { stream, pixels, totals, paths })
        };
        Ok(LaunchBuffers { bands: [band()?, band()?], staging: Staging::new(device.stream.context())? })
    }

    /// Whether it is for bands of so many bytes with such queues.
    pub(crate) fn suits(&self, bytes: usize, queue: Option<QueueSize>) -> bool {
        let own = self.bands[0].paths.as_ref().map(QueueRoom::size);
        let has_queue = match (own, queue) {
            (Some(own), Some(queue)) => own.suits(&queue),
            (own, queue) => own.is_none() && queue.is_none(),
        };
        has_queue && self.band_bytes() >= bytes
    }

    /// Bytes that the pixels of a band may take.
    fn band_bytes(&self) -> usize {
        self.bands[0].pixels.num_bytes()
    }
}
