//! Which device renders.

use crate::arguments::{BackendChoice, DeviceFlags};
use crate::failure::Failure;
use eosphor::{
    Accel, Backend, Builder, CpuBackend, CpuOptions, CudaBackend, CudaOptions, FeaturePass, Hierarchy,
    SceneData,
};
use std::sync::Arc;

/// The backend that the flags ask for. `auto` is the CPU while the GPU kernels are not tuned.
pub(crate) fn backend_for(flags: &DeviceFlags, accel: Option<Accel>) -> Result<Box<dyn Backend>, Failure> {
    match &flags.backend {
        BackendChoice::Auto | BackendChoice::Cpu => Ok(Box::new(cpu_backend(flags, accel)?)),
        BackendChoice::Cuda(devices) => {
            let usual = CudaOptions::default();
            let options = CudaOptions {
                devices: devices.clone(),
                accel: accel.unwrap_or(usual.accel),
                builder: builder_for(flags),
                block_size: flags.block_size.unwrap_or(usual.block_size),
                traversal: flags.gpu_traversal,
            };
            options.check().map_err(Failure::usage)?;
            Ok(Box::new(CudaBackend::new(options)?))
        }
    }
}

/// The CPU, whatever else renders.
pub(crate) fn cpu_backend(flags: &DeviceFlags, accel: Option<Accel>) -> Result<CpuBackend, Failure> {
    Ok(CpuBackend::new(cpu_options(flags, accel))?)
}

/// What layers are made by. It is the CPU for every backend; where the picture is rendered there too, they share the
/// hierarchy.
pub(crate) fn feature_pass(
    flags: &DeviceFlags,
    accel: Option<Accel>,
    scene: Arc<SceneData>,
    hierarchy: Option<Arc<Hierarchy>>,
) -> Result<FeaturePass, Failure> {
    Ok(cpu_backend(flags, accel)?.feature_pass(scene, hierarchy)?)
}

/// How bounding volume hierarchies are built.
pub(crate) fn builder_for(flags: &DeviceFlags) -> Builder {
    flags.builder.unwrap_or(CpuOptions::default().builder)
}

fn cpu_options(flags: &DeviceFlags, accel: Option<Accel>) -> CpuOptions {
    CpuOptions {
        threads: flags.threads.map(usize::from),
        tile: flags.tile,
        accel: accel.unwrap_or(CpuOptions::default().accel),
        builder: builder_for(flags),
        simd: flags.simd.0,
        scheduler: flags.scheduler,
    }
}

/// Gives the thread pool that everything but tracing uses (developing, writing) the same number of threads.
pub(crate) fn limit_threads(flags: &DeviceFlags) -> Result<(), Failure> {
    start_threads(flags.threads.map_or(0, usize::from))
}

/// Starts the threads that everything outside a backend runs on; 0 is one for each core. Where nobody does this, the first
/// who needs them does, and can only panic where the system refuses.
pub(crate) fn start_threads(threads: usize) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    pool.map_err(|error| {
        Failure::Failed(format!(
            "cannot start threads: {error}; give --threads 1, or raise the limits of memory and processes (ulimit -v, -u)"
        ))
    })
}
