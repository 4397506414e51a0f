//! Launches: warps of 32 threads, on all cores.

use crate::execute::{Place, Program, WARP, Warp};
use std::sync::atomic::{AtomicU64, Ordering};

/// Runs a kernel, whose parameters have these addresses.
///
/// # Safety
///
/// The parameters are as the kernel declares, and what they point to is there.
pub(crate) unsafe fn launch(
    program: &Program,
    kernel: usize,
    parameters: &[u64],
    blocks: u32,
    block_size: u32,
) {
    let warp_size = WARP as u32;
    let warps_of_block = block_size.div_ceil(warp_size);
    let warps = u64::from(blocks) * u64::from(warps_of_block);
    let next = AtomicU64::new(0);
    let work = || {
        let mut room = Warp::new(program, Place { first_thread: 0, block: 0, block_size, blocks });
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= warps {
                return;
            }
            let block = (number / u64::from(warps_of_block)) as u32;
            let first_thread = (number % u64::from(warps_of_block)) as u32 * warp_size;
            let threads = (block_size - first_thread).min(warp_size);
            let place = Place { first_thread, block, block_size, blocks };
            // SAFETY: by this function's contract.
            unsafe { room.run_kernel(kernel, parameters, place, threads) };
        }
    };
    let workers = std::thread::available_parallelism().map_or(1, |count| count.get() as u64).min(warps);
    if workers <= 1 {
        return work();
    }
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(work);
        }
    });
}
