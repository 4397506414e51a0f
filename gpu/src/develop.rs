//! Developing: a thread makes the bytes of some pixels that lie together, so that it writes whole words.

use crate::queue::Threads;
use eosphor_core::develop::developed;
use eosphor_core::device::DevelopLaunch;
use eosphor_core::math::Vec3;

/// Develops the thread's pixels.
///
/// # Safety
///
/// The launch's `film` has `pixels` colours, and its `words` have room for as many as they take; nobody else writes them.
#[inline(always)]
pub(crate) unsafe fn develop(launch: &DevelopLaunch) {
    let thread = Threads::here().number;
    if thread >= DevelopLaunch::threads(launch.pixels) {
        return;
    }
    let first = thread * DevelopLaunch::PIXELS;
    let (mut words, mut number) = ([0; 3], 0);
    while number < DevelopLaunch::PIXELS {
        let pixel = first + number;
        let color = match pixel < launch.pixels {
            // SAFETY: there are so many colours.
            true => unsafe { *launch.film.add(pixel as usize) },
            false => Vec3::ZERO,
        };
        words = DevelopLaunch::with_pixel(words, developed(color, &launch.development));
        number += 1;
    }
    // SAFETY: there is room for each thread's words, and these are of this one alone.
    unsafe {
        let to = launch.words.add(thread as usize * DevelopLaunch::WORDS as usize);
        *to = words[0];
        *to.add(1) = words[1];
        *to.add(2) = words[2];
    }
}
