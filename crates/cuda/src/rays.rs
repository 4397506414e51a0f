//! Queries about rays, without a picture.

use crate::device::{Device, Kernel, devices};
use crate::memory::{Needs, upload};
use crate::parameters::Parameters;
use crate::scene::add_packed;
use crate::structure::{Trees, add_trees};
use crate::traversal::Traversal;
use cudarc::driver::sys::CUevent_flags;
use cudarc::driver::{CudaSlice, DriverError, LaunchConfig, PushKernelArg};
use eosphor_accel::Bvh;
use eosphor_core::device::HitRow;
use eosphor_core::ray::{Hit, Ray};
use eosphor_render::BackendError;
use std::slice;

/// Those of the kernels below that are for rays of which many start far away, if they have a kernel of their own.
pub(crate) fn far_ray_kernels(traversal: Traversal) -> Option<[[&'static str; 2]; 2]> {
    let far = [["closest_hits_far", "occluded_far"], ["closest_hits_world_far", "occluded_world_far"]];
    (traversal != Traversal::Wide).then_some(far)
}

/// The kernels of `gpu/src/rays.rs`: closest hits, and whether anything is in the way; then the same where there is no
/// instance but the world.
pub(crate) fn ray_kernels(traversal: Traversal) -> [[&'static str; 2]; 2] {
    match traversal {
        Traversal::Auto | Traversal::Single | Traversal::Vote => {
            [["closest_hits_bvh", "occluded_bvh"], ["closest_hits_world", "occluded_world"]]
        }
        Traversal::Reconverge => [
            ["closest_hits_in_step", "occluded_in_step"],
            ["closest_hits_world_in_step", "occluded_world_in_step"],
        ],
        Traversal::Wide => {
            [["closest_hits_wide", "occluded_wide"], ["closest_hits_world_wide", "occluded_world_wide"]]
        }
    }
}

/// Threads of a block: small, so that a warp that is done makes room for another one before its neighbours are.
const RAYS_IN_BLOCK: u32 = 64;

/// So many rays are looked at, at most, to find out whether they start far away.
const SAMPLES: usize = 4096;

/// A bounding volume hierarchy on a device, to be asked about rays.
pub struct CudaRays {
    device: Device,
    /// Closest hits, and whether anything is in the way.
    kernels: [Kernel; 2],
    /// The same for rays of which many start from beyond [`CudaRays::reach`].
    far_kernels: [Kernel; 2],
    /// Nearer along each axis, rays do not start far away.
    reach: f32,
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

/// What kernels answer.
struct Asked<T> {
    answers: Vec<T>,
    hit_instances: Vec<u32>,
    milliseconds: Vec<f32>,
}

impl CudaRays {
    /// Copies a hierarchy to a device.
    ///
    /// # Errors
    ///
    /// [`BackendError::Unavailable`] where there is no such device; [`BackendError::OutOfMemory`].
    pub fn new(ordinal: usize, bvh: &Bvh, traversal: Traversal) -> Result<CudaRays, BackendError> {
        let found = devices()?;
        let info = found
            .get(ordinal)
            .ok_or_else(|| BackendError::Unavailable(format!("there is no device cuda:{ordinal}")))?;
        let only_world = bvh.primitives().instances().len() == 1;
        let device = Device::open(info, None)?;
        let near = ray_kernels(traversal)[only_world as usize];
        let far = far_ray_kernels(traversal).map_or(near, |kernels| kernels[only_world as usize]);
        let groups = near.iter().chain(&far).map(slice::from_ref);
        device.load(&groups.collect::<Vec<_>>(), RAYS_IN_BLOCK)?;
        let kernels = device.kernels(near, RAYS_IN_BLOCK)?;
        let far_kernels = device.kernels(far, RAYS_IN_BLOCK)?;
        let fail = |error| device.failure("copying the hierarchy", error);
        let trees = Trees::new(bvh, traversal, 0)?;
        let parameters = bvh_parameters(bvh, &trees);
        let reach = trees.reach();
        let stacks = device.stack_bytes(&kernels[0]).map_err(fail)?;
        let stacks = stacks.max(device.stack_bytes(&far_kernels[0]).map_err(fail)?);
        Needs { scene: parameters.bytes(), film: 0, stacks, queues: 0 }.check(
            device.free_bytes().map_err(fail)?,
            &device.name,
            false,
        )?;
        let (memory, base) = upload(&device.stream, &parameters).map_err(fail)?;
        Ok(CudaRays {
            parameters: parameters.values(base),
            _memory: memory,
            kernels,
            far_kernels,
            reach,
            device,
        })
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
        let nothing = HitRow { t: 0.0, u: 0.0, v: 0.0, primitive: 0 };
        let asked = self.ask(0, rays, nothing, repeats).map_err(fail)?;
        let answers = asked.answers.iter().zip(&asked.hit_instances);
        let answers = answers.map(|(row, &instance)| row.hit(instance)).collect();
        Ok(Timed { answers, milliseconds: asked.milliseconds })
    }

    /// For each ray, whether it hits anything between its `t_min` and `t_max`; asked once to warm up and then `repeats` times.
    ///
    /// # Errors
    ///
    /// As for [`CudaRays::closest_hits`].
    pub fn occluded(&self, rays: &[Ray], repeats: usize) -> Result<Timed<bool>, BackendError> {
        let fail = |error| self.device.failure("tracing rays", error);
        let asked = self.ask(1, rays, 0u32, repeats).map_err(fail)?;
        let answers = asked.answers.iter().map(|&hidden| hidden != 0).collect();
        Ok(Timed { answers, milliseconds: asked.milliseconds })
    }

    /// Whether a kernel for far rays is faster: if a quarter of the rays is far, by some of them.
    fn start_far_away(&self, rays: &[Ray]) -> bool {
        let step = rays.len().div_ceil(SAMPLES).max(1);
        let is_far = |ray: &&Ray| ray.origin.abs().max_component() > self.reach;
        let far = rays.iter().step_by(step).filter(is_far).count();
        far > 0 && 4 * far >= rays.len().div_ceil(step)
    }

    fn ask<T: Copy>(
        &self,
        query: usize,
        rays: &[Ray],
        nothing: T,
        repeats: usize,
    ) -> Result<Asked<T>, DriverError> {
        let stream = &self.device.stream;
        let kernel = if self.start_far_away(rays) { &self.far_kernels[query] } else { &self.kernels[query] };
        let mut parameters = Parameters::default();
        parameters.array("rays", rays);
        let (_memory, device_rays) = upload(stream, &parameters)?;
        let mut answers = stream.alloc_zeros::<u8>(size_of::<T>() * rays.len().max(1))?;
        // Zeros where the kernel writes none: all hits are in the world then.
        let mut hit_instances = stream.alloc_zeros::<u32>(rays.len().max(1))?;
        let count = rays.len() as u32;
        let shape = LaunchConfig {
            grid_dim: (count.div_ceil(RAYS_IN_BLOCK).max(1), 1, 1),
            block_dim: (RAYS_IN_BLOCK, 1, 1),
            shared_mem_bytes: 0,
        };
        let mut milliseconds = Vec::with_capacity(repeats);
        for repeat in 0..=repeats {
            let mut launch = stream.launch_builder(&kernel.function);
            // The order is that of `gpu/src/rays.rs`.
            for parameter in &self.parameters {
                launch.arg(parameter);
            }
            launch.arg(&device_rays).arg(&count).arg(&mut answers).arg(&mut hit_instances);
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
        let hit_instances = stream.clone_dtoh(&hit_instances)?[..rays.len()].to_vec();
        Ok(Asked { answers: found, hit_instances, milliseconds })
    }
}

/// What the kernels take of a hierarchy, in the order of `gpu/src/rays.rs`.
pub(crate) fn bvh_parameters<'a>(bvh: &'a Bvh, trees: &'a Trees) -> Parameters<'a> {
    let mut parameters = Parameters::default();
    let primitives = add_trees(&mut parameters, bvh, trees);
    add_packed(&mut parameters, &primitives);
    parameters.array("geometries", primitives.geometries);
    parameters.array("instances", primitives.instances);
    parameters.count("instance_count", primitives.instances.len());
    parameters
}
