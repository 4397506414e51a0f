//! Launches: a band of rows of a scene on a device.

use crate::device::Device;
use crate::scene::DeviceScene;
use crate::staging::Staging;
use cudarc::driver::sys::CUevent_flags;
use cudarc::driver::{CudaEvent, CudaSlice, DevicePtr, DriverError, LaunchConfig, PushKernelArg};
use eosphor_core::math::Vec3;
use eosphor_render::RayStatistics;
use std::ops::Range;

/// Kinds of rays that kernels count.
const RAY_KINDS: usize = 5;

/// Rows that a warp covers: 8 × 4 pixels.
pub(crate) const WARP_ROWS: u32 = 4;

/// Threads of a warp.
const WARP: u32 = 32;

/// A device's room for what launches write: two bands, so that one is rendered while the other travels back.
pub(crate) struct Room {
    bands: [Band; 2],
    staging: Staging,
}

/// A band's room on the device.
struct Band {
    /// Three floats a pixel.
    film: CudaSlice<f32>,
    totals: CudaSlice<u64>,
}

/// Bands that [`Room`] holds.
pub(crate) const BANDS: u64 = 2;

impl Room {
    /// For bands of at most this many pixels.
    pub(crate) fn new(device: &Device, pixels: usize) -> Result<Room, DriverError> {
        let band = || {
            let film = device.stream.alloc_zeros(pixels * 3)?;
            Ok(Band { film, totals: device.stream.alloc_zeros(RAY_KINDS)? })
        };
        Ok(Room { bands: [band()?, band()?], staging: Staging::new(device.stream.context())? })
    }
}

/// Launches kernels for bands of rows.
pub(crate) struct Launcher<'a> {
    pub(crate) device: &'a Device,
    pub(crate) scene: &'a DeviceScene,
    /// Threads of a block.
    pub(crate) block_size: u32,
    pub(crate) room: &'a mut Room,
}

/// A band that is being rendered.
pub(crate) struct Launched {
    pub(crate) rows: Range<u32>,
    /// Which of the room's bands.
    band: usize,
    start: CudaEvent,
    end: CudaEvent,
}

impl Launcher<'_> {
    /// Starts to render rows, the room's bands by turns.
    pub(crate) fn launch(&mut self, rows: Range<u32>, band: usize) -> Result<Launched, DriverError> {
        let stream = &self.device.stream;
        let Band { film, totals } = &mut self.room.bands[band];
        let pixels = rows.len() * self.scene.width as usize;
        assert!(pixels * 3 <= film.len(), "the band is larger than the film");
        stream.memset_zeros(totals)?;
        let mut launch = stream.launch_builder(&self.scene.kernel);
        for parameter in &self.scene.parameters {
            launch.arg(parameter);
        }
        launch.arg(&rows.start).arg(&rows.end).arg(film).arg(totals);
        let shape = launch_shape(self.scene.width, rows.end - rows.start, self.block_size);
        let start = stream.record_event(Some(CUevent_flags::CU_EVENT_DEFAULT))?;
        // SAFETY: the parameters are those of the kernel, in its order (a test compares them); the arrays are those of a
        // SceneData and a hierarchy over it, whose indices are in range; the film has room for the rows.
        unsafe { launch.launch(shape) }?;
        let end = stream.record_event(Some(CUevent_flags::CU_EVENT_DEFAULT))?;
        Ok(Launched { rows, band, start, end })
    }

    /// Waits for a band and takes it back. Also says how many seconds the device took for it.
    pub(crate) fn finish(
        &mut self,
        launched: &Launched,
        colors: &mut [Vec3],
    ) -> Result<(RayStatistics, f64), DriverError> {
        launched.end.synchronize()?;
        let seconds = launched.start.elapsed_ms(&launched.end)? as f64 * 1e-3;
        let stream = &self.device.stream;
        let band = &self.room.bands[launched.band];
        assert!(colors.len() * 3 <= band.film.len(), "the band has more pixels than were rendered");
        self.room.staging.copy_back(band.film.device_ptr(stream).0, colors)?;
        let mut totals = [0; RAY_KINDS];
        self.room.staging.copy_numbers(band.totals.device_ptr(stream).0, &mut totals)?;
        // The order is that of `gpu/src/totals.rs`.
        let statistics = RayStatistics {
            camera: totals[0],
            reflected: totals[1],
            refracted: totals[2],
            glossy: totals[3],
            shadow: totals[4],
            ..RayStatistics::default()
        };
        Ok((statistics, seconds))
    }
}

const _: () = assert!(size_of::<Vec3>() == 12 && align_of::<Vec3>() == align_of::<f32>());

/// Enough blocks for 8 × 4 pixels a warp.
fn launch_shape(width: u32, rows: u32, block_size: u32) -> LaunchConfig {
    let warps = width.div_ceil(8) * rows.div_ceil(WARP_ROWS);
    LaunchConfig {
        grid_dim: (warps.div_ceil(block_size / WARP), 1, 1),
        block_dim: (block_size, 1, 1),
        shared_mem_bytes: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_a_thread_for_every_pixel() {
        for (width, rows, block_size) in
            [(1, 1, 128), (8, 4, 32), (9, 5, 64), (801, 600, 96), (65_535, 4, 128)]
        {
            let shape = launch_shape(width, rows, block_size);
            let warps = shape.grid_dim.0 * block_size / 32;
            let needed = width.div_ceil(8) * rows.div_ceil(4);
            assert!((needed..needed + block_size / 32).contains(&warps), "{width} {rows} {block_size}");
        }
    }
}
