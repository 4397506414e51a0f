//! Queries about rays, without a picture.

use crate::device::{Device, devices};
use crate::failure::failure;
use crate::memory::{DeviceArray, allocate, download, upload};
use crate::ptx::{BLOCK, CLOSEST_HITS_BVH, OCCLUDED_BVH};
use cudarc::driver::sys::CUevent_flags;
use cudarc::driver::{CudaFunction, DriverError, LaunchConfig, PushKernelArg};
use eosphor_accel::Bvh;
use eosphor_core::geometry::{Geometry, Instance, Sphere};
use eosphor_core::hierarchy::BvhNode;
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::ray::{Hit, Ray};
use eosphor_render::BackendError;

/// A bounding volume hierarchy on a device, to be asked about rays.
pub struct CudaRays {
    device: Device,
    closest_hits: CudaFunction,
    occluded: CudaFunction,
    nodes: DeviceArray<BvhNode>,
    roots: DeviceArray<u32>,
    instance_order: DeviceArray<u32>,
    instance_root: u32,
    triangles: DeviceArray<PackedTriangle>,
    spheres: DeviceArray<Sphere>,
    sphere_primitives: DeviceArray<u32>,
    geometries: DeviceArray<Geometry>,
    instances: DeviceArray<Instance>,
    instance_count: u64,
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
        let info = found.get(ordinal).ok_or_else(|| {
            BackendError::Unavailable(format!("there is no device cuda:{ordinal}"))
        })?;
        let device = Device::open(info)?;
        let fail = |error| failure(&device.name, "copying the hierarchy", error);
        let stream = &device.stream;
        let p = &bvh.primitives;
        Ok(CudaRays {
            closest_hits: device.module.load_function(CLOSEST_HITS_BVH).map_err(fail)?,
            occluded: device.module.load_function(OCCLUDED_BVH).map_err(fail)?,
            nodes: upload(stream, &bvh.nodes).map_err(fail)?,
            roots: upload(stream, &bvh.roots).map_err(fail)?,
            instance_order: upload(stream, &bvh.instance_order).map_err(fail)?,
            instance_root: bvh.instance_root,
            triangles: upload(stream, &p.triangles).map_err(fail)?,
            spheres: upload(stream, &p.spheres).map_err(fail)?,
            sphere_primitives: upload(stream, &p.sphere_primitives).map_err(fail)?,
            geometries: upload(stream, &p.geometries).map_err(fail)?,
            instances: upload(stream, &p.instances).map_err(fail)?,
            instance_count: p.instances.len() as u64,
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
        self.ask(&self.closest_hits, rays, Hit::miss(0.0), repeats)
            .map_err(|error| failure(&self.device.name, "tracing rays", error))
    }

    /// Whether anything is in the way; the same.
    ///
    /// # Errors
    ///
    /// As for [`CudaRays::closest_hits`].
    pub fn occluded(&self, rays: &[Ray], repeats: usize) -> Result<Timed<bool>, BackendError> {
        let timed = self
            .ask(&self.occluded, rays, 0u32, repeats)
            .map_err(|error| failure(&self.device.name, "tracing rays", error))?;
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
        let device_rays = upload(stream, rays)?;
        let answers = allocate::<T>(stream, rays.len().max(1))?;
        let count = rays.len() as u32;
        let shape = LaunchConfig {
            grid_dim: (count.div_ceil(BLOCK).max(1), 1, 1),
            block_dim: (BLOCK, 1, 1),
            shared_mem_bytes: 0,
        };
        let mut milliseconds = Vec::with_capacity(repeats);
        for repeat in 0..=repeats {
            let mut launch = stream.launch_builder(kernel);
            // The order is that of `gpu/src/rays.rs`.
            launch.arg(&self.nodes).arg(&self.roots).arg(&self.instance_order).arg(&self.instance_root);
            launch.arg(&self.triangles).arg(&self.spheres).arg(&self.sphere_primitives);
            launch.arg(&self.geometries).arg(&self.instances).arg(&self.instance_count);
            launch.arg(&device_rays).arg(&count).arg(&answers);
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
            download(stream, &answers, &mut found)?;
        }
        Ok(Timed { answers: found, milliseconds })
    }
}
