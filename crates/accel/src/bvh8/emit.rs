//! Wide nodes, blocks of triangles and spheres, written where they belong.

use super::collapse::Cut;
use super::{Bvh8, Child, EMPTY, INSTANCE, LEAF, Node8, PLACE, SPHERE, TriangleBlock};
use crate::bvh::{AHEAD, fill_in_parallel, prefetch};
use crate::{SceneGeometry, SimdLevel};
use eosphor_core::geometry::Geometry;
use eosphor_core::hierarchy::BvhNode;
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::math::{Vec3, clamp};
use std::mem::MaybeUninit;

/// What the leaves of a tree hold.
#[derive(Clone, Copy)]
pub(super) enum Contents<'a> {
    Primitives(&'a Geometry),
    Instances,
}

impl Cut {
    /// How many blocks of triangles there will be.
    pub(super) fn block_count(&self) -> usize {
        let is_block = |at: &&u32| {
            let count = self.tree.nodes[**at as usize].count;
            count & BvhNode::SPHERES == 0
        };
        self.leaves.iter().filter(is_block).count()
    }

    /// Appends everything to the hierarchy; returns what the root is as a child.
    pub(super) fn emit(mut self, scene: &SceneGeometry, contents: Contents, out: &mut Bvh8) -> Child {
        if self.tree.order.is_empty() {
            return EMPTY;
        }
        let base = out.nodes.len() as Child;
        self.number_leaves(scene, contents, out);
        if let Contents::Primitives(geometry) = contents {
            self.emit_blocks(&scene.triangles[geometry.first_triangle as usize..], &mut out.blocks);
        }
        let level = SimdLevel::best();
        // SAFETY: `fill_nodes` goes through all places.
        unsafe {
            fill_in_parallel(&mut out.nodes, self.wide.len(), |first, room| match level {
                // SAFETY: the CPU has these features.
                #[cfg(target_arch = "x86_64")]
                SimdLevel::Avx2 | SimdLevel::Avx512 => self.fill_nodes_avx2(first, room, base),
                _ => self.fill_nodes(first, room, base),
            });
        }
        let root = self.children[0];
        if root & LEAF == 0 { root + base } else { root }
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
                    out.spheres.push(scene.spheres[number as usize]);
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
        assert!(first_block + blocks <= PLACE, "more blocks of triangles than can be numbered");
    }

    fn emit_blocks(&self, vertices: &[[Vec3; 3]], blocks: &mut Vec<TriangleBlock>) {
        let level = SimdLevel::best();
        // SAFETY: `fill` goes through all places.
        unsafe {
            fill_in_parallel(blocks, self.leaves.len(), |first, room| match level {
                // SAFETY: the CPU has these features.
                #[cfg(target_arch = "x86_64")]
                SimdLevel::Avx2 | SimdLevel::Avx512 => self.fill_avx2(first, room, vertices),
                _ => self.fill(first, room, vertices),
            });
        }
    }

    /// [`Cut::fill`], with fused multiply-adds as instructions.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn fill_avx2(&self, first: usize, room: &mut [MaybeUninit<TriangleBlock>], vertices: &[[Vec3; 3]]) {
        self.fill(first, room, vertices);
    }

    #[inline(always)]
    fn fill(&self, first: usize, room: &mut [MaybeUninit<TriangleBlock>], vertices: &[[Vec3; 3]]) {
        for (place, &at) in room.iter_mut().zip(&self.leaves[first..]) {
            let node = &self.tree.nodes[at as usize];
            let block = place.write(TriangleBlock::EMPTY);
            let order = &self.tree.order[node.first as usize..][..node.count as usize];
            for &next in self.tree.order.iter().skip(node.first as usize + AHEAD).take(order.len()) {
                prefetch(vertices, next as usize);
            }
            for (lane, &primitive) in order.iter().enumerate() {
                block.set(lane % 4, &PackedTriangle::new(vertices[primitive as usize], primitive));
            }
        }
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
        let mut keys = [f32::INFINITY; 8];
        for (key, &at) in keys.iter_mut().zip(&children[..count]) {
            *key =
                self.tree.nodes[at as usize].bounds().half_area().min(f32::MAX) / self.leaves_of(at) as f32;
        }
        let mut places = [0usize; 8];
        for j in 0..8 {
            for k in 0..8 {
                // Equal ones stand as they are.
                places[k] += usize::from((keys[j] < keys[k]) | ((keys[j] == keys[k]) & (j < k)));
            }
        }
        for (&at, k) in children[..count].iter().zip(places) {
            let k = k % 8;
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
    let mut empty = 0;
    for k in 0..8 {
        empty += u32::from(node.children[k] == EMPTY);
    }
    let mut orders = [0; 8];
    // An octant and the opposite one have opposite orders.
    for octant in 0..4usize {
        let sign = |bit: usize| if octant >> bit & 1 == 1 { -1.0f32 } else { 1.0 };
        let (x, y) = (sign(0), sign(1));
        // As whole numbers in the order of the floats, all different: the last three bits are the place.
        let mut keys = [0i32; 8];
        for k in 0..8 {
            let bits = (middles[0][k] * x + middles[1][k] * y + middles[2][k]).to_bits() as i32;
            let ordered = bits ^ (((bits >> 31) as u32) >> 1) as i32;
            let ordered = if node.children[k] == EMPTY { i32::MAX } else { ordered };
            keys[k] = (ordered & !7) | (7 - k as i32);
        }
        // How many are farther: comparing all pairs needs no branches.
        let mut farther = [0u32; 8];
        for j in 0..8 {
            for k in 0..8 {
                farther[k] += u32::from(keys[j] > keys[k]);
            }
        }
        let (mut order, mut opposite) = (0, 0);
        for k in 0..8 {
            let place = farther[k];
            let reverse = if place < empty { place } else { empty + 7 - place };
            order |= (k as u32) << (3 * place);
            opposite |= (k as u32) << (3 * reverse);
        }
        orders[octant] = order;
        orders[7 - octant] = opposite;
    }
    orders
}
