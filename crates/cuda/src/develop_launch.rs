//! Developing on a device: the colours of a band become bytes behind them.

use crate::device::{Device, Kernel};
use crate::launch_buffers::Band;
use crate::pixel::{Pixel, Rgb};
use cudarc::driver::{DevicePtr, DeviceRepr, DriverError, LaunchConfig, PushKernelArg};
use eosphor_core::develop::Development;
use eosphor_core::device::DevelopLaunch;
use eosphor_render::BackendError;

/// The kernel that develops.
pub(crate) const KERNEL: &str = "develop_film";

/// Makes bytes of colours in one way.
pub(crate) struct Developer {
    kernel: Kernel,
    block_size: u32,
    development: Development,
}

impl Developer {
    /// Loads the kernel, for blocks of so many threads.
    pub(crate) fn new(
        device: &Device,
        block_size: u32,
        development: Development,
    ) -> Result<Developer, BackendError> {
        Ok(Developer { kernel: device.kernel(KERNEL, block_size)?, block_size, development })
    }

    /// Makes the bytes of so many pixels, once what the band's stream has in work is done.
    pub(crate) fn develop(&self, band: &Band, pixels: u32) -> Result<(), DriverError> {
        assert!(
            Rgb::bytes_on_device(pixels as usize) <= band.pixels.num_bytes(),
            "there is no room for bytes"
        );
        let film = band.pixels.device_ptr(&band.stream).0;
        let words = film + Rgb::offset_on_device(pixels as usize) as u64;
        let launch = Argument(DevelopLaunch {
            film: film as *const _,
            words: words as *mut u32,
            pixels,
            development: self.development,
        });
        let shape = LaunchConfig {
            grid_dim: (DevelopLaunch::threads(pixels).div_ceil(self.block_size).max(1), 1, 1),
            block_dim: (self.block_size, 1, 1),
            shared_mem_bytes: 0,
        };
        let mut builder = band.stream.launch_builder(&self.kernel.function);
        builder.arg(&launch);
        // SAFETY: the kernel takes this type (a test compares); so many colours are there, and behind them is room for their bytes
        // (the assertion).
        unsafe { builder.launch(shape) }.map(drop)
    }
}

/// A [`DevelopLaunch`] as an argument of a kernel. Its pointers are the device's.
#[repr(transparent)]
struct Argument(DevelopLaunch);

// SAFETY: the kernel declares the same `repr(C)` type.
unsafe impl DeviceRepr for Argument {}
