//! What other ranks than 0 do: render for it.

use super::RankOptions;
use super::processors;
use super::wire::{self, Order, Ready, Unit};
use crate::arguments::BackendChoice;
use crate::backend::{asks_for_cpu, backend_for};
use crate::failure::Failure;
use crate::interrupt;
use crate::streams::Verbosity;
use eosphor::{Backend, PreparedScene, RenderControl, SceneData, cuda_devices};
use eosphor_cluster::{Job, World};
use std::sync::Arc;

/// Works until rank 0's command has ended.
pub(super) fn follow(world: &World, options: &RankOptions) -> Result<(), Failure> {
    interrupt::watch(Verbosity::Quiet)?;
    agree(world)?;
    let mut prepared = None;
    loop {
        let bytes = world.broadcast(Vec::new()).map_err(Failure::because)?;
        match Order::from_bytes(&bytes).map_err(Failure::Failed)? {
            Order::Prepare(scene) => {
                drop(bytes);
                let (ready, scene) = prepare(world, options, Arc::new(*scene));
                prepared = scene;
                let ready = wire::encode(&ready).map_err(Failure::Failed)?;
                world.gather(&ready).map_err(Failure::because)?;
            }
            Order::Work => {
                let Some((scene, ready)) = &prepared else { continue };
                let compute = |_: u64, unit: &[u8]| render(&**scene, unit);
                let job = Job {
                    units: u64::MAX,
                    in_flight: in_flight(ready),
                    coordinator: None,
                    compute: &compute,
                    threads: ready.units,
                    silence: options.silence(),
                };
                world.run(job).map_err(Failure::because)?;
            }
            Order::Wait => {}
            Order::Leave => return Ok(()),
        }
    }
}

/// That all ranks run the same program.
pub(super) fn agree(world: &World) -> Result<(), Failure> {
    let version = format!("{} ({})", env!("CARGO_PKG_VERSION"), std::env::consts::ARCH);
    world.agree("version of eosphor", &version).map_err(Failure::because)
}

/// Units that a rank has: one lies ready.
pub(super) fn in_flight(ready: &Ready) -> u32 {
    ready.units + 1
}

/// What a rank prepares, and says of itself.
type Prepared = (Arc<dyn PreparedScene>, Ready);

/// Gets a scene ready on what this rank has of its host.
pub(super) fn prepare(
    world: &World,
    options: &RankOptions,
    scene: Arc<SceneData>,
) -> (Result<Ready, String>, Option<Prepared>) {
    let prepare = || -> Result<Prepared, String> {
        processors::check_rounding()?;
        let processors = processors::processors();
        let (backend, units) = local_backend(world, options, processors)
            .map_err(|failure| failure.line().unwrap_or_default())?;
        let prepared = backend.prepare(scene).map_err(|error| error.to_string())?;
        let description = backend.describe();
        let is_gpu = description.starts_with("CUDA");
        let units = if is_gpu { 3 } else { units };
        Ok((prepared.into(), Ready { backend: description, is_gpu, units, processors }))
    };
    match prepare() {
        Ok((prepared, ready)) => (Ok(ready.clone()), Some((prepared, ready))),
        Err(reason) => (Err(reason), None),
    }
}

/// The GPU with the rank's number on its host, as far as there are, or its share of the processors; and how many units are
/// to be rendered at the same time, so that threads have something to do at the end of each.
fn local_backend(
    world: &World,
    options: &RankOptions,
    processors: (u32, u32),
) -> Result<(Box<dyn Backend>, u32), Failure> {
    let mut device = options.device.clone();
    let mine =
        |list: &[usize]| list.get(world.local_rank() as usize % list.len().max(1)).map(|&gpu| vec![gpu]);
    let wants_cpu = options.count_work || asks_for_cpu(&device, options.accel);
    device.backend = match &device.backend {
        BackendChoice::Auto if wants_cpu => BackendChoice::Cpu,
        BackendChoice::Auto => mine(&gpus()).map_or(BackendChoice::Cpu, BackendChoice::Cuda),
        // Where there is none, the backend says so.
        BackendChoice::Cuda(list) if list.is_empty() => {
            BackendChoice::Cuda(mine(&gpus()).unwrap_or_default())
        }
        BackendChoice::Cuda(list) => BackendChoice::Cuda(mine(list).unwrap_or_default()),
        BackendChoice::Cpu => BackendChoice::Cpu,
    };
    let threads = match device.threads {
        Some(threads) => threads,
        None => processors::threads(processors, world.local_size()).min(1024) as u16,
    };
    // A flag about threads would rule out GPUs.
    if device.backend == BackendChoice::Cpu {
        device.threads = Some(threads);
    }
    let backend = backend_for(&device, options.accel, options.count_work, options.verbosity)?;
    Ok((backend, if threads > 1 { 2 } else { 1 }))
}

/// The numbers of the devices that kernels run on.
fn gpus() -> Vec<usize> {
    let devices = cuda_devices().unwrap_or_default();
    devices.iter().filter(|device| device.is_supported()).map(|device| device.ordinal).collect()
}

/// Renders a unit.
pub(super) fn render(scene: &dyn PreparedScene, unit: &[u8]) -> Result<Vec<u8>, String> {
    let Unit { rows, count_work, moment } = wire::decode(unit)?;
    let (on_progress, cancel) = (&|_| {}, interrupt::flag());
    let control = RenderControl { on_progress, cancel, count_work, moment: moment.as_ref() };
    let rendered = scene.render_rows(rows, &control).map_err(|error| error.to_string())?;
    wire::encode_result(&rendered)
}
