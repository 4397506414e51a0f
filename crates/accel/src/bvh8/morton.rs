//! The fastest way to build: triangles are read once for their codes and once for their blocks, and boxes of leaves are
//! found while blocks are packed.

use super::TriangleBlock;
use super::blocks::{lanes, pack};
use crate::bvh::{AHEAD, Key, Shape, Tree, prefetch, room_for};
use crate::simd_level::has_avx2;
use eosphor_core::geometry::Bounds;
use eosphor_core::math::Vec3;
use rayon::prelude::*;
use std::mem::MaybeUninit;

/// A tree over at least one triangle, whose leaves name blocks, the blocks, and what [`Packed::farthest`] says of all.
///
/// [`Packed::farthest`]: super::blocks::Packed::farthest
pub(super) fn build(triangles: &[[Vec3; 3]]) -> (Tree, Vec<TriangleBlock>, f32) {
    let Shape { keys, mut piece } = Shape::new(triangles);
    let parts = piece.wholes();
    let count = parts.iter().map(|tree| tree.leaf_count()).sum();
    let mut blocks: Vec<TriangleBlock> = room_for(count);
    let mut room = &mut blocks.spare_capacity_mut()[..count];
    let mut work = Vec::with_capacity(parts.len());
    for tree in parts {
        let own;
        (own, room) = room.split_at_mut(tree.leaf_count());
        work.push((tree, own));
    }
    let leaves = Leaves { keys: &keys, triangles };
    let has_avx2 = has_avx2();
    let farthest = work.into_par_iter().map(|(tree, room)| match has_avx2 {
        // SAFETY: instruction set: the CPU has been asked for AVX2 and FMA.
        #[cfg(target_arch = "x86_64")]
        true => unsafe { leaves.fill_avx2(tree, room) },
        // SAFETY: instruction set: none is needed.
        _ => unsafe { leaves.fill::<false>(tree, room) },
    });
    let farthest = farthest.reduce(|| 0.0, f32::max);
    // SAFETY: written places: each part has written one block a leaf.
    unsafe { blocks.set_len(count) };
    drop(keys);
    piece.find_bounds();
    (piece.join(), blocks, farthest)
}

struct Leaves<'a> {
    keys: &'a [Key],
    triangles: &'a [[Vec3; 3]],
}

impl Leaves<'_> {
    /// [`Leaves::fill`], with fused multiply-adds as instructions.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn fill_avx2(&self, tree: &mut Tree, room: &mut [MaybeUninit<TriangleBlock>]) -> f32 {
        // SAFETY: instruction set: it has been switched on here.
        unsafe { self.fill::<true>(tree, room) }
    }

    /// Writes the blocks of a part's leaves, and the boxes of all of its nodes; what is farthest in them.
    ///
    /// # Safety
    /// With `AVX2` the CPU must have AVX2 and FMA.
    #[inline(always)]
    unsafe fn fill<const AVX2: bool>(&self, tree: &mut Tree, room: &mut [MaybeUninit<TriangleBlock>]) -> f32 {
        let mut farthest = 0.0f32;
        let mut places = room.iter_mut().enumerate();
        for node in tree.nodes.iter_mut().filter(|n| !n.is_inner()) {
            let (first, count) = (node.first as usize, node.count as usize);
            // All four, also of smaller leaves, so that there is no loop to foresee the end of.
            if let Some(next) = self.keys.get(first + AHEAD..first + AHEAD + 4) {
                for k in 0..4 {
                    prefetch(self.triangles, next[k] as u32 as usize);
                }
            }
            let keys = &self.keys[first..][..count];
            let numbers = lanes(count, |k| keys[k] as u32);
            let (number, place) = places.next().expect("a block for each leaf");
            // SAFETY: instruction set: promised to this function.
            let packed = unsafe { pack::<AVX2>(place, numbers, count, self.triangles) };
            Bounds { min: node.min, max: node.max } = packed.bounds;
            farthest = farthest.max(packed.farthest);
            node.first = number as u32;
        }
        // Children stand behind their parents.
        for at in (0..tree.nodes.len()).rev() {
            let node = tree.nodes[at];
            if node.is_inner() {
                let [a, b] = [node.first as usize, node.first as usize + 1].map(|k| tree.nodes[k]);
                (tree.nodes[at].min, tree.nodes[at].max) = (a.min.min(b.min), a.max.max(b.max));
            }
        }
        farthest
    }
}
