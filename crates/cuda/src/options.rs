//! How the CUDA backend works.

use crate::ptx::{MOST_THREADS, USUAL_THREADS};
use crate::queue_room::PATHS;
use crate::scheduler::GpuScheduler;
use crate::structure::kernels;
use crate::traversal::Traversal;
use eosphor_core::settings::Integrator;
use eosphor_render::{Accel, BackendError, HierarchyOptions};

/// How the CUDA backend works. Nothing here changes a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct CudaOptions {
    /// Numbers of the devices that share the work; not empty.
    pub devices: Vec<usize>,
    /// The hierarchy: any but [`Accel::Bvh8`], which is made for the SIMD instructions of CPUs.
    pub accel: Accel,
    /// How it is built. Where no builder is named, path tracing with many samples a triangle cuts triangles
    /// ([`eosphor_render::Builder::Spatial`]).
    pub hierarchy: HierarchyOptions,
    /// Threads of a block: a multiple of 32 up to 512.
    pub block_size: u32,
    /// The way through a bounding volume hierarchy.
    pub traversal: Traversal,
    /// In which order rays are traced.
    pub scheduler: GpuScheduler,
    /// Paths, or rays of Whitted's trees, that a round of queues takes: 4,096 to 16,777,216. Where memory is short, there are
    /// fewer. `None`: a million, and of path tracing up to eight million, which are faster, in an eighth of the memory that is
    /// free.
    pub paths: Option<u32>,
    /// The most memory that a scene takes on a device, in bytes, with all that renders it: as if no more were free. Vertices that
    /// frames move come on top. `None`: what is free.
    pub memory_bytes: Option<u64>,
    /// Count what queries do and time it, by kernels that are made for that and take some times as long. They go through a
    /// bounding volume hierarchy as one ray does on a CPU, so that counts are the same there. Needed where
    /// [`eosphor_render::RenderControl::count_work`] is asked for.
    pub count_work: bool,
}

impl Default for CudaOptions {
    /// The first device, with a BVH and blocks of 128 threads.
    fn default() -> CudaOptions {
        CudaOptions {
            devices: vec![0],
            accel: Accel::Bvh,
            hierarchy: HierarchyOptions::default(),
            block_size: USUAL_THREADS,
            traversal: Traversal::Auto,
            scheduler: GpuScheduler::Auto,
            paths: None,
            memory_bytes: None,
            count_work: false,
        }
    }
}

impl CudaOptions {
    /// Whether there is such a way to render. This asks no device.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] with what to choose instead.
    pub fn check(&self) -> Result<(), BackendError> {
        // Integrators have the same structures.
        kernels(self.accel, self.traversal, false, self.count_work, Integrator::Whitted, self.scheduler)?;
        if self.traversal != Traversal::Auto && self.accel != Accel::Bvh {
            return Err(BackendError::Failed(format!(
                "{}: there are several ways through a bvh, one through {}: leave that out, or choose bvh",
                self.traversal.name(),
                self.accel
            )));
        }
        if self.traversal != Traversal::Auto && self.count_work {
            return Err(BackendError::Failed(format!(
                "{}: what is counted is the way of one ray: leave that out, or do not count",
                self.traversal.name()
            )));
        }
        if self.devices.is_empty() {
            return Err(BackendError::Failed("no CUDA device was chosen".into()));
        }
        if let Some(paths) = self.paths.filter(|paths| !PATHS.contains(paths)) {
            return Err(BackendError::Failed(format!(
                "{paths} paths at a time: it must be {} to {}",
                PATHS.start(),
                PATHS.end()
            )));
        }
        // A warp has 32 threads, and what is left of one would idle.
        match self.block_size.is_multiple_of(32) && (32..=MOST_THREADS).contains(&self.block_size) {
            true => Ok(()),
            false => Err(BackendError::Failed(format!(
                "blocks of {} threads: a block has a multiple of 32 threads (a warp), at most {MOST_THREADS}",
                self.block_size
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_whole_warps_and_not_too_large() {
        let check = |block_size| CudaOptions { block_size, ..CudaOptions::default() }.check();
        for block_size in [32, 64, 96, 128, 256, 512] {
            assert!(check(block_size).is_ok());
        }
        for block_size in [0, 1, 100, 544, 1024, u32::MAX] {
            assert!(
                check(block_size)
                    .unwrap_err()
                    .to_string()
                    .contains("a multiple of 32 threads (a warp), at most 512")
            );
        }
    }

    #[test]
    fn there_are_some_paths_and_not_too_many() {
        let check = |paths| CudaOptions { paths, ..CudaOptions::default() }.check();
        for paths in [None, Some(4096), Some(5000), Some(1 << 24)] {
            assert!(check(paths).is_ok());
        }
        for paths in [0, 4095, (1 << 24) + 1, u32::MAX] {
            assert!(check(Some(paths)).unwrap_err().to_string().contains("it must be 4096 to 16777216"));
        }
    }

    #[test]
    fn structures_and_devices_must_be_there() {
        let defaults = CudaOptions::default();
        assert!(CudaOptions { accel: Accel::Bvh8, ..defaults.clone() }.check().is_err());
        assert!(CudaOptions { accel: Accel::KdTree, ..defaults.clone() }.check().is_ok());
        let vote = CudaOptions { traversal: Traversal::Vote, ..defaults.clone() };
        assert!(vote.check().is_ok());
        assert!(CudaOptions { accel: Accel::Grid, ..vote }.check().is_err());
        assert!(CudaOptions { devices: Vec::new(), ..defaults }.check().is_err());
    }
}
