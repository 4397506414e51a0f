//! The device that renders, where nobody names one.

use eosphor_cuda::{CudaBackend, CudaOptions, devices};
use eosphor_render::{Backend, BackendError, CpuBackend, CpuOptions, Fallback};

/// The number of the first GPU that kernels run on. `None` where there is none, or no driver.
pub fn first_gpu() -> Option<usize> {
    let devices = devices().ok()?;
    devices.iter().find(|device| device.is_supported()).map(|device| device.ordinal)
}

/// A GPU with the CPU in reserve, or the CPU alone where no GPU is named ([`first_gpu`]). Where the GPU cannot be opened, the scene
/// does not fit, or the device is lost in the middle of a picture, the CPU goes on, and `on_fallback` is told why. The picture is
/// the same.
///
/// # Errors
///
/// Where the CPU's options are out of range, or its threads cannot be started.
pub fn gpu_or_cpu(
    gpu: Option<CudaOptions>,
    cpu: CpuOptions,
    on_fallback: impl Fn(&BackendError) + Send + Sync + 'static,
) -> Result<Box<dyn Backend>, BackendError> {
    let gpu = gpu.and_then(|options| CudaBackend::new(options).map_err(|error| on_fallback(&error)).ok());
    let Some(gpu) = gpu else { return Ok(Box::new(CpuBackend::new(cpu)?)) };
    let reserve = move || Ok(Box::new(CpuBackend::new(cpu)?) as Box<dyn Backend>);
    Ok(Box::new(Fallback::new(Box::new(gpu), reserve, on_fallback)))
}
