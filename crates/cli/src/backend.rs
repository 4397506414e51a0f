//! Which device renders.

use crate::arguments::{BackendChoice, DeviceFlags};
use crate::failure::Failure;
use eosphor::{Backend, CpuBackend, CpuOptions, CudaBackend, CudaOptions, FeaturePass, Hierarchy, SceneData};
use std::sync::Arc;

/// The backend that the flags ask for. `auto` is the CPU while the GPU kernels are not tuned.
pub(crate) fn backend_for(flags: &DeviceFlags) -> Result<Box<dyn Backend>, Failure> {
    match &flags.backend {
        BackendChoice::Auto | BackendChoice::Cpu => Ok(Box::new(CpuBackend::new(cpu_options(flags))?)),
        BackendChoice::Cuda(devices) => {
            let options = CudaOptions { devices: devices.clone(), accel: flags.accel };
            Ok(Box::new(CudaBackend::new(options)?))
        }
    }
}

/// What layers are made by. It is the CPU for every backend; where the picture is rendered there too, they share the
/// hierarchy.
pub(crate) fn feature_pass(
    flags: &DeviceFlags,
    scene: Arc<SceneData>,
    hierarchy: Option<Arc<Hierarchy>>,
) -> Result<FeaturePass, Failure> {
    Ok(CpuBackend::new(cpu_options(flags))?.feature_pass(scene, hierarchy)?)
}

fn cpu_options(flags: &DeviceFlags) -> CpuOptions {
    CpuOptions {
        threads: flags.threads.map(usize::from),
        tile: flags.tile.unwrap_or(CpuOptions::default().tile),
        accel: flags.accel,
        simd: flags.simd.0,
    }
}

/// Gives the thread pool that everything but tracing uses (developing, writing) the same number of threads.
pub(crate) fn limit_threads(flags: &DeviceFlags) -> Result<(), Failure> {
    let Some(threads) = flags.threads else { return Ok(()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
    pool.map_err(|error| Failure::Failed(format!("cannot start the threads: --threads {threads}: {error}")))
}
