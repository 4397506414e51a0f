//! kd-tree: the nodes, and the scalar traversal (Havran 2000, "Heuristic ray shooting algorithms", algorithm TA-B rec).

use super::candidates::{Placement, PrimitivesView, trusted};
use super::cell_ray::{CellRay, in_time};
use super::references::{Mailbox, References};
use super::search::Search;
use super::two_level::{InstanceTreeView, SearchScene, answer_queries};
use super::{Stack, Tracer, Work};
use crate::geometry::Bounds;
use crate::intersect::LocalRay;
use crate::math::{max, min};
use crate::ray::{Hit, Ray, RayFilter};

/// Builders keep trees at most this deep.
pub const MAX_KD_DEPTH: usize = 48;

/// A node of 8 bytes. The lower child of an inner node is the next node in the array.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(8))]
pub struct KdNode {
    /// Inner node: bits of the f32 coordinate of the plane. Leaf: number of its first reference.
    pub plane_or_first: u32,
    /// Lowest two bits: 0, 1, 2 for planes across x, y, z, and 3 for leaves. The rest: number of the upper child, or how
    /// many references the leaf has.
    pub kind: u32,
}

impl KdNode {
    /// An inner node. `upper` is the number of the upper child, below 2^30.
    pub fn inner(axis: usize, plane: f32, upper: u32) -> KdNode {
        KdNode { plane_or_first: plane.to_bits(), kind: upper << 2 | axis as u32 }
    }

    /// A leaf of `count` references, below 2^30.
    pub fn leaf(first: u32, count: u32) -> KdNode {
        KdNode { plane_or_first: first, kind: count << 2 | 3 }
    }

    /// Whether it has no children.
    #[inline(always)]
    pub fn is_leaf(&self) -> bool {
        self.kind & 3 == 3
    }

    /// Number of the upper child, or of a leaf's references.
    #[inline(always)]
    pub fn upper_or_count(&self) -> u32 {
        self.kind >> 2
    }
}

/// The tree of one geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct KdRoot {
    /// Box of all primitives, padded as cells' primitives are.
    pub bounds: Bounds,
    /// Number of the root, or [`crate::material::NONE`] for a geometry without primitives.
    pub node: u32,
}

/// A tree over every geometry, and one over the instances.
#[derive(Clone, Copy, Debug)]
pub struct KdTreeView<'a> {
    /// Nodes of all trees.
    pub nodes: &'a [KdNode],
    /// For each geometry, its tree.
    pub roots: &'a [KdRoot],
    /// What leaves hold: numbers of triangles, or of spheres with [`super::SPHERE_REFERENCE`].
    pub references: &'a [u32],
    /// Finds instances.
    pub instances: InstanceTreeView<'a>,
    /// Primitives, in any order.
    pub primitives: PrimitivesView<'a>,
}

/// Traverses a [`KdTreeView`].
#[derive(Clone, Copy, Debug)]
pub struct KdTreeTracer<'a, C> {
    /// The tree.
    tree: KdTreeView<'a>,
    /// Told what is done: nodes are those entered, inner ones and leaves.
    pub work: C,
}

impl<'a, C: Work> KdTreeTracer<'a, C> {
    /// Over trees whose numbers hold together.
    ///
    /// # Safety
    /// The view is [closed](crate::hierarchy#closed-views).
    #[inline(always)]
    pub unsafe fn new(tree: KdTreeView<'a>, work: C) -> Self {
        KdTreeTracer { tree, work }
    }
}

impl<C: Work> SearchScene for KdTreeTracer<'_, C> {
    #[inline(always)]
    fn primitives(&self) -> &PrimitivesView<'_> {
        &self.tree.primitives
    }

    /// Visits the cells that the ray passes in their order, up to the best hit.
    #[inline(always)]
    fn search_geometry(
        &self,
        geometry: u32,
        ray: &LocalRay,
        placement: &Placement<'_>,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        let tree = &self.tree;
        let root = trusted(tree.roots, geometry);
        if root.node == crate::material::NONE {
            return false;
        }
        let cells = CellRay::new(ray, &root.bounds);
        let Some((mut enter, mut leave)) = cells.enter(&root.bounds, ray.t_min, search.t_max()) else {
            return false;
        };
        let mut references = References {
            primitives: &tree.primitives,
            references: tree.references,
            ray,
            placement,
            filter,
            work: &self.work,
            mailbox: Some(Mailbox::new()),
        };
        let mut storage = Stack::<(u32, f32, f32), MAX_KD_DEPTH>::storage();
        let mut stack = Stack::new(&mut storage);
        let mut number = root.node;
        loop {
            let node = trusted(tree.nodes, number);
            self.work.nodes(1);
            if !node.is_leaf() {
                let (axis, plane) = ((node.kind & 3) as usize, f32::from_bits(node.plane_or_first));
                let (earliest, latest) = (cells.earliest(axis, plane), cells.latest(axis, plane));
                let (lower, upper) = (number + 1, node.upper_or_count());
                let (first, second) = if cells.inverse[axis] < 0.0 { (upper, lower) } else { (lower, upper) };
                // Unknown planes, NaN, rule out neither side: max and min pass them over.
                if latest < enter {
                    number = second;
                } else {
                    let from = max(earliest, enter);
                    if (from <= leave) & in_time(from, search.t_max()) {
                        // SAFETY: a walk puts aside one node a level, and builders keep trees below MAX_KD_DEPTH levels.
                        unsafe { stack.push((second, from, leave)) };
                        leave = min(latest, leave);
                    }
                    number = first;
                }
                continue;
            }
            if references.search(node.plane_or_first, node.upper_or_count(), search) {
                return true;
            }
            loop {
                match stack.pop() {
                    None => return false,
                    Some((next, from, to)) if in_time(from, search.t_max()) => {
                        (number, enter, leave) = (next, from, to);
                        break;
                    }
                    Some(_) => {}
                }
            }
        }
    }

    #[inline(always)]
    fn search_instances(
        &self,
        world_ray: Option<&LocalRay>,
        ray: &Ray,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        self.tree.instances.search(self, &self.work, world_ray, ray, filter, search)
    }
}

answer_queries!(KdTreeTracer);
