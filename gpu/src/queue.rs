//! What kernels that work on queues have in common: which items a thread takes, reading and writing them, and places in lists.

use crate::warp::{self, WARP};
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _grid_dim_x, _thread_idx_x};
use core::sync::atomic::{AtomicU64, Ordering};
use eosphor_core::device::Row;

/// A thread's place among all of the launch.
pub(crate) struct Threads {
    pub(crate) number: u32,
    pub(crate) all: u32,
}

impl Threads {
    #[inline(always)]
    pub(crate) fn here() -> Threads {
        // SAFETY: these read the thread's numbers and the launch's shape.
        unsafe {
            Threads {
                number: (_block_idx_x() as u32) * (_block_dim_x() as u32) + _thread_idx_x() as u32,
                all: (_grid_dim_x() as u32) * (_block_dim_x() as u32),
            }
        }
    }

    /// The thread's place in its warp.
    #[inline(always)]
    pub(crate) fn lane(&self) -> u32 {
        self.number % WARP
    }

    /// The items that a warp takes first begin here; the next ones come `all` later, so that its threads come equally often.
    #[inline(always)]
    pub(crate) fn first_of_warp(&self) -> u32 {
        self.number - self.lane()
    }
}

/// Reads an item's rows: arrays of `room` rows one after the other.
///
/// # Safety
///
/// `item` is below `room`, and so many arrays are there.
#[inline(always)]
pub(crate) unsafe fn read<const N: usize>(rows: *const Row, room: u32, item: u32) -> [Row; N] {
    let mut read = [Row::default(); N];
    let mut k = 0;
    while k < N {
        // SAFETY: inside of the k-th array.
        read[k] = unsafe { *rows.add(k * room as usize + item as usize) };
        k += 1;
    }
    read
}

/// Writes an item's rows.
///
/// # Safety
///
/// As for [`read`], and no other thread has this item.
#[inline(always)]
pub(crate) unsafe fn write<const N: usize>(rows: *mut Row, room: u32, item: u32, written: [Row; N]) {
    let mut k = 0;
    while k < N {
        // SAFETY: inside of the k-th array.
        unsafe { *rows.add(k * room as usize + item as usize) = written[k] };
        k += 1;
    }
}

/// Places at the ends of two lists that the threads of a warp take together.
pub(crate) struct Places {
    lane: u32,
    first: u64,
    takers: [u32; 2],
}

impl Places {
    /// Takes one in each list for the threads that want it. The lengths of the lists are the halves of `lengths`.
    ///
    /// # Safety
    ///
    /// `lengths` is there, and touched by additions like this alone. All threads of the warp come here.
    #[inline(always)]
    pub(crate) unsafe fn take(lengths: *mut u64, lane: u32, [first, second]: [bool; 2]) -> Places {
        // The compiler must not know what they want, or else it makes copies of what follows, for those that want nothing: threads
        // of a warp would vote in several places.
        let takers = [warp::lanes(warp::unknown(first)), warp::lanes(warp::unknown(second))];
        let taken = (takers[0].count_ones() as u64) | (takers[1].count_ones() as u64) << 32;
        // SAFETY: by this function's contract.
        let lengths = unsafe { AtomicU64::from_ptr(lengths) };
        // All warps add to one address: those that want nothing spare themselves that.
        let add = || if taken > 0 { lengths.fetch_add(taken, Ordering::Relaxed) } else { 0 };
        Places { lane, first: warp::from_first_lane(lane, add), takers }
    }

    /// Whether the thread has one in this list.
    #[inline(always)]
    pub(crate) fn has(&self, list: usize) -> bool {
        self.takers[list] >> self.lane & 1 != 0
    }

    /// Which one.
    #[inline(always)]
    pub(crate) fn at(&self, list: usize) -> u32 {
        let before = self.takers[list] & ((1 << self.lane) - 1);
        (self.first >> (32 * list as u32)) as u32 + before.count_ones()
    }
}
