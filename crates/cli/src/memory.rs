//! Whether a picture fits in memory. An allocation that does not would end the program without a word.

use crate::failure::Failure;
use crate::text::bytes;
use std::fs;

/// Linear film and developed bytes of a pixel.
const BYTES_A_PIXEL: u64 = 12 + 3;

/// Fails where the picture is larger than the memory that is free.
pub(crate) fn check_fits(size: [u32; 2]) -> Result<(), Failure> {
    available().map_or(Ok(()), |free| check_fits_in(free, size))
}

fn check_fits_in(free: u64, [width, height]: [u32; 2]) -> Result<(), Failure> {
    let needed = width as u64 * height as u64 * BYTES_A_PIXEL;
    if needed <= free {
        return Ok(());
    }
    let (needed, free) = (bytes(needed), bytes(free));
    Err(Failure::Failed(format!(
        "the picture does not fit in memory: {width} x {height} needs {needed}, and {free} are free: \
         choose a smaller --size",
    )))
}

/// What the system says is free, and no more than the control group may use; `None` where neither says.
fn available() -> Option<u64> {
    let system = fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
        Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
    });
    // "max" where there is no limit. What is in use is left out: it counts file caches, which the group gives back.
    let group =
        fs::read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|text| text.trim().parse().ok());
    system.into_iter().chain(group).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_picture_needs_64_gigabytes() {
        let line = check_fits_in(1 << 30, [65_535, 65_535]).unwrap_err().line().unwrap();
        assert!(line.contains("65535 x 65535 needs 64.4 GB, and 1.1 GB are free"), "{line}");
        assert!(check_fits_in(1 << 30, [1920, 1080]).is_ok());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn linux_says_what_is_free() {
        assert!(available().is_some_and(|free| free > 1 << 20));
    }
}
