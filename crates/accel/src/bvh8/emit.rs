//! Wide nodes, blocks of triangles and spheres, written where they belong.

use super::blocks::{lanes, pack};
use super::collapse::Cut;
use super::{Bvh8, Child, EMPTY, INSTANCE, LEAF, Node8, PLACE, SPHERE, TriangleBlock};
use crate::SceneGeometry;
use crate::bvh::{AHEAD, fill_in_parallel, prefetch};
use crate::simd_level::has_avx2;
use eosphor_core::geometry::Geometry;
use eosphor_core::hierarchy::BvhNode;
use eosphor_core::math::{Vec3, clamp};
use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicU32, Ordering};

const TOO_MANY_BLOCKS: &str = "more blocks of triangles than can be numbered";

/// What the leaves of a tree hold.
#[derive(Clone, Copy)]
pub(super) enum Contents<'a> {
    Primitives(&'a Geometry),
    Instances,
}

impl Cut {
    /// How many blocks of triangles there will be.
    pub(super) fn block_count(&self) -> usize {
        if !self.blocks.is_empty() {
            return self.blocks.len();
        }
        let is_block = |at: &&u32| {
            let count = self.tree.nodes[**at as usize].count;
            count & BvhNode::SPHERES == 0
        };
        self.leaves.iter().filter(is_block).count()
    }

    /// Appends everything to the hierarchy; returns what the root is as a child, and what is farthest in its blocks.
    pub(super) fn emit(mut self, scene: &SceneGeometry, contents: Contents, out: &mut Bvh8) -> (Child, f32) {
        let base = out.nodes.len() as Child;
        if !self.blocks.is_empty() {
            self.append_blocks(&mut out.blocks);
        } else if self.tree.order.is_empty() {
            return (EMPTY, 0.0);
        } else {
            self.number_leaves(scene, contents, out);
            if let Contents::Primitives(geometry) = contents {
                let vertices = &scene.triangles()[geometry.first_triangle as usize..];
                self.farthest = self.emit_blocks(vertices, &mut out.blocks);
            }
        }
        let has_avx2 = has_avx2();
        // SAFETY: written places: `fill_nodes` goes through all places.
        unsafe {
            fill_in_parallel(&mut out.nodes, self.wide.len(), |first, room| match has_avx2 {
                // SAFETY: instruction set: the CPU has been asked for AVX2 and FMA.
                #[cfg(target_arch = "x86_64")]
                true => self.fill_nodes_avx2(first, room, base),
                _ => self.fill_nodes(first, room, base),
            });
        }
        let root = self.children[0];
        (if root & LEAF == 0 { root + base } else { root }, self.farthest)
    }

    /// Blocks that are packed already go where they belong.
    fn append_blocks(&mut self, blocks: &mut Vec<TriangleBlock>) {
        let first_block = blocks.len() as Child;
        assert!(blocks.len() + self.blocks.len() <= PLACE as usize, "{TOO_MANY_BLOCKS}");
        for &at in &self.leaves {
            self.children[at as usize] = LEAF | (first_block + self.tree.nodes[at as usize].first);
        }
        if blocks.capacity() == 0 {
            *blocks = std::mem::take(&mut self.blocks);
        } else {
            blocks.append(&mut std::mem::take(&mut self.blocks));
        }
    }

    /// From numbers of leaves to what they are. What is left of `leaves` are blocks.
    fn number_leaves(&mut self, scene: &SceneGeometry, contents: Contents, out: &mut Bvh8) {
        let first_block = out.blocks.len() as Child;
        let mut blocks = 0;
        for k in 0..self.leaves.len() {
            let at = self.leaves[k];
            let node = &self.tree.nodes[at as usize];
            let first = self.tree.order[node.first as usize];
            self.children[at as usize] = match contents {
                Contents::Instances => LEAF | INSTANCE | (first + 1),
                Contents::Primitives(geometry) if node.count & BvhNode::SPHERES != 0 => {
                    let number = geometry.first_sphere + (first - geometry.triangle_count);
                    out.spheres.push(scene.spheres()[number as usize]);
                    out.sphere_primitives.push(first);
                    LEAF | SPHERE | (out.spheres.len() as Child - 1)
                }
                Contents::Primitives(_) => {
                    self.leaves[blocks as usize] = at;
                    blocks += 1;
                    LEAF | (first_block + blocks - 1)
                }
            };
        }
        self.leaves.truncate(blocks as usize);
        assert!(first_block + blocks <= PLACE, "{TOO_MANY_BLOCKS}");
    }

    fn emit_blocks(&self, vertices: &[[Vec3; 3]], blocks: &mut Vec<TriangleBlock>) -> f32 {
        let has_avx2 = has_avx2();
        // Numbers that are not below 0 are in the order of their bits.
        let farthest = AtomicU32::new(0);
        // SAFETY: written places: `fill` goes through all places.
        unsafe {
            fill_in_parallel(blocks, self.leaves.len(), |first, room| {
                let part = match has_avx2 {
                    // SAFETY: instruction set: the CPU has been asked for AVX2 and FMA.
                    #[cfg(target_arch = "x86_64")]
                    true => self.fill_avx2(first, room, vertices),
                    _ => self.fill::<false>(first, room, vertices),
                };
                farthest.fetch_max(part.to_bits(), Ordering::Relaxed);
            });
        }
        f32::from_bits(farthest.into_inner())
    }

    /// [`Cut::fill`], with fused multiply-adds as instructions.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn fill_avx2(
        &self,
        first: usize,
        room: &mut [MaybeUninit<TriangleBlock>],
        vertices: &[[Vec3; 3]],
    ) -> f32 {
        // SAFETY: instruction set: it has been switched on here.
        unsafe { self.fill::<true>(first, room, vertices) }
    }

    /// Returns what is farthest in these blocks.
    ///
    /// # Safety
    /// With `AVX2` the CPU must have AVX2 and FMA.
    #[inline(always)]
    unsafe fn fill<const AVX2: bool>(
        &self,
        first: usize,
        room: &mut [MaybeUninit<TriangleBlock>],
        vertices: &[[Vec3; 3]],
    ) -> f32 {
        let mut farthest = 0.0f32;
        for (place, &at) in room.iter_mut().zip(&self.leaves[first..]) {
            let node = &self.tree.nodes[at as usize];
            let order = &self.tree.order[node.first as usize..][..node.count as usize];
            for &next in self.tree.order.iter().skip(node.first as usize + AHEAD).take(order.len()) {
                prefetch(vertices, next as usize);
            }
            // SAFETY: instruction set: promised to this function.
            let packed =
                unsafe { pack::<AVX2>(place, lanes(order.len(), |k| order[k]), order.len(), vertices) };
            farthest = farthest.max(packed.farthest);
        }
        farthest
    }

    /// [`Cut::fill_nodes`], eight children at a time.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn fill_nodes_avx2(&self, first: usize, room: &mut [MaybeUninit<Node8>], base: Child) {
        self.fill_nodes(first, room, base);
    }

    #[inline(always)]
    fn fill_nodes(&self, first: usize, room: &mut [MaybeUninit<Node8>], base: Child) {
        for (place, &wide) in room.iter_mut().zip(&self.wide[first..]) {
            self.fill_node(place.write(Node8::EMPTY), wide, base);
        }
    }

    #[inline(always)]
    fn fill_node(&self, node: &mut Node8, wide: u32, base: Child) {
        let (children, count) = self.children_of(wide);
        // Rays that look for any hit take children as they stand, the last first: those with much surface for what there
        // is to search come first. Of sponza, that saves such rays a fourth of their steps.
        let mut keys = [u64::MAX; 8];
        for (k, &at) in children[..count].iter().enumerate() {
            let child = &self.tree.nodes[at as usize];
            let key = child.bounds().half_area().min(f32::MAX) / self.leaves_of(child) as f32;
            // Areas are not below 0, so their bits are in the same order. Equal ones stand as they are.
            keys[k] = u64::from(key.to_bits()) << 32 | k as u64;
        }
        network(|i, j| (keys[i], keys[j]) = (keys[i].min(keys[j]), keys[i].max(keys[j])));
        for (k, key) in keys[..count].iter().enumerate() {
            let at = children[*key as usize % 8];
            let inner = &self.tree.nodes[at as usize];
            let child = self.children[at as usize];
            node.children[k] = if child & LEAF == 0 { child + base } else { child };
            for axis in 0..3 {
                node.planes[2 * axis][k] = inner.min[axis];
                node.planes[2 * axis + 1][k] = inner.max[axis];
            }
        }
        node.orders = orders(node);
    }
}

/// Beyond this, middles of boxes are all the same.
const FAR: f32 = 1e37;

/// The orders in which rays of each octant should meet the children, by the middles of their boxes along the diagonal
/// of the octant.
#[inline(always)]
pub(super) fn orders(node: &Node8) -> [u32; 8] {
    let mut middles = [[0.0f32; 8]; 3];
    for axis in 0..3 {
        for k in 0..8 {
            // Limited, so that no sum of three is infinite or NaN, whatever the boxes.
            let middle = node.planes[2 * axis][k] + node.planes[2 * axis + 1][k];
            middles[axis][k] = clamp(middle, -FAR, FAR);
        }
    }
    // For each child, the keys of four octants; each of these and the opposite one have opposite orders.
    let mut keys = [[0i32; 4]; 8];
    let mut empty = 0;
    for k in 0..8 {
        let (x, y, z) = (middles[0][k], middles[1][k], middles[2][k]);
        let is_empty = node.children[k] == EMPTY;
        empty += u32::from(is_empty);
        for octant in 0..4 {
            let sum = x * [1.0, -1.0, 1.0, -1.0][octant] + y * [1.0, 1.0, -1.0, -1.0][octant] + z;
            // As whole numbers in the order of the floats, all different: the last three bits are the place.
            let bits = sum.to_bits() as i32;
            let ordered = bits ^ (((bits >> 31) as u32) >> 1) as i32;
            let ordered = if is_empty { i32::MAX } else { ordered };
            keys[k][octant] = (ordered & !7) | (7 - k as i32);
        }
    }
    // The largest first.
    network(|i, j| {
        for octant in 0..4 {
            let (a, b) = (keys[i][octant], keys[j][octant]);
            (keys[i][octant], keys[j][octant]) = (a.max(b), a.min(b));
        }
    });
    let (mut orders, mut reversed) = ([0; 8], [0; 4]);
    for k in 0..8 {
        for octant in 0..4 {
            let child = !keys[k][octant] as u32 & 7;
            orders[octant] |= child << (3 * k);
            reversed[octant] |= child << (3 * (7 - k));
        }
    }
    // Empty children come first in both.
    let (shift, first) = (3 * empty, (1u32 << (3 * empty)) - 1);
    for octant in 0..4 {
        orders[7 - octant] = (reversed[octant] << shift) & 0xFF_FFFF & !first | orders[octant] & first;
    }
    orders
}

/// Sorts eight, by 19 comparisons of pairs that are always the same (Batcher's network, improved): `order(i, j)` puts
/// two into their order, i < j. No branch depends on data.
#[inline(always)]
fn network(mut order: impl FnMut(usize, usize)) {
    // Written out, so that places are constants and what is sorted stays in registers.
    order(0, 2);
    order(1, 3);
    order(4, 6);
    order(5, 7);
    order(0, 4);
    order(1, 5);
    order(2, 6);
    order(3, 7);
    order(0, 1);
    order(2, 3);
    order(4, 5);
    order(6, 7);
    order(2, 4);
    order(3, 5);
    order(1, 4);
    order(3, 6);
    order(1, 2);
    order(3, 4);
    order(5, 6);
}

#[cfg(test)]
mod tests {
    use super::network;

    #[test]
    fn the_network_sorts() {
        // By zeros and ones: what sorts these sorts everything.
        for bits in 0..256 {
            let mut keys = [0, 1, 2, 3, 4, 5, 6, 7].map(|k| bits >> k & 1);
            network(|i, j| (keys[i], keys[j]) = (keys[i].min(keys[j]), keys[i].max(keys[j])));
            assert!(keys.is_sorted(), "{bits}");
        }
    }
}
