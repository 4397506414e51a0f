//! Wide nodes, blocks of triangles and spheres, written where they belong.

use super::collapse::Cut;
use super::{Bvh8, Child, EMPTY, INSTANCE, LEAF, Node8, PLACE, SPHERE, TriangleBlock};
use crate::bvh::fill_in_parallel;
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
        // SAFETY: `fill` goes through all places.
        unsafe {
            fill_in_parallel(&mut out.nodes, self.wide.len(), |first, room| {
                for (place, &wide) in room.iter_mut().zip(&self.wide[first..]) {
                    place.write(self.node(wide, base));
                }
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
            for (lane, &primitive) in order.iter().enumerate() {
                block.set(lane % 4, &PackedTriangle::new(vertices[primitive as usize], primitive));
            }
        }
    }

    fn node(&self, wide: u32, base: Child) -> Node8 {
        let (children, count) = self.children_of(wide);
        let mut node = Node8::EMPTY;
        for (k, &at) in children[..count].iter().enumerate() {
            let inner = &self.tree.nodes[at as usize];
            let child = self.children[at as usize];
            node.children[k] = if child & LEAF == 0 { child + base } else { child };
            for axis in 0..3 {
                node.planes[2 * axis][k] = inner.min[axis];
                node.planes[2 * axis + 1][k] = inner.max[axis];
            }
        }
        node.orders = orders(&node);
        node
    }
}

/// Beyond this, middles of boxes are all the same.
const FAR: f32 = 1e37;

/// The orders in which rays of each octant should meet the children, by the middles of their boxes along the diagonal
/// of the octant.
pub(super) fn orders(node: &Node8) -> [u32; 8] {
    let middles: [[f32; 8]; 3] = std::array::from_fn(|axis| {
        // Limited, so that no sum of three is infinite or NaN, whatever the boxes.
        std::array::from_fn(|k| clamp(node.planes[2 * axis][k] + node.planes[2 * axis + 1][k], -FAR, FAR))
    });
    let empty = node.children.iter().filter(|&&c| c == EMPTY).count() as u32;
    let mut orders = [0; 8];
    // An octant and the opposite one have opposite orders.
    for octant in 0..4 {
        let signed = |x: f32, bit: u32| if octant >> bit & 1 == 1 { -x } else { x };
        let keys: [f32; 8] = std::array::from_fn(|k| {
            let key = signed(middles[0][k], 0) + signed(middles[1][k], 1) + middles[2][k];
            if node.children[k] == EMPTY { f32::INFINITY } else { key }
        });
        // How many are farther: comparing all pairs needs no branches. Equal ones keep their order.
        let mut farther = [0u32; 8];
        for j in 0..8 {
            for k in 0..8 {
                let before = if j < k { keys[j] >= keys[k] } else { keys[j] > keys[k] };
                farther[k] += u32::from(before);
            }
        }
        for k in 0..8 {
            let place = farther[k];
            let opposite = if place < empty { place } else { empty + 7 - place };
            orders[octant as usize] |= (k as u32) << (3 * place);
            orders[7 - octant as usize] |= (k as u32) << (3 * opposite);
        }
    }
    orders
}
