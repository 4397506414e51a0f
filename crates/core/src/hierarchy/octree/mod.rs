//! Octree: the nodes, two scalar traversals, and one of shadow rays together.
//!
//! Octants are numbered 4 for the upper half of x, plus 2 for that of y, plus 1 for that of z.

mod basic;
mod packet;
mod parametric;

pub use basic::OctreeTracer;
pub use parametric::OctreeParametricTracer;

use super::PrimitivesView;
use super::two_level::InstanceTreeView;
use crate::geometry::Bounds;

/// Builders keep trees at most this deep.
pub const MAX_OCTREE_DEPTH: usize = 16;

/// A node of 8 bytes. Its cell is not stored: it follows from the root's by halving.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(8))]
pub struct OctreeNode {
    /// Inner node: number of the first child; the others follow in the order of their octants, and octants that hold
    /// nothing have no node. Leaf: number of its first reference.
    pub first: u32,
    /// Inner node: [`OctreeNode::INNER`] and bit o for each octant o that has a node. Leaf: how many references it has.
    pub octants_or_count: u32,
}

impl OctreeNode {
    /// Set in inner nodes.
    pub const INNER: u32 = 1 << 31;

    /// Whether it has children.
    #[inline(always)]
    pub fn is_inner(&self) -> bool {
        self.octants_or_count & OctreeNode::INNER != 0
    }

    /// Number of the node of an octant that has one.
    #[inline(always)]
    pub fn child(&self, octant: u32) -> u32 {
        self.first + (self.octants_or_count & ((1 << octant) - 1)).count_ones()
    }
}

/// The tree of one geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct OctreeRoot {
    /// The root's cell.
    pub bounds: Bounds,
    /// Number of the root, or [`crate::material::NONE`] for a geometry without primitives.
    pub node: u32,
}

/// A tree over every geometry, and one over the instances.
#[derive(Clone, Copy, Debug)]
pub struct OctreeView<'a> {
    /// Nodes of all trees.
    pub nodes: &'a [OctreeNode],
    /// For each geometry, its tree.
    pub roots: &'a [OctreeRoot],
    /// What leaves hold: numbers of triangles, or of spheres with [`super::SPHERE_REFERENCE`].
    pub references: &'a [u32],
    /// Finds instances.
    pub instances: InstanceTreeView<'a>,
    /// Primitives, in any order.
    pub primitives: PrimitivesView<'a>,
}
