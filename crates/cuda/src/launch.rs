//! Launches: a band of rows of a scene on a device.

use crate::develop_launch::Developer;
use crate::device::Kernel;
use crate::launch_buffers::{Band, LaunchBuffers};
use crate::pixel::Pixel;
use crate::queue_launch::{QueueKernels, QueueLauncher, QueuedBand};
use crate::scene::{DeviceScene, FrameParameters, Kernels};
use crate::stages::Stages;
use cudarc::driver::sys::CUevent_flags;
use cudarc::driver::{CudaEvent, DevicePtr, DeviceRepr, DriverError, LaunchConfig, PushKernelArg};
use eosphor_core::device::{BandLaunch, RayTotals};
use eosphor_core::math::Vec3;
use eosphor_core::sums::ExactSum;
use eosphor_render::{QueryTimes, RayStatistics};
use std::ops::Range;

/// Rows that a warp covers: 8 × 4 pixels.
pub(crate) const WARP_ROWS: u32 = 4;

/// Threads of a warp.
const WARP: u32 = 32;

/// Launches kernels for bands of rows.
pub(crate) struct Launcher<'a> {
    pub(crate) scene: &'a DeviceScene,
    pub(crate) parameters: &'a FrameParameters<'a>,
    /// Pixels of a row.
    pub(crate) width: u32,
    /// Threads of a block.
    pub(crate) block_size: u32,
    /// The samples of each pixel that are taken.
    pub(crate) samples: Range<u32>,
    /// How many threads share the samples of a pixel, as a power of two.
    pub(crate) sharing: u32,
    /// What makes bytes of colours, where these are wanted.
    pub(crate) developer: Option<&'a Developer>,
    /// Where it is noted what kernels of queues take, if that is wanted.
    pub(crate) stages: Option<&'a Stages>,
    pub(crate) room: &'a mut LaunchBuffers,
}

/// A band that is being rendered.
pub(crate) struct Launched {
    pub(crate) rows: Range<u32>,
    /// Which of the room's bands.
    band: usize,
    start: CudaEvent,
    end: Option<CudaEvent>,
    /// Where paths are in queues, how far they are.
    paths: Option<QueuedBand>,
}

impl Launcher<'_> {
    /// Starts to render rows, the room's bands by turns.
    pub(crate) fn launch<T: Pixel>(
        &mut self,
        rows: Range<u32>,
        band: usize,
    ) -> Result<Launched, DriverError> {
        let pixels = rows.len() * self.width as usize;
        let own = &mut self.room.bands[band];
        assert!(T::bytes_on_device(pixels) <= own.pixels.num_bytes(), "the band is larger than its room");
        own.stream.memset_zeros(&mut own.totals)?;
        let start = own.stream.record_event(Some(CUevent_flags::CU_EVENT_DEFAULT))?;
        match &self.scene.kernels {
            Kernels::Whole(kernel) => {
                self.launch_whole::<T>(kernel, rows.clone(), band)?;
                let end = Some(self.end::<T>(&rows, band)?);
                Ok(Launched { rows, band, start, end, paths: None })
            }
            Kernels::Queues(kernels) => {
                let launcher = self.paths(kernels, rows.clone());
                let samples = self.samples.clone();
                let paths = Some(launcher.start::<T>(samples, &mut self.room.bands[band])?);
                Ok(Launched { rows, band, start, end: None, paths })
            }
        }
    }

    /// What is done with the colours of a band, and the end of its work.
    fn end<T: Pixel>(&self, rows: &Range<u32>, band: usize) -> Result<CudaEvent, DriverError> {
        let band = &self.room.bands[band];
        if let (true, Some(developer)) = (T::IS_DEVELOPED, self.developer) {
            developer.develop(band, rows.len() as u32 * self.width)?;
        }
        band.stream.record_event(Some(CUevent_flags::CU_EVENT_DEFAULT))
    }

    /// What launches kernels that work on queues.
    fn paths<'l>(&self, kernels: &'l QueueKernels, rows: Range<u32>) -> QueueLauncher<'l>
    where
        Self: 'l,
    {
        QueueLauncher {
            kernels,
            values: &self.parameters.values,
            scene_values: self.scene.structure_values,
            counts: self.parameters.counts,
            frame: &self.parameters.kind,
            width: self.width,
            rows,
            block_size: self.block_size,
            stages: self.stages,
        }
    }

    fn launch_whole<T: Pixel>(
        &self,
        kernel: &Kernel,
        rows: Range<u32>,
        band: usize,
    ) -> Result<(), DriverError> {
        let Band { stream, pixels, totals, .. } = &self.room.bands[band];
        let pixels = pixels.device_ptr(stream).0;
        let (film, sums) = if T::IS_SUM { (0, pixels) } else { (pixels, 0) };
        let mut launch = stream.launch_builder(&kernel.function);
        for parameter in &self.parameters.values {
            launch.arg(parameter);
        }
        let band_launch = Argument(BandLaunch {
            counts: self.parameters.counts,
            film: film as *mut Vec3,
            sums: sums as *mut ExactSum,
            totals: totals.device_ptr(stream).0 as *mut RayTotals,
            first_row: rows.start,
            end_row: rows.end,
            first_sample: self.samples.start,
            end_sample: self.samples.end,
            sharing: self.sharing,
        });
        launch.arg(&band_launch);
        let shape = launch_shape(self.width, rows.end - rows.start, self.sharing, self.block_size);
        // SAFETY: the parameters are those of the kernel, in its order (a test compares them); the arrays are those of a
        // SceneData and a hierarchy over it, whose indices are in range; there is room for the rows' pixels.
        unsafe { launch.launch(shape) }.map(drop)
    }

    /// Waits for a band and takes it back. Also says how many seconds the device took for it.
    pub(crate) fn finish<T: Pixel>(
        &mut self,
        launched: &mut Launched,
        pixels: &mut [T],
    ) -> Result<(RayStatistics, f64), DriverError> {
        if let (Some(paths), Kernels::Queues(kernels)) = (&mut launched.paths, &self.scene.kernels) {
            let launcher = self.paths(kernels, launched.rows.clone());
            let band = &mut self.room.bands[launched.band];
            launcher.finish::<T>(paths, band)?;
            launched.end = Some(self.end::<T>(&launched.rows, launched.band)?);
        }
        let end = launched.end.as_ref().expect("a band that was launched has an end");
        end.synchronize()?;
        let seconds = launched.start.elapsed_ms(end)? as f64 * 1e-3;
        let band = &self.room.bands[launched.band];
        let stream = &band.stream;
        assert!(
            T::bytes_on_device(pixels.len()) <= band.pixels.num_bytes(),
            "the band has more pixels than were rendered"
        );
        let from = band.pixels.device_ptr(stream).0 + T::offset_on_device(pixels.len()) as u64;
        // SAFETY: the kernels have written them there, as `launch` was told.
        unsafe { self.room.staging.copy_back(from, pixels) }?;
        let totals = self.room.staging.copy_totals(band.totals.device_ptr(stream).0)?;
        Ok((statistics(&totals), seconds))
    }
}

/// A [`BandLaunch`] as an argument of a kernel. Its pointers are the device's.
#[repr(transparent)]
struct Argument(BandLaunch);

// SAFETY: the kernel declares the same `repr(C)` type.
unsafe impl DeviceRepr for Argument {}

/// What a launch has counted.
fn statistics(totals: &RayTotals) -> RayStatistics {
    // How long a tick is depends on what the device does: it is what all threads took by both clocks.
    let length = totals.thread_nanoseconds as f64 / totals.thread_ticks.max(1) as f64;
    let nanoseconds = |ticks: u64| (ticks as f64 * length) as u64;
    RayStatistics {
        camera: totals.camera,
        reflected: totals.reflected,
        refracted: totals.refracted,
        glossy: totals.glossy,
        shadow: totals.shadow,
        searches: totals.searches,
        nodes_visited: totals.nodes,
        primitive_tests: totals.primitives,
        times: QueryTimes {
            traversal_nanoseconds: nanoseconds(totals.traversal_ticks),
            intersection_nanoseconds: nanoseconds(totals.intersection_ticks),
        },
    }
}

const _: () = assert!(size_of::<Vec3>() == 12 && align_of::<Vec3>() == align_of::<f32>());

/// Enough blocks for all tiles of a warp's pixels, as `gpu/src/band.rs` lays them out.
fn launch_shape(width: u32, rows: u32, sharing: u32, block_size: u32) -> LaunchConfig {
    let bits = WARP.trailing_zeros() - sharing;
    let (across, down) = (bits.div_ceil(2), bits / 2);
    let warps = width.div_ceil(1 << across) * rows.div_ceil(1 << down);
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
    fn ticks_become_nanoseconds() {
        let rays =
            RayTotals { camera: 1, reflected: 2, refracted: 3, glossy: 4, shadow: 5, ..Default::default() };
        let all = statistics(&RayTotals {
            searches: 6,
            nodes: 7,
            primitives: 8,
            traversal_ticks: 1000,
            intersection_ticks: 500,
            thread_ticks: 4000,
            thread_nanoseconds: 2000,
            ..rays
        });
        assert_eq!((all.total_rays(), all.searches, all.nodes_visited, all.primitive_tests), (15, 6, 7, 8));
        assert_eq!(all.times, QueryTimes { traversal_nanoseconds: 500, intersection_nanoseconds: 250 });
        // Kernels that do not count.
        let rays = statistics(&rays);
        assert_eq!((rays.searches, rays.times), (0, QueryTimes::default()));
    }

    #[test]
    fn there_are_threads_for_every_pixel() {
        for (width, rows, block_size) in
            [(1, 1, 128), (8, 4, 32), (9, 5, 64), (801, 600, 96), (65_535, 4, 128)]
        {
            for (sharing, across, down) in [(0, 8, 4), (1, 4, 4), (2, 4, 2), (3, 2, 2), (4, 2, 1), (5, 1, 1)]
            {
                let shape = launch_shape(width, rows, sharing, block_size);
                let warps = shape.grid_dim.0 * block_size / 32;
                let needed = width.div_ceil(across) * rows.div_ceil(down);
                assert!((needed..needed + block_size / 32).contains(&warps), "{width} {rows} {block_size}");
            }
        }
    }
}
