//! Primitives into the order of the leaves, with fused multiply-adds where the CPU has them.

use crate::simd_level::has_avx2;
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
    // SAFETY: written places: `fill` has written all of the room, as promised to this function.
    unsafe { items.set_len(items.len() + count) };
}

/// Asks for an item that will be read soon: primitives lie in another order in memory than in a tree, and half of the
/// time of packing them would be waiting.
#[inline(always)]
pub(crate) fn prefetch<T>(items: &[T], at: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(item) = items.get(at) {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let first = std::ptr::from_ref(item).cast::<i8>();
        // SAFETY: prefetching has no effect but on caches, and both addresses lie in the item.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(first);
            // It may end in the next cache line.
            _mm_prefetch::<_MM_HINT_T0>(first.add(size_of::<T>() - 1));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (items, at);
}

/// How many primitives ahead they are asked for.
pub(crate) const AHEAD: usize = 16;

/// Appends triangles with these numbers, whose vertices are given for all numbers.
pub(crate) fn pack(packed: &mut Vec<PackedTriangle>, vertices: &[[Vec3; 3]], order: &[u32]) {
    let has_avx2 = has_avx2();
    // SAFETY: written places: `fill` goes through all places; `order` has as many numbers as there are places.
    unsafe {
        fill_in_parallel(packed, order.len(), |first, room| {
            let order = &order[first..][..room.len()];
            match has_avx2 {
                // SAFETY: instruction set: the CPU has been asked for AVX2 and FMA.
                #[cfg(target_arch = "x86_64")]
                true => fill_avx2(room, vertices, order),
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
    for (k, (place, &primitive)) in room.iter_mut().zip(order).enumerate() {
        if let Some(&next) = order.get(k + AHEAD) {
            prefetch(vertices, next as usize);
        }
        place.write(PackedTriangle::new(vertices[primitive as usize], primitive));
    }
}
