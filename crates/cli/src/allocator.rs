//! Memory that runs out ends the program with a line that says so, not with an abort and a backtrace; and large arrays lie in
//! large pages.

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

/// Lets memory that is given back stay with the process, for what comes next, and all threads share it: pages that the system has
/// to clear first cost a picture of 331,000 triangles another twentieth of its time. To be called before threads are started.
pub(crate) fn keep_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    for (parameter, value) in [
        (libc::M_ARENA_MAX, 1),
        // The largest value that there is.
        (libc::M_MMAP_THRESHOLD, 32 << 20),
        (libc::M_TRIM_THRESHOLD, 256 << 20),
    ] {
        // SAFETY: these are numbers of the allocator; what it does not know it leaves as it is.
        unsafe { libc::mallopt(parameter, value) };
    }
}

/// Arrays from this size on lie in large pages: on Linux, a fifteenth of the time of a picture of 331,000 triangles was the
/// kernel's, giving out pages of 4 KiB.
const LARGE: usize = 4 << 20;

fn checked(pointer: *mut u8, bytes: usize) -> *mut u8 {
    if pointer.is_null() {
        out_of_memory(bytes);
    }
    if bytes >= LARGE {
        advise_large_pages(pointer, bytes);
    }
    pointer
}

/// Asks for the whole 2 MiB pages of an array as such.
#[cfg(target_os = "linux")]
#[cold]
fn advise_large_pages(pointer: *mut u8, bytes: usize) {
    const PAGE: usize = 2 << 20;
    let start = (pointer as usize).next_multiple_of(PAGE);
    let end = (pointer as usize + bytes) / PAGE * PAGE;
    if start < end {
        // SAFETY: the range lies in this allocation; the advice changes how memory is backed, not what it holds. It may be refused,
        // and then pages are small.
        unsafe { libc::madvise(start as *mut libc::c_void, end - start, libc::MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
fn advise_large_pages(_: *mut u8, _: usize) {}

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
