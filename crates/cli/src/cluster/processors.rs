//! What a rank has of its host, and whether it computes as all do.

use std::hint::black_box;
use std::thread::available_parallelism;

/// Processors that this process may use, and that the host has.
pub(super) fn processors() -> (u32, u32) {
    let mine = available_parallelism().map_or(1, |number| number.get() as u32);
    #[cfg(unix)]
    // SAFETY: sysconf takes a number and returns one; it touches no memory of this program.
    let all = unsafe { libc::sysconf(libc::_SC_NPROCESSORS_ONLN) };
    #[cfg(not(unix))]
    let all = 0;
    (mine, u32::try_from(all).unwrap_or(0).max(mine))
}

/// Bytes of [`mask`].
pub(super) const MASK_BYTES: usize = 128;

/// The processors that this process may use, a bit each. Launchers give each rank all of its host, or a part of it, which others
/// may have, too.
pub(super) fn mask() -> [u8; MASK_BYTES] {
    #[allow(unused_mut, reason = "only Linux says it")]
    let mut bits = [0; MASK_BYTES];
    #[cfg(target_os = "linux")]
    // SAFETY: sched_getaffinity writes at most MASK_BYTES bytes, and `bits` has as many; where it fails, it writes none.
    unsafe {
        libc::sched_getaffinity(0, MASK_BYTES, bits.as_mut_ptr().cast());
    }
    bits
}

/// How many ranks have the processors of this one: those of its host with the same mask.
pub(super) fn sharers(rank: usize, hosts: &[String], masks: &[[u8; MASK_BYTES]]) -> u32 {
    let same = hosts.iter().zip(masks).filter(|(host, mask)| **host == hosts[rank] && **mask == masks[rank]);
    same.count().max(1) as u32
}

/// Whether this process rounds as processors do unless told otherwise; some libraries change that for a whole process. The
/// pixels of all ranks would not be the same.
pub(super) fn check_rounding() -> Result<(), String> {
    let least = black_box(f32::MIN_POSITIVE);
    let keeps_small_numbers =
        black_box(least * 0.5) > 0.0 && black_box(black_box(f32::from_bits(1)) * 8388608.0) > 0.0;
    // Half an ulp more and less than 1: to the even one, neither up nor down.
    let rounds = black_box(black_box(1.0f32) + 2f32.powi(-24)) == 1.0
        && black_box(black_box(1.0f32) - 2f32.powi(-25)) == 1.0
        && black_box(black_box(1.0f32) + 1.5 * 2f32.powi(-23)) == 1.0 + 2.0 * 2f32.powi(-23);
    match keeps_small_numbers && rounds {
        true => Ok(()),
        false => Err("its processor is not set to the usual rounding of floating-point numbers: a library has changed \
                      that, as those do that are built with -ffast-math; leave it out"
            .into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_with_the_same_processors_share_them() {
        let hosts = ["a", "a", "b", "a"].map(String::from);
        let masks = [1, 1, 1, 2].map(|bits| [bits; MASK_BYTES]);
        assert_eq!([0, 1, 2, 3].map(|rank| sharers(rank, &hosts, &masks)), [2, 2, 1, 1]);
        assert!(!cfg!(target_os = "linux") || mask() != [0; MASK_BYTES]);
    }

    #[test]
    fn this_process_rounds_as_usual() {
        assert_eq!(check_rounding(), Ok(()));
    }
}
