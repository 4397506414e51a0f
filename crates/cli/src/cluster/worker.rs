//! A worker, which is every rank but 0: renders what rank 0 asks for.

use super::RankOptions;
use super::processors;
use super::wire::{self, Order, Ready, Unit};
use crate::arguments::BackendChoice;
use crate::backend::{asks_for_cpu, backend_with};
use crate::failure::Failure;
use crate::interrupt;
use crate::streams::Verbosity;
use eosphor::{
    Backend, BackendError, PICTURE_VERSION, PreparedScene, RenderControl, SceneData, cuda_devices,
};
use eosphor_cluster::{ClusterError, Coordinator, Job, Report, World};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// Between two looks for signs of life while there is nothing else to do.
pub(super) const LOOK_INTERVAL: Duration = Duration::from_millis(20);

/// Renders for rank 0 until its command has ended.
pub(super) fn run(world: &World, options: &RankOptions) -> Result<(), Failure> {
    interrupt::watch(Verbosity::Quiet)?;
    let sharers = meet(world)?;
    // An error of this rank alone would leave the others waiting.
    serve(world, options, sharers)
        .map_err(|failure| world.abort_handle().now(&failure.line().unwrap_or_default()))
}

fn serve(world: &World, options: &RankOptions, sharers: u32) -> Result<(), Failure> {
    // Devices take a while to open, and so do scenes to load.
    let device = Local::open(world, options, sharers)?;
    let mut next = None;
    loop {
        let bytes = together(world, world.broadcast(Vec::new()))?;
        match meanwhile(world, || Order::from_bytes(&bytes))?.map_err(Failure::Failed)? {
            Order::Prepare(scene) => {
                drop(bytes);
                let ready = device.as_ref().map(|device| device.ready.clone()).map_err(String::clone);
                let ready = wire::encode(&ready).map_err(Failure::Failed)?;
                together(world, world.gather(&ready))?;
                next = Some(Arc::new(*scene));
            }
            Order::Work => {
                let (Some(scene), Ok(device)) = (next.take(), &device) else { continue };
                device.work(world, scene, None, &Prepared::new())?;
            }
            Order::Wait => next = None,
            Order::Leave => return Ok(()),
        }
    }
}

/// Sees to it that all ranks run the same program, and finds out how many of them share this one's processors.
pub(super) fn meet(world: &World) -> Result<u32, Failure> {
    let (number, arch) = (env!("CARGO_PKG_VERSION"), std::env::consts::ARCH);
    let file = std::env::current_exe().and_then(std::fs::metadata);
    // Two builds of one version seldom have one length.
    let bytes = file.map_or(0, |file| file.len());
    let version = format!("{number} ({arch}, pictures {PICTURE_VERSION}, {bytes} bytes)");
    together(world, world.agree("version of eosphor", &version))?;
    let masks = together(world, world.gather(&processors::mask()))?.unwrap_or_default();
    let masks = together(world, world.broadcast(masks.concat()))?;
    Ok(processors::sharers(world.rank() as usize, world.hosts(), masks.as_chunks().0))
}

/// What all ranks are told is an error that rank 0 reports. What fails on one alone would leave the others waiting, so it ends
/// the job.
pub(super) fn together<T>(world: &World, result: Result<T, ClusterError>) -> Result<T, Failure> {
    match result {
        Ok(value) => Ok(value),
        Err(error @ (ClusterError::Disagreement { .. } | ClusterError::Broadcast { .. })) => {
            Err(Failure::because(error))
        }
        Err(error) => world.abort_handle().now(&error.to_string()),
    }
}

/// Does something that takes long, on a thread of its own, so that the thread with MPI gives signs of life.
pub(super) fn meanwhile<T: Send>(world: &World, function: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    std::thread::scope(|scope| {
        let (result, receiver) = channel();
        // The receiver waits for it.
        scope.spawn(move || result.send(function()).is_ok());
        loop {
            match receiver.recv_timeout(LOOK_INTERVAL) {
                Ok(result) => return Ok(result),
                // A panic, which ends all ranks.
                Err(RecvTimeoutError::Disconnected) => std::thread::park(),
                Err(RecvTimeoutError::Timeout) => together(world, world.attend())?,
            }
        }
    })
}

/// What a rank renders on.
pub(super) struct Local {
    backend: Box<dyn Backend>,
    pub(super) ready: Ready,
}

/// A scene that is being prepared, and the reason where it cannot be.
pub(super) type Prepared = OnceLock<Result<Box<dyn PreparedScene>, String>>;

impl Local {
    /// The inner error is that there is none, which all ranks hear of.
    pub(super) fn open(
        world: &World,
        options: &RankOptions,
        sharers: u32,
    ) -> Result<Result<Local, String>, Failure> {
        let local_rank = world.local_rank();
        meanwhile(world, || Local::open_here(local_rank, options, sharers))
    }

    fn open_here(local_rank: u32, options: &RankOptions, sharers: u32) -> Result<Local, String> {
        processors::check_rounding()?;
        let processors = processors::processors();
        let (backend, units) = local_backend(local_rank, options, processors.0 / sharers)
            .map_err(|failure| failure.line().unwrap_or_default())?;
        let description = backend.describe();
        let is_gpu = description.starts_with("CUDA");
        // While one is copied back another is rendered.
        let units = if is_gpu { 3 } else { units };
        Ok(Local { backend, ready: Ready { backend: description, is_gpu, units, processors } })
    }

    /// Renders units until rank 0 has no more. The scene is prepared meanwhile, so that the thread with MPI gives signs of
    /// life.
    pub(super) fn work(
        &self,
        world: &World,
        scene: Arc<SceneData>,
        coordinator: Option<Coordinator>,
        prepared: &Prepared,
    ) -> Result<Report, Failure> {
        let compute = |_: u64, unit: &[u8]| match prepared.wait() {
            Ok(scene) => render(&**scene, unit),
            Err(reason) => Err(reason.clone()),
        };
        let job = Job {
            units: u64::MAX,
            // One lies ready.
            in_flight: self.ready.units + 1,
            coordinator,
            compute: &compute,
            threads: self.ready.units,
        };
        std::thread::scope(|scope| {
            scope.spawn(move || {
                let scene = self.backend.prepare(scene).map_err(|error| error.to_string());
                // Nobody else sets it.
                let _ = prepared.set(scene);
            });
            let report = together(world, world.run(job))?;
            // Others may be ready to go on long before this one.
            while prepared.get().is_none() {
                together(world, world.attend())?;
                std::thread::sleep(LOOK_INTERVAL);
            }
            Ok(report)
        })
    }
}

/// The GPU with the rank's number on its host, as far as there are, or its share of the processors; and how many units are
/// to be rendered at the same time, so that threads have something to do at the end of each.
fn local_backend(
    local_rank: u32,
    options: &RankOptions,
    processors: u32,
) -> Result<(Box<dyn Backend>, u32), Failure> {
    let mut device = options.device.clone();
    let mine = |list: &[usize]| list.get(local_rank as usize % list.len().max(1)).map(|&gpu| vec![gpu]);
    let auto = if asks_for_cpu(&device, options.accel) { None } else { mine(&gpus()) };
    device.backend = Some(match device.backend() {
        BackendChoice::Auto if auto.is_none() => BackendChoice::Cpu,
        BackendChoice::Auto => BackendChoice::Auto,
        // Where there is none, the backend says so.
        BackendChoice::Cuda(list) if list.is_empty() => {
            BackendChoice::Cuda(mine(&gpus()).unwrap_or_default())
        }
        BackendChoice::Cuda(list) => BackendChoice::Cuda(mine(list).unwrap_or_default()),
        BackendChoice::Cpu => BackendChoice::Cpu,
    });
    let threads = match device.threads {
        Some(threads) => threads,
        None => processors.clamp(1, 1024) as u16,
    };
    // A flag about threads would rule out GPUs.
    if *device.backend() == BackendChoice::Cpu {
        device.threads = Some(threads);
    }
    let gpu = || auto.and_then(|gpus| gpus.first().copied());
    let backend = backend_with(&device, options.accel, options.count_work, options.verbosity, gpu)?;
    Ok((backend, if threads > 1 { 2 } else { 1 }))
}

/// The numbers of the devices that kernels run on.
fn gpus() -> Vec<usize> {
    let devices = cuda_devices().unwrap_or_default();
    devices.iter().filter(|device| device.is_supported()).map(|device| device.ordinal).collect()
}

/// Renders a unit.
pub(super) fn render(scene: &dyn PreparedScene, unit: &[u8]) -> Result<Vec<u8>, String> {
    let Unit { rows, samples, count_work, frame: state } = wire::decode(unit)?;
    let (on_progress, cancel) = (&|_| {}, interrupt::cancel().overdue());
    let control = RenderControl { on_progress, cancel, count_work, frame: state.as_ref() };
    let fail = |error: BackendError| error.to_string();
    match samples {
        None => wire::encode_film(&scene.render_rows(rows, &control).map_err(fail)?),
        Some(samples) => wire::encode_sums(&scene.sample_rows(rows, samples, &control).map_err(fail)?),
    }
}
