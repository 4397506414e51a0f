//! The octree, traversed as PG1 does: every octant that the ray hits is visited, and every primitive in them tested.

use super::{MAX_OCTREE_DEPTH, OctreeNode, OctreeView};
use crate::geometry::Bounds;
use crate::hierarchy::candidates::{Placement, PrimitivesView, trusted};
use crate::hierarchy::references::References;
use crate::hierarchy::search::Search;
use crate::hierarchy::two_level::{SearchScene, answer_queries};
use crate::hierarchy::{Stack, Tracer, Work};
use crate::intersect::{LocalRay, Slab};
use crate::math::{Vec3, vec3};
use crate::ray::{Hit, Ray, RayFilter};

/// Cells are grown by this times the largest coordinate of the root's: over the rounding of their corners, one unit in
/// the last place a level, so that the grown cell holds the exact one.
const CORNER_ROUNDING: f32 = 1.0 / 524_288.0;

/// Traverses an [`OctreeView`] without order: the boxes of all children are tested, all leaves that the ray hits are
/// searched, and no hit ends the search, not even where any hit will do.
#[derive(Clone, Copy, Debug)]
pub struct OctreeTracer<'a, C> {
    /// The tree.
    tree: OctreeView<'a>,
    /// Told what the traversal does ([`Work`]): each cell tested counts as one node.
    pub work: C,
}

/// An inner node and its octants still to be visited.
#[derive(Clone, Copy)]
struct Frame {
    node: u32,
    octants: u32,
    corner: Vec3,
    half: Vec3,
}

impl Frame {
    /// Lower corner of an octant's cell.
    #[inline(always)]
    fn corner_of(&self, octant: u32) -> Vec3 {
        let part = |bit: u32, half: f32| if octant & bit != 0 { half } else { 0.0 };
        self.corner + vec3(part(4, self.half.x), part(2, self.half.y), part(1, self.half.z))
    }
}

impl<'a, C: Work> OctreeTracer<'a, C> {
    /// Over trees whose numbers hold together.
    ///
    /// # Safety
    /// The view is [closed](crate::hierarchy#closed-views).
    #[inline(always)]
    pub unsafe fn new(tree: OctreeView<'a>, work: C) -> Self {
        OctreeTracer { tree, work }
    }
}

impl<C: Work> OctreeTracer<'_, C> {
    /// Those octants of a node that the ray hits, as bits.
    #[inline(always)]
    fn octants_hit(&self, node: &OctreeNode, frame: &Frame, ray: &LocalRay, margin: f32, t_max: f32) -> u32 {
        self.work.nodes((node.octants_or_count & 0xFF).count_ones());
        let (mut left, mut hit) = (node.octants_or_count & 0xFF, 0);
        while left != 0 {
            let octant = left.trailing_zeros();
            left &= left - 1;
            let min = frame.corner_of(octant);
            let cell = Bounds { min, max: min + frame.half }.padded(margin);
            let (near, far) = ray.slab.interval(&cell, ray.t_min);
            hit |= (Slab::passes(near, far, t_max) as u32) << octant;
        }
        hit
    }
}

impl<C: Work> SearchScene for OctreeTracer<'_, C> {
    #[inline(always)]
    fn primitives(&self) -> &PrimitivesView<'_> {
        &self.tree.primitives
    }

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
        let t_max = search.t_max();
        let bounds = root.bounds;
        let margin = CORNER_ROUNDING * bounds.min.abs().max(bounds.max.abs()).max_component();
        let (near, far) = ray.slab.interval(&bounds.padded(margin), ray.t_min);
        self.work.nodes(1);
        if !Slab::passes(near, far, t_max) {
            return false;
        }
        let mut references = References {
            primitives: &tree.primitives,
            references: tree.references,
            ray,
            placement,
            filter,
            work: &self.work,
            mailbox: None,
        };
        let mut storage = Stack::<Frame, MAX_OCTREE_DEPTH>::storage();
        let mut stack = Stack::new(&mut storage);
        let mut ends = false;
        let (mut number, mut corner) = (root.node, bounds.min);
        let mut half = (bounds.max - bounds.min) * 0.5;
        loop {
            let node = trusted(tree.nodes, number);
            if node.is_inner() {
                let mut frame = Frame { node: number, octants: 0, corner, half };
                frame.octants = self.octants_hit(node, &frame, ray, margin, t_max);
                // SAFETY: one frame a level of inner nodes, and builders keep trees at most MAX_OCTREE_DEPTH deep.
                unsafe { stack.push(frame) };
            } else {
                let mut k = node.first;
                while k < node.first + node.octants_or_count {
                    ends |= references.search(k, 1, search);
                    k += 1;
                }
            }
            loop {
                let Some(frame) = stack.top_mut() else { return ends };
                if frame.octants == 0 {
                    stack.pop();
                    continue;
                }
                let octant = frame.octants.trailing_zeros();
                frame.octants &= frame.octants - 1;
                corner = frame.corner_of(octant);
                half = frame.half * 0.5;
                number = trusted(tree.nodes, frame.node).child(octant);
                break;
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

answer_queries!(OctreeTracer);
