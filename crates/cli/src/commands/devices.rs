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
    devices: Vec<CudaDevice>,
    /// Why there is none.
    note: Option<String>,
}

#[derive(Serialize)]
struct CudaDevice {
    /// For `--backend cuda:N`.
    number: usize,
    name: String,
    memory_bytes: u64,
    compute_capability: (i32, i32),
    supported: bool,
}

impl Cuda {
    fn look() -> Cuda {
        match eosphor::cuda_devices() {
            Err(error) => Cuda { devices: Vec::new(), note: Some(error.to_string()) },
            Ok(found) => {
                let device = |info: eosphor::DeviceInfo| CudaDevice {
                    number: info.ordinal,
                    supported: info.is_supported(),
                    name: info.name,
                    memory_bytes: info.memory_bytes,
                    compute_capability: info.compute_capability,
                };
                Cuda { devices: found.into_iter().map(device).collect(), note: None }
            }
        }
    }
}

pub(crate) fn devices(flags: &DevicesFlags) -> Result<(), Failure> {
    let devices = Devices {
        cpu: Cpu {
            model: cpu_model(),
            threads: available_parallelism().map_or(1, |threads| threads.get()),
            simd: SimdLevel::available().collect(),
        },
        cuda: Cuda::look(),
    };
    if flags.json {
        return streams::json(&devices);
    }
    let Devices { cpu, cuda } = devices;
    let simd = cpu.simd.iter().map(SimdLevel::to_string).collect::<Vec<_>>().join(", ");
    let mut text = format!("cpu     {}: {} threads, instructions {simd}\n", cpu.model, cpu.threads);
    for device in &cuda.devices {
        let gib = device.memory_bytes as f64 / (1u64 << 30) as f64;
        let (major, minor) = device.compute_capability;
        let fit = if device.supported { "" } else { " (too old)" };
        text += &format!(
            "cuda:{}  {}: {gib:.1} GiB, compute capability {major}.{minor}{fit}\n",
            device.number, device.name
        );
    }
    if let Some(note) = &cuda.note {
        text += &format!("cuda    {note}\n");
    }
    streams::result(&text)
}

fn cpu_model() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name"));
    let name = line.and_then(|line| line.split_once(':')).map(|(_, name)| name.trim().to_owned());
    name.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}
