//! Launches: a band of rows of a scene on a device.

use crate::device::Device;
use crate::scene::DeviceScene;
use cudarc::driver::{CudaSlice, DriverError, LaunchConfig, PushKernelArg};
use eosphor_core::math::Vec3;
use eosphor_render::RayStatistics;

/// Kinds of rays that kernels count.
const RAY_KINDS: usize = 5;

/// Rows that a warp covers: 8 × 4 pixels.
pub(crate) const WARP_ROWS: u32 = 4;

/// Threads of a warp.
const WARP: u32 = 32;

/// A device's room for what launches write, used again for each band.
pub(crate) struct Launcher<'a> {
    device: &'a Device,
    scene: &'a DeviceScene,
    /// Threads of a block.
    block_size: u32,
    /// Three floats a pixel.
    film: CudaSlice<f32>,
    totals: CudaSlice<u64>,
}

impl<'a> Launcher<'a> {
    /// For bands of at most this many pixels.
    pub(crate) fn new(
        device: &'a Device,
        scene: &'a DeviceScene,
        block_size: u32,
        pixels: usize,
    ) -> Result<Launcher<'a>, DriverError> {
        let film = device.stream.alloc_zeros(pixels * 3)?;
        Ok(Launcher { device, scene, block_size, film, totals: device.stream.alloc_zeros(RAY_KINDS)? })
    }

    /// Renders rows from `first_row` on, as many as `colors` has room for, and waits for them.
    pub(crate) fn render_rows(
        &mut self,
        first_row: u32,
        colors: &mut [Vec3],
    ) -> Result<RayStatistics, DriverError> {
        let stream = &self.device.stream;
        let end_row = first_row + (colors.len() / self.scene.width as usize) as u32;
        assert!(colors.len() * 3 <= self.film.len(), "the band is larger than the film");
        stream.memset_zeros(&mut self.totals)?;
        let mut launch = stream.launch_builder(&self.scene.kernel);
        for parameter in &self.scene.parameters {
            launch.arg(parameter);
        }
        launch.arg(&first_row).arg(&end_row).arg(&mut self.film).arg(&mut self.totals);
        let shape = launch_shape(self.scene.width, end_row - first_row, self.block_size);
        // SAFETY: the parameters are those of the kernel, in its order (a test compares them); the arrays are those of a
        // SceneData and a hierarchy over it, whose indices are in range; the film has room for the rows.
        unsafe { launch.launch(shape) }?;
        // SAFETY: a Vec3 is three floats without padding.
        let floats = unsafe { std::slice::from_raw_parts_mut(colors.as_mut_ptr().cast(), colors.len() * 3) };
        stream.memcpy_dtoh(&self.film.slice(..floats.len()), floats)?;
        let totals = stream.clone_dtoh(&self.totals)?;
        stream.synchronize()?;
        // The order is that of `gpu/src/totals.rs`.
        Ok(RayStatistics {
            camera: totals[0],
            reflected: totals[1],
            refracted: totals[2],
            glossy: totals[3],
            shadow: totals[4],
            ..RayStatistics::default()
        })
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
