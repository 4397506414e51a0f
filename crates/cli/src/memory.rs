//! Whether a picture fits in memory. An allocation that does not would end the program without a word.

use crate::failure::Failure;
use crate::text::bytes;
use std::fs;

/// Linear film and developed bytes of a pixel.
const BYTES_A_PIXEL: u64 = 12 + 3;

/// Fails where the picture is larger than the memory that is free.
pub(crate) fn check_fits([width, height]: [u32; 2]) -> Result<(), Failure> {
    let needed = width as u64 * height as u64 * BYTES_A_PIXEL;
    match available() {
        Some(free) if needed > free => Err(Failure::Failed(format!(
            "the picture does not fit in memory: {width} x {height} needs {}, and {} are free: choose a smaller --size",
            bytes(needed),
            bytes(free),
        ))),
        _ => Ok(()),
    }
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
