//! What a rank has of its host, and whether it computes as all do.

use std::hint::black_box;
use std::thread::available_parallelism;

/// Processors that this process may use, and that the host has.
pub(super) fn processors() -> (u32, u32) {
    let mine = available_parallelism().map_or(1, |number| number.get() as u32);
    #[cfg(unix)]
    // SAFETY: it asks for a number.
    let all = unsafe { libc::sysconf(libc::_SC_NPROCESSORS_ONLN) };
    #[cfg(not(unix))]
    let all = 0;
    (mine, u32::try_from(all).unwrap_or(0).max(mine))
}

/// Threads for a rank, of so many on its host: launchers give each the whole host, or a part of it, which others may have,
/// too.
pub(super) fn threads((mine, all): (u32, u32), ranks_on_host: u32) -> u32 {
    // Where each has a part, so many ranks have the same one.
    let sharers = (u64::from(ranks_on_host) * u64::from(mine)).div_ceil(u64::from(all.max(1)));
    (mine / sharers.max(1) as u32).max(1)
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
    fn processors_are_shared_out() {
        // The whole host to each.
        assert_eq!([1, 2, 3, 8].map(|ranks| threads((8, 8), ranks)), [8, 4, 2, 1]);
        // A socket of two to each.
        assert_eq!([1, 2, 4].map(|ranks| threads((16, 32), ranks)), [16, 16, 8]);
        // One of its own to each; and more ranks than there are.
        assert_eq!([1, 4, 8, 16].map(|ranks| threads((1, 8), ranks)), [1, 1, 1, 1]);
        assert_eq!(threads((2, 2), 64), 1);
    }

    #[test]
    fn this_process_rounds_as_usual() {
        assert_eq!(check_rounding(), Ok(()));
    }
}
