//! The film: linear colours, before developing.

use eosphor_core::math::Vec3;

/// A picture in linear RGB, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// `width * height` colours, row after row from the top.
    pub pixels: Vec<Vec3>,
}

impl Film {
    /// A black film of this width and height in pixels.
    pub fn new(width: u32, height: u32) -> Film {
        let pixels = black(width as usize * height as usize);
        ask_for_large_pages(&pixels);
        Film { width, height, pixels }
    }
}

/// Bytes of a picture that nobody has written yet.
pub(crate) fn zeros(length: usize) -> Vec<u8> {
    let bytes = vec![0; length];
    ask_for_large_pages(&bytes);
    bytes
}

/// Black pixels that nobody has written yet: of floats the library knows that zeros can be had from the system, of colours
/// it does not, and writes them, on one thread.
fn black(pixels: usize) -> Vec<Vec3> {
    const { assert!(size_of::<Vec3>() == 3 * size_of::<f32>() && align_of::<Vec3>() == align_of::<f32>()) };
    let mut floats = std::mem::ManuallyDrop::new(vec![0f32; 3 * pixels]);
    assert_eq!(floats.capacity(), 3 * pixels, "a vector of zeros has no room to spare");
    // SAFETY: `floats` is not dropped and gives its allocation away: `Vec3` has the size of three floats and their alignment
    // (checked at compile time), length and capacity are 3 × `pixels` floats (checked above), and three zeros are a valid `Vec3`.
    unsafe { Vec::from_raw_parts(floats.as_mut_ptr().cast(), pixels, pixels) }
}

/// Asks the system to give memory in large pages. A film is new memory, which comes a page at a time where it is first
/// written; of the usual 4 kB, that takes longer than a GPU takes for the picture.
#[cfg(target_os = "linux")]
fn ask_for_large_pages<T>(pixels: &[T]) {
    const PAGE: usize = 4096;
    let (start, bytes) = (pixels.as_ptr() as usize, size_of_val(pixels));
    let first = start.next_multiple_of(PAGE);
    let end = (start + bytes) / PAGE * PAGE;
    if end > first {
        // SAFETY: the pages lie in memory that is borrowed, and advice changes nothing in it. It need not be taken.
        unsafe { libc::madvise(first as *mut libc::c_void, end - first, libc::MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
fn ask_for_large_pages<T>(_pixels: &[T]) {}
