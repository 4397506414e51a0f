//! What the threads of a warp, 32 of them, add up together. All of them must ask.

use core::arch::asm;
use eosphor_core::sums::ExactSum;

/// Threads of a warp.
pub(crate) const WARP: u32 = 32;

/// What the thread has whose number differs from this one's in these bits.
#[inline(always)]
fn across(number: u64, bits: u32) -> u64 {
    let exchange = |half: u32| {
        let theirs: u32;
        // SAFETY: all threads of the warp come here.
        unsafe {
            asm!(
                "shfl.sync.bfly.b32 {0}, {1}, {2}, 31, 0xffffffff;",
                out(reg32) theirs, in(reg32) half, in(reg32) bits, options(nomem, nostack)
            );
        }
        theirs
    };
    (exchange((number >> 32) as u32) as u64) << 32 | exchange(number as u32) as u64
}

/// The same, but the compiler does not know which.
#[inline(always)]
pub(crate) fn unknown(of: bool) -> bool {
    hidden(of as u32) != 0
}

/// The same number, but the compiler does not know which: a loop of so many turns stays one.
#[inline(always)]
pub(crate) fn hidden(number: u32) -> u32 {
    let same: u32;
    // SAFETY: copies a register.
    unsafe { asm!("mov.b32 {0}, {1};", out(reg32) same, in(reg32) number, options(nomem, nostack)) };
    same
}

/// For which threads this is true, as bits.
#[inline(always)]
pub(crate) fn lanes(of: bool) -> u32 {
    let lanes;
    // SAFETY: all threads of the warp come here.
    unsafe {
        asm!(
            "{{.reg .pred p; setp.ne.u32 p, {1}, 0; vote.sync.ballot.b32 {0}, p, 0xffffffff;}}",
            out(reg32) lanes, in(reg32) of as u32, options(nomem, nostack)
        );
    }
    lanes
}

/// What the first thread makes, for all.
#[inline(always)]
pub(crate) fn from_first_lane(lane: u32, make: impl FnOnce() -> u64) -> u64 {
    let made = if lane == 0 { make() } else { 0 };
    let of_first = |half: u32| {
        let theirs: u32;
        // SAFETY: all threads of the warp come here.
        unsafe {
            asm!(
                "shfl.sync.idx.b32 {0}, {1}, 0, 31, 0xffffffff;",
                out(reg32) theirs, in(reg32) half, options(nomem, nostack)
            );
        }
        theirs
    };
    (of_first((made >> 32) as u32) as u64) << 32 | of_first(made as u32) as u64
}

/// The sum over all threads.
#[inline(always)]
pub(crate) fn total(number: u64) -> u64 {
    let mut sum = number;
    let mut bits = 1;
    // Five turns that are wanted once: not worth code for each.
    while bits < hidden(WARP) {
        sum += across(sum, bits);
        bits *= 2;
    }
    sum
}

/// The sum over `lanes` neighbours, a power of two.
#[inline(always)]
pub(crate) fn merged(own: ExactSum, lanes: u32) -> ExactSum {
    let mut sum = own;
    let mut bits = 1;
    while bits < lanes {
        let theirs = ExactSum {
            units: [across(sum.units[0], bits), across(sum.units[1], bits), across(sum.units[2], bits)],
        };
        sum.merge(&theirs);
        bits *= 2;
    }
    sum
}
