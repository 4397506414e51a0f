//! Which device renders.

use crate::arguments::{BackendChoice, DeviceFlags, Need, check, would_do_nothing};
use crate::failure::Failure;
use crate::streams::Verbosity;
use eosphor::{
    Accel, Backend, BackendError, CpuBackend, CpuOptions, CudaBackend, CudaOptions, GpuScheduler,
    HierarchyOption, HierarchyOptions, MisfitKind, OptionMisfit, Traversal, first_gpu, gpu_or_cpu,
};
use std::ops::Deref;

/// All ranks, where there are several, or what the flags ask for on this machine.
pub(crate) fn ranks_or_own<'a>(
    ranks: Option<&'a dyn Backend>,
    flags: &DeviceFlags,
    accel: Option<Accel>,
    count_work: bool,
    verbosity: Verbosity,
) -> Result<AnyBackend<'a>, Failure> {
    match ranks {
        Some(ranks) => Ok(AnyBackend::Lent(ranks)),
        None => {
            limit_threads(flags)?;
            Ok(AnyBackend::Own(backend_for(flags, accel, count_work, verbosity)?))
        }
    }
}

/// A backend of one's own, or one that is lent.
pub(crate) enum AnyBackend<'a> {
    Own(Box<dyn Backend>),
    Lent(&'a dyn Backend),
}

impl<'a> Deref for AnyBackend<'a> {
    type Target = dyn Backend + 'a;
    fn deref(&self) -> &(dyn Backend + 'a) {
        match self {
            AnyBackend::Own(backend) => &**backend,
            AnyBackend::Lent(backend) => *backend,
        }
    }
}

/// The backend that the flags ask for. `auto` is the first GPU, with the CPU in reserve, unless there is none or something is
/// asked for that only the CPU does.
pub(crate) fn backend_for(
    flags: &DeviceFlags,
    accel: Option<Accel>,
    count_work: bool,
    verbosity: Verbosity,
) -> Result<Box<dyn Backend>, Failure> {
    backend_with(flags, accel, count_work, verbosity, first_gpu)
}

/// Opens the backend that the flags ask for; `auto` is the GPU that `gpu` names.
pub(crate) fn backend_with(
    flags: &DeviceFlags,
    accel: Option<Accel>,
    count_work: bool,
    verbosity: Verbosity,
    gpu: impl FnOnce() -> Option<usize>,
) -> Result<Box<dyn Backend>, Failure> {
    check_device(flags, accel)?;
    match flags.backend() {
        BackendChoice::Cpu => Ok(Box::new(cpu_backend(flags, accel)?)),
        BackendChoice::Cuda(devices) => {
            let devices = if devices.is_empty() { vec![0] } else { devices.clone() };
            Ok(Box::new(CudaBackend::new(cuda_options(flags, accel, count_work, devices))?))
        }
        BackendChoice::Auto => {
            let tell = move |error: &BackendError| {
                verbosity.say(Verbosity::Normal, &format!("eosphor: note: {error}; the CPU goes on"));
            };
            let device = if asks_for_cpu(flags, accel) { None } else { gpu() };
            let cuda = device.map(|device| cuda_options(flags, accel, count_work, vec![device]));
            Ok(gpu_or_cpu(cuda, cpu_options(flags, accel), tell)?)
        }
    }
}

/// Fails where flags about the device ask for what there is not, or would do nothing.
pub(crate) fn check_device(flags: &DeviceFlags, accel: Option<Accel>) -> Result<(), Failure> {
    let is_cpu = match flags.backend() {
        BackendChoice::Auto => asks_for_cpu(flags, accel),
        choice => *choice == BackendChoice::Cpu,
    };
    let is_cuda = matches!(flags.backend(), BackendChoice::Cuda(_));
    let about_gpus = flags.block_size.is_some()
        || flags.gpu_paths.is_some()
        || flags.gpu_memory.is_some()
        || flags.gpu_scheduler != GpuScheduler::default()
        || flags.gpu_traversal != Traversal::default();
    let gpu = |flag, is_given| Need {
        flag,
        is_given,
        is_met: !is_cpu,
        needs: "a GPU, not --backend cpu or what is about the CPU (--threads, --tile, --simd, --accel bvh8)",
    };
    let cpu = |flag, is_given| Need {
        flag,
        is_given,
        is_met: !is_cuda,
        needs: "the CPU to render (--backend cpu)",
    };
    hierarchy_options(flags).check(accel).map_err(misfit)?;
    check(&[
        gpu("--block-size", flags.block_size.is_some()),
        gpu("--gpu-paths", flags.gpu_paths.is_some()),
        gpu("--gpu-memory", flags.gpu_memory.is_some()),
        gpu("--gpu-scheduler", flags.gpu_scheduler != GpuScheduler::default()),
        gpu("--gpu-traversal", flags.gpu_traversal != Traversal::default()),
        cpu("--tile", flags.tile.is_some()),
        cpu("--simd", flags.simd.0.is_some()),
        cpu("--scheduler", flags.scheduler.is_some()),
    ])?;
    // Where the choice is the program's, what a GPU would take is said even where there is none.
    if is_cuda || about_gpus {
        cuda_options(flags, accel, false, vec![0]).check().map_err(Failure::usage)?;
    }
    Ok(())
}

/// What is wrong with an option of hierarchies, and its flag.
fn misfit(OptionMisfit { option, kind }: OptionMisfit) -> Failure {
    let flag = match option {
        HierarchyOption::Builder => "--builder",
        HierarchyOption::LeafSize => "--leaf-size",
        HierarchyOption::TreeDepth => "--tree-depth",
        HierarchyOption::SahCosts => "--sah-costs",
    };
    match kind {
        MisfitKind::Structure(names) => would_do_nothing(flag, &format!("--accel {names}")),
        MisfitKind::Range(range) => Failure::Usage(format!("{flag}: it must be {range}")),
    }
}

/// Fails where an option is out of the range of a structure that has it.
pub(crate) fn check_ranges(flags: &DeviceFlags) -> Result<(), Failure> {
    let HierarchyOptions { leaf_size, tree_depth, sah_costs, .. } = hierarchy_options(flags);
    // One by one, as one that a structure does not have hides the others.
    let each = [
        HierarchyOptions { leaf_size, ..HierarchyOptions::default() },
        HierarchyOptions { tree_depth, ..HierarchyOptions::default() },
        HierarchyOptions { sah_costs, ..HierarchyOptions::default() },
    ];
    for (accel, option) in Accel::ALL.iter().flat_map(|&accel| each.map(|option| (accel, option))) {
        match option.check(Some(accel)) {
            Err(wrong) if matches!(wrong.kind, MisfitKind::Range(_)) => return Err(misfit(wrong)),
            _ => {}
        }
    }
    Ok(())
}

/// Whether flags are about the CPU, or a structure that is made for it.
pub(crate) fn asks_for_cpu(flags: &DeviceFlags, accel: Option<Accel>) -> bool {
    let about_cpus = flags.threads.is_some() || flags.tile.is_some() || flags.simd.0.is_some();
    about_cpus || flags.scheduler.is_some() || accel == Some(Accel::Bvh8)
}

fn cuda_options(
    flags: &DeviceFlags,
    accel: Option<Accel>,
    count_work: bool,
    devices: Vec<usize>,
) -> CudaOptions {
    let defaults = CudaOptions::default();
    CudaOptions {
        devices,
        accel: accel.unwrap_or(defaults.accel),
        hierarchy: hierarchy_options(flags),
        block_size: flags.block_size.unwrap_or(defaults.block_size),
        traversal: flags.gpu_traversal,
        scheduler: flags.gpu_scheduler,
        paths: flags.gpu_paths,
        memory_bytes: flags.gpu_memory,
        count_work,
    }
}

/// The CPU, whatever else renders.
pub(crate) fn cpu_backend(flags: &DeviceFlags, accel: Option<Accel>) -> Result<CpuBackend, Failure> {
    Ok(CpuBackend::new(cpu_options(flags, accel))?)
}

/// How hierarchies are built.
pub(crate) fn hierarchy_options(flags: &DeviceFlags) -> HierarchyOptions {
    let &DeviceFlags { builder, leaf_size, tree_depth, sah_costs, .. } = flags;
    HierarchyOptions { builder, leaf_size, tree_depth, sah_costs }
}

/// How the CPU renders, or makes layers for whatever else renders.
pub(crate) fn cpu_options(flags: &DeviceFlags, accel: Option<Accel>) -> CpuOptions {
    CpuOptions {
        threads: flags.threads.map(usize::from),
        tile: flags.tile,
        accel: accel.unwrap_or(CpuOptions::default().accel),
        hierarchy: hierarchy_options(flags),
        simd: flags.simd.0,
        scheduler: flags.scheduler.unwrap_or(CpuOptions::default().scheduler),
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
