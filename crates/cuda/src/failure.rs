//! The driver's errors, in a sentence.

use cudarc::driver::DriverError;
use cudarc::driver::sys::CUresult;
use eosphor_render::BackendError;

/// What went wrong on a device, while doing what.
pub(crate) fn failure(device: &str, doing: &str, error: DriverError) -> BackendError {
    match error.0 {
        CUresult::CUDA_ERROR_OUT_OF_MEMORY => BackendError::OutOfMemory(format!(
            "{doing}: the memory of {device} is too small or taken: render on the CPU, which gives the same picture"
        )),
        _ => BackendError::Failed(format!("{doing} on {device}: {}", reason(error))),
    }
}

/// The driver's own words.
pub(crate) fn reason(error: DriverError) -> String {
    match error.error_string() {
        Ok(text) => text.to_string_lossy().into_owned(),
        Err(_) => format!("{:?}", error.0),
    }
}
