//! The functions of `libcuda` that the program calls. Whatever is asked for is done before they return.
//!
//! All of them are unsafe to call: pointers must be as the documentation of the driver says.
#![allow(unsafe_op_in_unsafe_fn, reason = "the whole of each function relies on what it was handed")]

use crate::execute::Program;
use crate::{launch, parse};
use std::alloc::{Layout, alloc_zeroed, dealloc};
use std::collections::HashMap;
use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::ptr::dangling_mut;
use std::sync::{Mutex, OnceLock};
use std::time::Instant;

/// `CUresult`.
type Answer = c_int;
const SUCCESS: Answer = 0;
const INVALID_VALUE: Answer = 1;
const OUT_OF_MEMORY: Answer = 2;
const INVALID_PTX: Answer = 218;
const NOT_FOUND: Answer = 500;

/// What the first text has that cannot be read.
static WHY_INVALID: OnceLock<CString> = OnceLock::new();

/// A number from the environment.
fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().and_then(|value| value.parse().ok()).unwrap_or(default)
}

fn total_bytes() -> usize {
    number("CUDA_EMULATOR_BYTES", 1 << 30) as usize
}

/// What was allocated: addresses and sizes.
fn allocations() -> &'static Mutex<HashMap<usize, usize>> {
    static ALL: OnceLock<Mutex<HashMap<usize, usize>>> = OnceLock::new();
    ALL.get_or_init(Mutex::default)
}

fn allocated(all: &HashMap<usize, usize>) -> usize {
    all.values().sum()
}

fn layout(bytes: usize) -> Layout {
    Layout::from_size_align(bytes.max(1), 256).expect("a size below the device's memory")
}

unsafe fn write<T>(to: *mut T, value: T) -> Answer {
    to.write(value);
    SUCCESS
}

/// Defines functions that have nothing to do.
macro_rules! nothing_to_do {
    ($($name:ident($($argument:ty),*))*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name($(_: $argument),*) -> Answer {
            SUCCESS
        }
    )*};
}

nothing_to_do! {
    cuInit(c_uint)
    cuCtxSetCurrent(*mut c_void)
    cuCtxSynchronize()
    cuCtxDestroy_v2(*mut c_void)
    cuDevicePrimaryCtxRelease_v2(c_int)
    cuDevicePrimaryCtxRelease(c_int)
    cuStreamDestroy_v2(*mut c_void)
    cuStreamSynchronize(*mut c_void)
    cuStreamWaitEvent(*mut c_void, *mut c_void, c_uint)
    cuStreamQuery(*mut c_void)
    cuEventSynchronize(*mut c_void)
    cuEventQuery(*mut c_void)
    cuModuleUnload(*mut c_void)
    cuFuncSetAttribute(*mut c_void, c_int, c_int)
    cuFuncSetCacheConfig(*mut c_void, c_int)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuDriverGetVersion(version: *mut c_int) -> Answer {
    write(version, 12_040)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuDeviceGetCount(count: *mut c_int) -> Answer {
    write(count, number("CUDA_EMULATOR_DEVICES", 1) as c_int)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuDeviceGet(device: *mut c_int, ordinal: c_int) -> Answer {
    if ordinal < 0 || ordinal as u64 >= number("CUDA_EMULATOR_DEVICES", 1) {
        return 101;
    }
    write(device, ordinal)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuDeviceGetName(name: *mut c_char, length: c_int, _: c_int) -> Answer {
    let own = b"emulated on CPUs\0";
    if (length as usize) < own.len() {
        return INVALID_VALUE;
    }
    own.as_ptr().cast::<c_char>().copy_to(name, own.len());
    SUCCESS
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuDeviceTotalMem_v2(bytes: *mut usize, _: c_int) -> Answer {
    write(bytes, total_bytes())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuDeviceGetAttribute(value: *mut c_int, attribute: c_int, _: c_int) -> Answer {
    let answer = match attribute {
        // Threads of a block and of a warp, processors, threads of a processor.
        1 => 1024,
        10 => 32,
        16 => 2,
        39 => 128,
        // 7.5: Turing.
        75 => 7,
        76 => 5,
        _ => 0,
    };
    write(value, answer)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuDevicePrimaryCtxRetain(context: *mut *mut c_void, device: c_int) -> Answer {
    write(context, (device as usize + 1) as *mut c_void)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuCtxCreate_v2(context: *mut *mut c_void, _: c_uint, _: c_int) -> Answer {
    write(context, dangling_mut())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuCtxGetCurrent(context: *mut *mut c_void) -> Answer {
    write(context, dangling_mut())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuStreamCreate(stream: *mut *mut c_void, _: c_uint) -> Answer {
    write(stream, dangling_mut())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuMemGetInfo_v2(free: *mut usize, total: *mut usize) -> Answer {
    let all = allocations().lock().unwrap();
    write(free, total_bytes() - allocated(&all));
    write(total, total_bytes())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuMemAlloc_v2(address: *mut usize, bytes: usize) -> Answer {
    let mut all = allocations().lock().unwrap();
    if bytes > total_bytes() - allocated(&all) {
        return OUT_OF_MEMORY;
    }
    let memory = alloc_zeroed(layout(bytes)) as usize;
    // What was not written is no zero.
    (memory as *mut u8).write_bytes(0xa5, bytes);
    all.insert(memory, bytes);
    write(address, memory)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuMemFree_v2(address: usize) -> Answer {
    match allocations().lock().unwrap().remove(&address) {
        Some(bytes) => dealloc(address as *mut u8, layout(bytes)),
        None => return INVALID_VALUE,
    }
    SUCCESS
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuMemAllocHost_v2(address: *mut usize, bytes: usize) -> Answer {
    // It is kept: processes with this driver are short.
    write(address, Box::leak(vec![0u128; bytes.div_ceil(16)].into_boxed_slice()).as_ptr() as usize)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuMemHostAlloc(address: *mut usize, bytes: usize, _: c_uint) -> Answer {
    cuMemAllocHost_v2(address, bytes)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuMemFreeHost(_: usize) -> Answer {
    SUCCESS
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuMemcpyHtoDAsync_v2(
    to: usize,
    from: *const u8,
    bytes: usize,
    _: *mut c_void,
) -> Answer {
    from.copy_to(to as *mut u8, bytes);
    SUCCESS
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuMemcpyDtoHAsync_v2(to: *mut u8, from: usize, bytes: usize, _: *mut c_void) -> Answer {
    (from as *const u8).copy_to(to, bytes);
    SUCCESS
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuMemcpyDtoDAsync_v2(to: usize, from: usize, bytes: usize, _: *mut c_void) -> Answer {
    (from as *const u8).copy_to(to as *mut u8, bytes);
    SUCCESS
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuMemsetD8Async(to: usize, byte: u8, count: usize, _: *mut c_void) -> Answer {
    (to as *mut u8).write_bytes(byte, count);
    SUCCESS
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuEventCreate(event: *mut *mut c_void, _: c_uint) -> Answer {
    write(event, Box::into_raw(Box::new(Instant::now())).cast())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuEventDestroy_v2(event: *mut c_void) -> Answer {
    drop(Box::from_raw(event.cast::<Instant>()));
    SUCCESS
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuEventRecord(event: *mut c_void, _: *mut c_void) -> Answer {
    write(event.cast(), Instant::now())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuEventElapsedTime(
    milliseconds: *mut f32,
    start: *mut c_void,
    end: *mut c_void,
) -> Answer {
    let [start, end] = [start, end].map(|event| *event.cast::<Instant>());
    write(milliseconds, end.duration_since(start).as_secs_f32() * 1e3)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuEventElapsedTime_v2(
    milliseconds: *mut f32,
    start: *mut c_void,
    end: *mut c_void,
) -> Answer {
    cuEventElapsedTime(milliseconds, start, end)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuModuleLoadData(module: *mut *mut c_void, image: *const c_char) -> Answer {
    let text = CStr::from_ptr(image).to_string_lossy();
    match parse::read(&text) {
        Ok(program) => write(module, Box::into_raw(Box::new(program)).cast()),
        Err(why) => {
            let _ = WHY_INVALID.set(CString::new(why).unwrap_or_default());
            INVALID_PTX
        }
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuModuleLoadDataEx(
    module: *mut *mut c_void,
    image: *const c_char,
    _: c_uint,
    _: *mut c_void,
    _: *mut c_void,
) -> Answer {
    cuModuleLoadData(module, image)
}

/// A kernel of a module.
struct Kernel {
    program: &'static Program,
    number: usize,
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuModuleGetFunction(
    function: *mut *mut c_void,
    module: *mut c_void,
    name: *const c_char,
) -> Answer {
    // Modules are kept.
    let program: &'static Program = &*module.cast::<Program>();
    let name = CStr::from_ptr(name).to_string_lossy();
    match program.numbers.get(&*name) {
        Some(&number) => write(function, Box::into_raw(Box::new(Kernel { program, number })).cast()),
        None => NOT_FOUND,
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuModuleGetGlobal_v2(
    address: *mut usize,
    bytes: *mut usize,
    module: *mut c_void,
    name: *const c_char,
) -> Answer {
    let program: &Program = &*module.cast::<Program>();
    let name = CStr::from_ptr(name).to_string_lossy();
    match program.globals.get(&*name) {
        Some(&(at, size)) => {
            write(bytes, size);
            write(address, at as usize)
        }
        None => NOT_FOUND,
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuFuncGetAttribute(
    value: *mut c_int,
    attribute: c_int,
    function: *mut c_void,
) -> Answer {
    let kernel = &*function.cast::<Kernel>();
    let answer = match attribute {
        0 => 1024,
        3 => kernel.program.functions[kernel.number].local_bytes as c_int,
        4 => 32,
        _ => 0,
    };
    write(value, answer)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuOccupancyMaxActiveBlocksPerMultiprocessor(
    blocks: *mut c_int,
    _: *mut c_void,
    _: c_int,
    _: usize,
) -> Answer {
    write(blocks, 1)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(
    blocks: *mut c_int,
    _: *mut c_void,
    _: c_int,
    _: usize,
    _: c_uint,
) -> Answer {
    write(blocks, 1)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuLaunchKernel(
    function: *mut c_void,
    blocks: c_uint,
    _: c_uint,
    _: c_uint,
    block_size: c_uint,
    _: c_uint,
    _: c_uint,
    _: c_uint,
    _: *mut c_void,
    parameters: *mut *mut c_void,
    _: *mut *mut c_void,
) -> Answer {
    let kernel = &*function.cast::<Kernel>();
    let count = kernel.program.functions[kernel.number].parameters;
    let parameters: Vec<u64> = (0..count).map(|k| *parameters.add(k) as u64).collect();
    launch::launch(kernel.program, kernel.number, &parameters, blocks, block_size);
    SUCCESS
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuGetErrorName(_: c_int, text: *mut *const c_char) -> Answer {
    write(text, c"error of the emulator".as_ptr())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn cuGetErrorString(error: c_int, text: *mut *const c_char) -> Answer {
    let why = WHY_INVALID.get().filter(|_| error == INVALID_PTX);
    write(text, why.map_or(c"error of the emulator".as_ptr(), |why| why.as_ptr()))
}
