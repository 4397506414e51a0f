//! Memory that runs out ends the program with a line that says so, not with an abort and a backtrace.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;

/// The system's allocator.
pub(crate) struct Allocator;

#[cold]
fn out_of_memory(bytes: usize) -> ! {
    // Nothing here may allocate, and nothing can be done where standard error is closed.
    let mut line = [0u8; 160];
    let room = line.len();
    let mut rest = &mut line[..];
    let _ = writeln!(
        rest,
        "eosphor: out of memory: {bytes} bytes more are needed; use smaller textures, fewer triangles or more memory"
    );
    let length = room - rest.len();
    let _ = std::io::stderr().write_all(&line[..length]);
    std::process::exit(1)
}

fn checked(pointer: *mut u8, bytes: usize) -> *mut u8 {
    if pointer.is_null() { out_of_memory(bytes) } else { pointer }
}

// SAFETY: every call is passed to the system's allocator with the same arguments; memory that it does not give ends the process.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: `layout` is not of size zero: the condition of `GlobalAlloc::alloc`, which `System` has too.
        checked(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: `layout` is not of size zero: the condition of `GlobalAlloc::alloc_zeroed`, which `System` has too.
        checked(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        // SAFETY: `pointer` came from `System` with this layout, and `new_size` is neither zero nor too large: the conditions of
        // `GlobalAlloc::realloc`; all memory of this allocator is that of `System`.
        checked(unsafe { System.realloc(pointer, layout, new_size) }, new_size)
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System` with this layout: the condition of `GlobalAlloc::dealloc`; all memory of this
        // allocator is that of `System`.
        unsafe { System.dealloc(pointer, layout) }
    }
}
