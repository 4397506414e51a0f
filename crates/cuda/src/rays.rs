//! Queries about rays, without a picture.

use crate::device::{Device, devices};
use crate::memory::{Needs, upload};
use crate::parameters::Parameters;
use crate::ptx::MOST_THREADS;
use crate::scene::add_packed;
use crate::structure::add_bvh;
use cudarc::driver::sys::CUevent_flags;
use cudarc::driver::{CudaFunction, CudaSlice, DriverError, LaunchConfig, PushKernelArg};
use eosphor_accel::Bvh;
use eosphor_core::ray::{Hit, Ray};
use eosphor_render::BackendError;

/// The kernels of `gpu/src/rays.rs`: closest hits, and whether anything is in the way; then the same where there is no
/// instance but the world.
pub(crate) const RAY_KERNELS: [[&str; 2]; 2] =
    [["closest_hits_bvh", "occluded_bvh"], ["closest_hits_world", "occluded_world"]];

/// A bounding volume hierarchy on a device, to be asked about rays.
pub struct CudaRays {
    device: Device,
    /// What kernels take before the rays.
    parameters: Vec<u64>,
    /// Where the hierarchy is; kept for as long as the parameters name it.
    _memory: CudaSlice<u8>,
}

/// Answers, and how long the device took for them.
#[derive(Clone, Debug)]
pub struct Timed<T> {
    /// In the order of the rays.
    pub answers: Vec<T>,
    /// Milliseconds of each repetition, by the device's clock: the kernel alone.
    pub milliseconds: Vec<f32>,
}

impl CudaRays {
    /// Copies a hierarchy to a device.
    ///
    /// # Errors
    ///
    /// [`BackendError::Unavailable`] where there is no such device; [`BackendError::OutOfMemory`].
    pub fn new(ordinal: usize, bvh: &Bvh) -> Result<CudaRays, BackendError> {
        let found = devices()?;
        let info = found
            .get(ordinal)
            .ok_or_else(|| BackendError::Unavailable(format!("there is no device cuda:{ordinal}")))?;
        let only_world = bvh.primitives.instances.len() == 1;
        let device = Device::open(info, &RAY_KERNELS[only_world as usize])?;
        let fail = |error| device.failure("copying the hierarchy", error);
        let parameters = bvh_parameters(bvh);
        Needs { scene: parameters.bytes(), film: 0, stacks: device.stack_bytes().map_err(fail)? }
            .check(device.free_bytes().map_err(fail)?, &device.name)?;
        let (memory, base) = upload(&device.stream, &parameters).map_err(fail)?;
        Ok(CudaRays { parameters: parameters.values(base), _memory: memory, device })
    }

    /// The device's name.
    pub fn device_name(&self) -> &str {
        &self.device.name
    }

    /// Closest hits; asked once to warm up and then `repeats` times.
    ///
    /// # Errors
    ///
    /// [`BackendError::OutOfMemory`], or what the driver says.
    pub fn closest_hits(&self, rays: &[Ray], repeats: usize) -> Result<Timed<Hit>, BackendError> {
        let fail = |error| self.device.failure("tracing rays", error);
        self.ask(&self.device.kernels[0], rays, Hit::miss(0.0), repeats).map_err(fail)
    }

    /// Whether anything is in the way; the same.
    ///
    /// # Errors
    ///
    /// As for [`CudaRays::closest_hits`].
    pub fn occluded(&self, rays: &[Ray], repeats: usize) -> Result<Timed<bool>, BackendError> {
        let fail = |error| self.device.failure("tracing rays", error);
        let timed = self.ask(&self.device.kernels[1], rays, 0u32, repeats).map_err(fail)?;
        let answers = timed.answers.iter().map(|&hidden| hidden != 0).collect();
        Ok(Timed { answers, milliseconds: timed.milliseconds })
    }

    fn ask<T: Copy>(
        &self,
        kernel: &CudaFunction,
        rays: &[Ray],
        nothing: T,
        repeats: usize,
    ) -> Result<Timed<T>, DriverError> {
        let stream = &self.device.stream;
        let mut parameters = Parameters::default();
        parameters.array(rays);
        let (_memory, device_rays) = upload(stream, &parameters)?;
        let mut answers = stream.alloc_zeros::<u8>(size_of::<T>() * rays.len().max(1))?;
        let count = rays.len() as u32;
        let shape = LaunchConfig {
            grid_dim: (count.div_ceil(MOST_THREADS).max(1), 1, 1),
            block_dim: (MOST_THREADS, 1, 1),
            shared_mem_bytes: 0,
        };
        let mut milliseconds = Vec::with_capacity(repeats);
        for repeat in 0..=repeats {
            let mut launch = stream.launch_builder(kernel);
            // The order is that of `gpu/src/rays.rs`.
            for parameter in &self.parameters {
                launch.arg(parameter);
            }
            launch.arg(&device_rays).arg(&count).arg(&mut answers);
            let start = stream.record_event(Some(CUevent_flags::CU_EVENT_DEFAULT))?;
            // SAFETY: the arguments are those of the kernel, in its order; the arrays are those of a hierarchy, whose
            // indices are in range; there are as many rays and answers as is said.
            unsafe { launch.launch(shape) }?;
            let end = stream.record_event(Some(CUevent_flags::CU_EVENT_DEFAULT))?;
            let time = start.elapsed_ms(&end)?;
            if repeat > 0 {
                milliseconds.push(time);
            }
        }
        let mut found = vec![nothing; rays.len()];
        if !found.is_empty() {
            // SAFETY: answers are plain numbers without padding, of which the kernel has written every one.
            let bytes = unsafe {
                std::slice::from_raw_parts_mut(found.as_mut_ptr().cast::<u8>(), size_of_val(&found[..]))
            };
            stream.memcpy_dtoh(&answers, bytes)?;
            stream.synchronize()?;
        }
        Ok(Timed { answers: found, milliseconds })
    }
}

/// What the kernels take of a hierarchy, in the order of `gpu/src/rays.rs`.
pub(crate) fn bvh_parameters(bvh: &Bvh) -> Parameters<'_> {
    let mut parameters = Parameters::default();
    let primitives = add_bvh(&mut parameters, bvh);
    add_packed(&mut parameters, &primitives);
    parameters
}
