//! Renders scenes on CPU and GPU and says whether the films are identical, and how long they took.
//!
//! `gpu_check [--preset eos|pg1|none] [--size WxH] [--samples N] [--accel bvh|none] SCENE...`: options hold for the
//! scenes after them. `glass` and `surfaces` are the test suite's own scenes. Exit code 1 where any film differs. This is the
//! check that `gpu/stage-device-run` takes to a machine without cargo.

#[path = "../tests/common/mod.rs"]
mod common;

use eosphor_cuda::{CudaBackend, CudaOptions, devices};
use eosphor_render::{Accel, Backend, CpuBackend, CpuOptions};
use eosphor_scene::{Preset, SceneData};
use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

/// What holds for the scenes that follow.
#[derive(Clone, Copy, Default)]
struct Overrides {
    preset: Option<Preset>,
    size: Option<[u32; 2]>,
    samples: Option<u32>,
}

fn main() -> ExitCode {
    match check_all() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("gpu_check: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Whether the films of all scenes are identical.
fn check_all() -> Result<bool, Box<dyn Error>> {
    for device in devices()? {
        println!("{device}");
    }
    let start = Instant::now();
    let mut gpu = CudaBackend::new(CudaOptions::default())?;
    println!("kernels loaded in {:.3} s", start.elapsed().as_secs_f64());
    let cpu = CpuBackend::new(CpuOptions::default())?;
    println!("{}; {}", cpu.describe(), gpu.describe());

    let mut overrides = Overrides::default();
    let mut all_identical = true;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        match argument.as_str() {
            "--preset" => {
                overrides.preset = Some(value()?).filter(|v| v != "none").map(|v| v.parse()).transpose()?
            }
            "--size" => overrides.size = Some(size(&value()?)?),
            "--samples" => overrides.samples = Some(value()?.parse()?),
            "--accel" => {
                gpu = CudaBackend::new(CudaOptions {
                    accel: value()?.parse::<Accel>()?,
                    ..CudaOptions::default()
                })?;
            }
            name => all_identical &= check(name, overrides, &cpu, &gpu)?,
        }
    }
    Ok(all_identical)
}

fn size(text: &str) -> Result<[u32; 2], Box<dyn Error>> {
    let (width, height) = text.split_once('x').ok_or("a size is WxH")?;
    Ok([width.parse()?, height.parse()?])
}

/// Renders one scene on both and prints a line; whether the films are identical.
fn check(name: &str, o: Overrides, cpu: &dyn Backend, gpu: &dyn Backend) -> Result<bool, Box<dyn Error>> {
    let mut scene = common::scene(name, o.preset)?;
    scene.settings.size = o.size.unwrap_or(scene.settings.size);
    scene.settings.samples = o.samples.unwrap_or(scene.settings.samples);
    let data = Arc::new(SceneData::flatten(&scene)?.0);
    let (on_gpu, gpu_seconds) = common::render(gpu, &data)?;
    let (on_cpu, cpu_seconds) = common::render(cpu, &data)?;
    let difference = common::difference(&on_cpu.film, &on_gpu.film);
    let [width, height] = scene.settings.size;
    println!(
        "{name}{}: {width}x{height}, {} rays: {}{}; CPU {:.3} s + build {:.3}, GPU {:.3} s + build and copy {:.3}",
        o.preset.map_or(String::new(), |p| format!(" ({})", p.name())),
        on_cpu.statistics.total_rays(),
        difference.as_deref().unwrap_or("IDENTICAL"),
        if on_cpu.statistics == on_gpu.statistics { "" } else { ", RAY COUNTS DIFFER" },
        cpu_seconds[1],
        cpu_seconds[0],
        gpu_seconds[1],
        gpu_seconds[0],
    );
    Ok(difference.is_none() && on_cpu.statistics == on_gpu.statistics)
}
