//! The GPU of tests: what to do where there is none, and pictures beside those of the CPU.

use crate::common::{difference, render};
use eosphor_cuda::{CudaBackend, CudaOptions};
use eosphor_render::{CpuBackend, CpuOptions};
use eosphor_scene::{Scene, SceneData};
use std::fmt::Display;
use std::io::Write;
use std::sync::Arc;

/// Renders on the CPU and, in this way, on the GPU, and compares films and ray counts.
pub(crate) fn assert_identical_by(scene: &Scene, options: CudaOptions) {
    let data = Arc::new(SceneData::flatten(scene).unwrap().0);
    let way = format!("{options:?}");
    let Some(gpu) = backend(options) else { return };
    let cpu = CpuBackend::new(CpuOptions::default()).unwrap();
    let (on_gpu, _) = render(&gpu, &data).unwrap();
    let (on_cpu, _) = render(&cpu, &data).unwrap();
    if let Some(text) = difference(&on_cpu.film, &on_gpu.film) {
        panic!("CPU and GPU, {way}: {text}");
    }
    assert_eq!(on_cpu.statistics, on_gpu.statistics, "{way}");
}

/// The GPU; says so where there is none.
pub(crate) fn backend(options: CudaOptions) -> Option<CudaBackend> {
    match CudaBackend::new(options) {
        Ok(gpu) => Some(gpu),
        Err(error) if std::env::var_os("REQUIRE_GPU").is_some_and(|v| v == "1") => panic!("{error}"),
        Err(error) => {
            skip(&error);
            None
        }
    }
}

/// Says so even where the test harness keeps what passing tests print to itself.
pub(crate) fn skip(reason: &dyn Display) {
    let test = std::thread::current().name().unwrap_or_default().to_string();
    std::io::stderr().write_all(format!("SKIPPED {test}: {reason}\n").as_bytes()).unwrap();
}
