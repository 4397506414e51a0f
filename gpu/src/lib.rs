//! Kernel entry points. They are thin: everything that is computed is in `eosphor-core`, which the CPU compiles too.
//!
//! | file | has |
//! |---|---|
//! | `kernels.rs` | the entry points that render, over each structure and without any, and the parameters that they take |
//! | `parameters.rs` | arrays out of parameters |
//! | `paths.rs` | what path tracing does with queues of paths, kernel by kernel |
//! | `trees.rs` | the same of Whitted's trees of rays |
//! | `lights.rs` | the same of these trees' shadow rays |
//! | `walks.rs` | what both do whose rays are traced |
//! | `walk_function.rs` | walks that several kernels call |
//! | `queue.rs` | what both do with queues |
//! | `develop.rs` | bytes of colours |
//! | `band.rs` | which samples of which pixel a thread renders, and the rendering of them |
//! | `warp.rs` | what the threads of a warp add up together |
//! | `totals.rs` | rays counted |
//! | `watch.rs` | what queries do, counted and timed, in kernels that are made for that |
//! | `rays.rs` | entry points that answer queries about rays, without a picture |
#![no_std]
#![feature(abi_ptx, asm_experimental_arch, stdarch_nvptx)]

mod band;
mod develop;
mod kernels;
mod lights;
mod parameters;
mod paths;
mod queue;
mod rays;
mod totals;
mod trees;
mod walk_function;
mod walks;
mod warp;
mod watch;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    // SAFETY: ends the kernel with an error. `cargo xtask ptx` makes sure that nothing gets here.
    unsafe { core::arch::nvptx::trap() }
}
