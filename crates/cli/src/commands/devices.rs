//! `eosphor devices`.

use crate::arguments::DevicesFlags;
use crate::failure::Failure;
use crate::streams;
use eosphor::SimdLevel;
use serde::Serialize;
use std::fs;
use std::thread::available_parallelism;

#[derive(Serialize)]
struct Devices {
    cpu: Cpu,
    cuda: Cuda,
}

#[derive(Serialize)]
struct Cpu {
    model: String,
    threads: usize,
    /// Values of `--simd` that this CPU can run.
    simd: Vec<SimdLevel>,
}

#[derive(Serialize)]
struct Cuda {
    available: bool,
    note: &'static str,
}

pub(crate) fn devices(flags: &DevicesFlags) -> Result<(), Failure> {
    let devices = Devices {
        cpu: Cpu {
            model: cpu_model(),
            threads: available_parallelism().map_or(1, |threads| threads.get()),
            simd: SimdLevel::available().collect(),
        },
        cuda: Cuda {
            available: false,
            note: "not in this version (it will be looked for through the NVIDIA driver alone: libcuda.so.1)",
        },
    };
    if flags.json {
        return streams::json(&devices);
    }
    let Devices { cpu, cuda } = devices;
    let simd = cpu.simd.iter().map(SimdLevel::to_string).collect::<Vec<_>>().join(", ");
    streams::result(&format!(
        "cpu   {}: {} threads, instructions {simd}\ncuda  {}\n",
        cpu.model, cpu.threads, cuda.note
    ))
}

fn cpu_model() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name"));
    let name = line.and_then(|line| line.split_once(':')).map(|(_, name)| name.trim().to_owned());
    name.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}
