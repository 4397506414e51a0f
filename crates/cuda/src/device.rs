//! Devices: which there are, and kernels on one of them.

use crate::compilation;
use crate::failure::{failure, reason};
use crate::memory;
use crate::ptx;
use cudarc::driver::result::{self, DriverError};
use cudarc::driver::sys::{self, CUdevice_attribute_enum as Attribute, CUfunction_attribute};
use cudarc::driver::{CudaContext, CudaFunction, CudaStream, DevicePtrMut};
use cudarc::nvrtc::Ptx;
use eosphor_core::bsdf::large_tables;
use eosphor_render::BackendError;
use std::cmp::Reverse;
use std::collections::{HashMap, HashSet};
use std::ffi::CString;
use std::fmt;
use std::ptr::null_mut;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A device that NVIDIA's driver offers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Its number, from 0.
    pub ordinal: usize,
    /// Its name.
    pub name: String,
    /// Its memory.
    pub memory_bytes: u64,
    /// Its generation, major and minor.
    pub compute_capability: (i32, i32),
}

impl DeviceInfo {
    /// Whether the kernels run on it: they do from Turing (2018) on.
    pub fn is_supported(&self) -> bool {
        self.compute_capability >= ptx::OLDEST_CAPABILITY
    }
}

impl fmt::Display for DeviceInfo {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (major, minor) = self.compute_capability;
        let gib = self.memory_bytes as f64 / (1u64 << 30) as f64;
        write!(f, "cuda:{} {}, {gib:.1} GiB, compute capability {major}.{minor}", self.ordinal, self.name)
    }
}

/// All devices, in the driver's order, supported or not.
///
/// # Errors
///
/// [`BackendError::Unavailable`] with the reason where there is no driver or no device.
pub fn devices() -> Result<Vec<DeviceInfo>, BackendError> {
    // SAFETY: this opens the driver's library, whose start-up code we have to trust like any library's.
    if !unsafe { sys::is_culib_present() } {
        return Err(BackendError::Unavailable(
            "no CUDA: the library of NVIDIA's driver (libcuda) is not on this machine: install the driver, or render \
             on the CPU"
                .into(),
        ));
    }
    let unavailable =
        |error| BackendError::Unavailable(format!("no CUDA: the driver says: {}", reason(error)));
    result::init().map_err(unavailable)?;
    let count = result::device::get_count().map_err(unavailable)?;
    if count == 0 {
        return Err(BackendError::Unavailable("no CUDA: the driver finds no device".into()));
    }
    (0..count).map(|ordinal| info(ordinal).map_err(unavailable)).collect()
}

fn info(ordinal: i32) -> Result<DeviceInfo, DriverError> {
    let device = result::device::get(ordinal)?;
    // SAFETY: the driver has just given this device's handle.
    let attribute = |which| unsafe { result::device::get_attribute(device, which) };
    Ok(DeviceInfo {
        ordinal: ordinal as usize,
        name: result::device::get_name(device)?,
        // SAFETY: the driver has just given this device's handle.
        memory_bytes: unsafe { result::device::total_mem(device) }? as u64,
        compute_capability: (
            attribute(Attribute::CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR)?,
            attribute(Attribute::CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR)?,
        ),
    })
}

/// Free memory for each context in which a text is compiled, by a guess.
const CONTEXT_BYTES: usize = 1 << 30;

/// Kernels that the driver gets together.
struct Text {
    kernels: Vec<&'static str>,
    code: String,
}

/// Compiles a text for the driver's cache, in a context of its own, and forgets it. Where that fails, for want of memory for
/// instance, it is compiled where it is loaded, which tells what is wrong.
fn compile_elsewhere(device: sys::CUdevice, code: &str) {
    let Ok(code) = CString::new(code) else { return };
    let (mut context, mut module) = (null_mut(), null_mut());
    // SAFETY: the device is one that the driver has named; the text ends with a 0; the context is this thread's alone, and gone
    // with all that is in it before the thread goes on.
    unsafe {
        if sys::cuCtxCreate_v2(&mut context, 0, device).result().is_err() {
            return;
        }
        let loaded = sys::cuModuleLoadData(&mut module, code.as_ptr().cast());
        if loaded.result().is_ok() {
            let _ = sys::cuModuleUnload(module);
        }
        let _ = sys::cuCtxDestroy_v2(context);
    }
}

/// A kernel that is loaded.
#[derive(Clone)]
pub(crate) struct Kernel {
    pub(crate) name: &'static str,
    pub(crate) function: CudaFunction,
}

/// A device that is open.
pub(crate) struct Device {
    /// For messages.
    pub(crate) name: String,
    pub(crate) stream: Arc<CudaStream>,
    /// The most memory that is said to be free.
    memory_limit: u64,
    /// Kernels that were loaded.
    kernels: Mutex<HashMap<&'static str, CudaFunction>>,
}

impl Device {
    /// Opens a device, of whose memory no more than this is to be taken.
    pub(crate) fn open(info: &DeviceInfo, memory_limit: Option<u64>) -> Result<Device, BackendError> {
        if !info.is_supported() {
            let (major, minor) = ptx::OLDEST_CAPABILITY;
            return Err(BackendError::Unavailable(format!(
                "{info}: too old: at least compute capability {major}.{minor} (Turing) is needed"
            )));
        }
        let name = format!("cuda:{} ({})", info.ordinal, info.name);
        let context = CudaContext::new(info.ordinal).map_err(|error| failure(&name, "starting", error))?;
        Ok(Device {
            stream: context.default_stream(),
            memory_limit: memory_limit.unwrap_or(u64::MAX),
            kernels: Mutex::default(),
            name,
        })
    }

    /// A kernel for blocks of up to so many threads, always as many on this device.
    pub(crate) fn kernel(&self, name: &'static str, threads: u32) -> Result<Kernel, BackendError> {
        self.load(&[&[name]], threads)?;
        Ok(Kernel { name, function: self.known()[name].clone() })
    }

    /// Several that are loaded, or one by one.
    pub(crate) fn kernels<const N: usize>(
        &self,
        names: [&'static str; N],
        threads: u32,
    ) -> Result<[Kernel; N], BackendError> {
        let kernels = names.iter().map(|name| self.kernel(name, threads)).collect::<Result<Vec<_>, _>>()?;
        Ok(kernels.try_into().unwrap_or_else(|_| unreachable!("as many as names")))
    }

    fn known(&self) -> MutexGuard<'_, HashMap<&'static str, CudaFunction>> {
        self.kernels.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Loads kernels for blocks of up to so many threads, always as many on this device. The driver compiles them, the first time
    /// on a machine in seconds: those of a group together, groups side by side.
    pub(crate) fn load(&self, groups: &[&[&'static str]], threads: u32) -> Result<(), BackendError> {
        let missing = |group: &&[&'static str]| {
            let known = self.known();
            let names: Vec<&'static str> =
                group.iter().copied().filter(|name| !known.contains_key(name)).collect();
            (!names.is_empty()).then(|| Text { code: ptx::text(&names, threads), kernels: names })
        };
        let mut texts: Vec<Text> = groups.iter().filter_map(missing).collect();
        let mut names = HashSet::new();
        texts.retain(|text| text.kernels.iter().all(|&name| names.insert(name)));
        // The longest takes longest.
        texts.sort_by_key(|text| Reverse(text.code.len()));
        let device = self.stream.context().cu_device();
        // Without the driver's cache, what is compiled elsewhere is lost.
        let has_cache = std::env::var_os("CUDA_CACHE_DISABLE").is_none_or(|disabled| disabled == "0");
        let compile = |number: usize| compile_elsewhere(device, &texts[number].code);
        let fail = |error| self.failure("loading the kernels", error);
        let (free, _) = self.stream.context().mem_get_info().map_err(fail)?;
        let at_once = if has_cache { free / CONTEXT_BYTES } else { 0 };
        let load = |number: usize| self.load_text(&texts[number]);
        compilation::load_all(texts.len(), at_once, compile, load).map_err(fail)
    }

    fn load_text(&self, Text { kernels, code }: &Text) -> Result<(), DriverError> {
        let tables = large_tables().into_iter().filter(|(table, _)| code.contains(table));
        let module = self.stream.context().load_module(Ptx::from_src(code))?;
        for (table, items) in tables {
            let mut place = module.get_global(table, &self.stream)?;
            assert_eq!(place.len(), size_of_val(items), "{table} has its size");
            let address = place.device_ptr_mut(&self.stream).0;
            // SAFETY: the table is there and as long; no kernel of the module runs yet.
            unsafe { memory::write(&self.stream, address, 0, items) }?;
        }
        for name in kernels {
            let kernel = module.load_function(name)?;
            self.known().insert(name, kernel);
        }
        Ok(())
    }

    /// Whether a scene may take less than what is free.
    pub(crate) fn has_memory_limit(&self) -> bool {
        self.memory_limit < u64::MAX
    }

    /// Memory that a scene may take.
    pub(crate) fn free_bytes(&self) -> Result<u64, DriverError> {
        self.stream.context().mem_get_info().map(|(free, _)| self.memory_limit.min(free as u64))
    }

    /// Blocks of this kernel that run at a time.
    pub(crate) fn blocks_at_a_time(&self, kernel: &Kernel, threads: u32) -> Result<u32, DriverError> {
        let processors =
            self.stream.context().attribute(Attribute::CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT)?;
        Ok(processors as u32
            * kernel.function.occupancy_max_active_blocks_per_multiprocessor(threads, 0, None)?)
    }

    /// What the driver sets aside for the stacks of threads when a kernel is launched: for as many as can run at a time.
    pub(crate) fn stack_bytes(&self, kernel: &Kernel) -> Result<u64, DriverError> {
        let stack =
            kernel.function.get_attribute(CUfunction_attribute::CU_FUNC_ATTRIBUTE_LOCAL_SIZE_BYTES)?;
        Ok(self.threads_at_a_time()? * stack as u64)
    }

    /// The most threads that can run at a time.
    pub(crate) fn threads_at_a_time(&self) -> Result<u64, DriverError> {
        let attribute = |which| self.stream.context().attribute(which).map(|value| value as u64);
        let processors = attribute(Attribute::CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT)?;
        let threads = attribute(Attribute::CU_DEVICE_ATTRIBUTE_MAX_THREADS_PER_MULTIPROCESSOR)?;
        Ok(processors * threads)
    }

    /// What went wrong here, while doing what.
    pub(crate) fn failure(&self, doing: &str, error: DriverError) -> BackendError {
        failure(&self.name, doing, error)
    }
}
