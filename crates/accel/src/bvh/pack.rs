//! Primitives into the order of the leaves, with fused multiply-adds where the CPU has them.

use crate::SimdLevel;
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::math::Vec3;
use rayon::prelude::*;
use std::mem::MaybeUninit;

/// Items that a thread fills at a time.
const CHUNK: usize = 4096;

/// Appends `count` items to a vector: `fill` is given chunks of room, and the number of their first item, and must
/// write all of it.
///
/// # Safety
/// `fill` writes every item of the room it is given.
pub(crate) unsafe fn fill_in_parallel<T: Send>(
    items: &mut Vec<T>,
    count: usize,
    fill: impl Fn(usize, &mut [MaybeUninit<T>]) + Sync,
) {
    items.reserve_exact(count);
    let room = &mut items.spare_capacity_mut()[..count];
    room.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, room)| fill(chunk * CHUNK, room));
    // SAFETY: the caller's `fill` has written all of the room.
    unsafe { items.set_len(items.len() + count) };
}

/// Appends triangles with these numbers, whose vertices are given for all numbers.
pub(crate) fn pack(packed: &mut Vec<PackedTriangle>, vertices: &[[Vec3; 3]], order: &[u32]) {
    let level = SimdLevel::best();
    // SAFETY: `fill` goes through all places; `order` has as many numbers as there are places.
    unsafe {
        fill_in_parallel(packed, order.len(), |first, room| {
            let order = &order[first..][..room.len()];
            match level {
                // SAFETY: the CPU has these features.
                #[cfg(target_arch = "x86_64")]
                SimdLevel::Avx2 | SimdLevel::Avx512 => fill_avx2(room, vertices, order),
                _ => fill(room, vertices, order),
            }
        });
    }
}

/// [`fill`], with fused multiply-adds as instructions.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn fill_avx2(room: &mut [MaybeUninit<PackedTriangle>], vertices: &[[Vec3; 3]], order: &[u32]) {
    fill(room, vertices, order);
}

#[inline(always)]
fn fill(room: &mut [MaybeUninit<PackedTriangle>], vertices: &[[Vec3; 3]], order: &[u32]) {
    for (place, &primitive) in room.iter_mut().zip(order) {
        place.write(PackedTriangle::new(vertices[primitive as usize], primitive));
    }
}
