//! What kernels take besides arrays, and what they write: declared once for hosts and devices.

use crate::develop::Development;
use crate::math::Vec3;
use crate::ray::{Hit, PrimitiveId, UNKNOWN_REST};
use crate::sums::ExactSum;
use crate::view::SceneCounts;

/// The last parameter of every kernel that renders: a band of rows.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct BandLaunch {
    /// How many items the scene's arrays have.
    pub counts: SceneCounts,
    /// The colours of the band's pixels, row after row, are written here: for all samples at once.
    pub film: *mut Vec3,
    /// The sums of the band's pixels are written here instead; null where colours are wanted.
    pub sums: *mut ExactSum,
    /// What the launch traces is added to these, atomically.
    pub totals: *mut RayTotals,
    /// The first row.
    pub first_row: u32,
    /// The row after the last.
    pub end_row: u32,
    /// The first sample of each pixel.
    pub first_sample: u32,
    /// The sample after the last.
    pub end_sample: u32,
    /// So many threads share the samples of a pixel, as a power of two; at most 5: a warp.
    pub sharing: u32,
}

/// Rays of a launch, and the work on them: sums over all threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct RayTotals {
    /// Rays from the camera.
    pub camera: u64,
    /// Mirrored rays.
    pub reflected: u64,
    /// Rays through surfaces.
    pub refracted: u64,
    /// Rays of glossy lobes.
    pub glossy: u64,
    /// Rays towards lights.
    pub shadow: u64,
    /// Searches through a hierarchy; this and what follows is 0 but for kernels that count.
    pub searches: u64,
    /// Nodes that searches visited.
    pub nodes: u64,
    /// Primitives that searches tested.
    pub primitives: u64,
    /// Ticks of the processors' clocks in traversal.
    pub traversal_ticks: u64,
    /// The same in tests of primitives.
    pub intersection_ticks: u64,
    /// Ticks of all threads, from begin to end.
    pub thread_ticks: u64,
    /// The same in nanoseconds of the device's clock, which goes in coarse steps.
    pub thread_nanoseconds: u64,
}

/// What the kernel takes that develops: the colours of pixels become bytes.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct DevelopLaunch {
    /// The colours.
    pub film: *const Vec3,
    /// The bytes are written here, three a pixel, as words: [`DevelopLaunch::words`] of them.
    pub words: *mut u32,
    /// How many pixels there are.
    pub pixels: u32,
    /// How they are developed.
    pub development: Development,
}

impl DevelopLaunch {
    /// Pixels of a thread: their bytes are whole words.
    pub const PIXELS: u32 = 4;

    /// Words that the bytes of a thread's pixels take.
    pub const WORDS: u32 = 3;

    /// Threads for so many pixels. The last one may have fewer than the others; its words are written, too.
    #[inline(always)]
    pub const fn threads(pixels: u32) -> u32 {
        pixels.div_ceil(DevelopLaunch::PIXELS)
    }

    /// Words that so many pixels take.
    pub const fn words(pixels: u32) -> usize {
        DevelopLaunch::threads(pixels) as usize * DevelopLaunch::WORDS as usize
    }

    /// Puts a pixel's bytes behind those that are in words already, from which those of the oldest one drop out. In memory four
    /// pixels are 12 bytes, the first one first.
    #[inline(always)]
    pub fn with_pixel([low, middle, high]: [u32; 3], [r, g, b]: [u8; 3]) -> [u32; 3] {
        let pixel = r as u32 | (g as u32) << 8 | (b as u32) << 16;
        [low >> 24 | middle << 8, middle >> 24 | high << 8, high >> 24 | pixel << 8]
    }
}

/// A hit as kernels write it: 16 bytes at once. The instance, where there are any, goes to an array of its own.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct HitRow {
    /// Distance along the ray.
    pub t: f32,
    /// First barycentric coordinate.
    pub u: f32,
    /// Second barycentric coordinate.
    pub v: f32,
    /// Index of the primitive, or that of [`PrimitiveId::NONE`].
    pub primitive: u32,
}

impl HitRow {
    /// The hit, where the row of the other array names this instance.
    pub fn hit(&self, instance: u32) -> Hit {
        let &HitRow { t, u, v, primitive } = self;
        let is_miss = primitive == PrimitiveId::NONE.primitive;
        let id = if is_miss { PrimitiveId::NONE } else { PrimitiveId { instance, primitive } };
        // Kernels do not write the rest of `t`.
        Hit { t, t_rest: UNKNOWN_REST, u, v, id }
    }
}

impl From<Hit> for HitRow {
    #[inline(always)]
    fn from(hit: Hit) -> HitRow {
        HitRow { t: hit.t, u: hit.u, v: hit.v, primitive: hit.id.primitive }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_pixels_are_three_words() {
        let pixels: [[u8; 3]; 4] = [[1, 2, 3], [250, 251, 252], [7, 0, 9], [128, 255, 200]];
        let words = pixels.into_iter().fold([u32::MAX; 3], DevelopLaunch::with_pixel);
        assert_eq!(words.map(u32::to_le_bytes).as_flattened(), pixels.as_flattened());
        assert_eq!([0, 1, 4, 5].map(DevelopLaunch::threads), [0, 1, 1, 2]);
        assert_eq!([0, 1, 4, 5].map(DevelopLaunch::words), [0, 3, 3, 6]);
    }
}
