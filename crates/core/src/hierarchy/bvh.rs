//! Bounding volume hierarchy with two children a node: the nodes, and the scalar traversal.

use super::candidates::{Placement, PrimitivesView, trusted};
use super::far::{FarRay, is_far};
use super::moved::Moved;
use super::search::{Any, Search};
use super::two_level::{InstanceTreeView, SearchScene, answer_queries};
use super::{Stack, Tracer, Work};
use crate::geometry::Bounds;
use crate::intersect::{LocalRay, Slab};
use crate::math::Vec3;
use crate::out_of_line::IS_SMALL;
use crate::ray::{Hit, Ray, RayFilter};

/// Builders keep trees at most this deep, so that traversals can do with a stack of this size.
pub const MAX_BVH_DEPTH: usize = 64;

/// A node of 32 bytes. The two children of an inner node are neighbours in the array.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct BvhNode {
    /// Smallest coordinates of what is inside, with slack.
    pub min: Vec3,
    /// Inner node: number of the first child. Leaf: number of the first primitive (or instance) in its array.
    pub first: u32,
    /// Largest coordinates of what is inside, with slack.
    pub max: Vec3,
    /// 0 for inner nodes; else the number of primitives, with [`BvhNode::SPHERES`] where they are spheres.
    pub count: u32,
}

impl BvhNode {
    /// Set in [`BvhNode::count`] of leaves that hold spheres.
    pub const SPHERES: u32 = 1 << 31;

    /// A leaf that holds nothing. (A box turned inside out would not do: the slab test sorts its planes.)
    pub const EMPTY: BvhNode =
        BvhNode { min: Vec3::ZERO, first: 0, max: Vec3::ZERO, count: BvhNode::SPHERES };

    /// Its box.
    #[inline(always)]
    pub fn bounds(&self) -> Bounds {
        Bounds { min: self.min, max: self.max }
    }

    /// Whether it has children.
    #[inline(always)]
    pub fn is_inner(&self) -> bool {
        self.count == 0
    }
}

/// A hierarchy over every geometry, and one over the instances.
#[derive(Clone, Copy, Debug)]
pub struct BvhView<'a> {
    /// Nodes of all trees.
    pub nodes: &'a [BvhNode],
    /// For each geometry, the number of its root.
    pub roots: &'a [u32],
    /// Finds instances.
    pub instances: InstanceTreeView<'a>,
    /// Primitives, in the order of the leaves.
    pub primitives: PrimitivesView<'a>,
}

/// Traverses a [`BvhView`].
#[derive(Clone, Copy, Debug)]
pub struct BvhTracer<'a, C> {
    /// The hierarchy.
    bvh: BvhView<'a>,
    /// Told what is done.
    pub work: C,
}

/// A node put aside, and where the ray enters it.
type Entry = (u32, f32);

/// What a walk does at a leaf. (A trait and not a closure, because closures cannot be made to be inlined, and what is
/// not inlined is compiled without the SIMD features of its caller.)
pub(super) trait VisitLeaf {
    /// `true` ends the walk.
    fn visit(&mut self, leaf: &BvhNode, search: &mut impl Search) -> bool;
}

/// Leaves of triangles or spheres.
struct PrimitiveLeaves<'a, 't, C> {
    tracer: &'a BvhTracer<'t, C>,
    ray: &'a LocalRay,
    placement: &'a Placement<'a>,
    filter: &'a RayFilter,
}

impl<C: Work> VisitLeaf for PrimitiveLeaves<'_, '_, C> {
    #[inline(always)]
    fn visit(&mut self, leaf: &BvhNode, search: &mut impl Search) -> bool {
        let primitives = &self.tracer.bvh.primitives;
        let count = leaf.count & !BvhNode::SPHERES;
        self.tracer.work.primitives(count);
        if leaf.count & BvhNode::SPHERES == 0 {
            primitives.search_triangles(leaf.first, count, self.ray, self.placement, self.filter, search)
        } else {
            primitives.search_spheres(leaf.first, count, self.ray, self.placement, search)
        }
    }
}

impl<'a, C: Work> BvhTracer<'a, C> {
    /// Over trees whose numbers hold together.
    ///
    /// # Safety
    /// The view is [closed](crate::hierarchy#closed-views).
    #[inline(always)]
    pub unsafe fn new(bvh: BvhView<'a>, work: C) -> Self {
        BvhTracer { bvh, work }
    }
}

impl<C: Work> BvhTracer<'_, C> {
    /// [`Tracer::occluded`] by what instances place, the world itself left out.
    #[inline(always)]
    pub fn occluded_by_instances(&self, ray: &Ray, filter: &RayFilter) -> bool {
        let mut search = Any::new(ray.t_max, 0.0);
        let primitives = &self.bvh.primitives;
        let world_ray = LocalRay::of(ray, None, trusted(primitives.geometries, 0).extent);
        if primitives.instances.len() > 1 && !world_ray.t_min.is_nan() {
            self.search_instances(None, ray, filter, &mut search);
        }
        search.found
    }
}

impl<C: Work> SearchScene for BvhTracer<'_, C> {
    #[inline(always)]
    fn primitives(&self) -> &PrimitivesView<'_> {
        &self.bvh.primitives
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
        let (nodes, root) = (self.bvh.nodes, *trusted(self.bvh.roots, geometry));
        let bounds = trusted(nodes, root).bounds();
        // A ray with numbers out of range hits nothing, from wherever it is looked at.
        let is_far = is_far(ray.origin, bounds.extent()) & !ray.t_min.is_nan();
        if !is_far & !IS_SMALL {
            let mut leaves = PrimitiveLeaves { tracer: self, ray, placement, filter };
            return walk(nodes, root, &ray.slab, ray.t_min, &self.work, search, &mut leaves);
        }
        let (mut ray, mut from) = (*ray, None);
        if is_far {
            let (map, _) = self.bvh.primitives.space(placement.instance);
            let Some(far) = FarRay::new(placement.world_ray, map, &bounds) else { return false };
            (ray, from) = (far.ray, Some(far.from));
        }
        let mut leaves = PrimitiveLeaves { tracer: self, ray: &ray, placement, filter };
        let mut search = Moved::perhaps(search, from);
        walk(nodes, root, &ray.slab, ray.t_min, &self.work, &mut search, &mut leaves)
    }

    #[inline(always)]
    fn search_instances(
        &self,
        world_ray: Option<&LocalRay>,
        ray: &Ray,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        self.bvh.instances.search(self, &self.work, world_ray, ray, filter, search)
    }
}

answer_queries!(BvhTracer);

/// Visits the leaves that the ray enters, the nearer child first. A node is left out only when the ray enters it
/// beyond the best hit, never at equality: there a tie may wait. `true` if a leaf ended the walk.
#[inline(always)]
pub(super) fn walk<S: Search>(
    nodes: &[BvhNode],
    root: u32,
    slab: &Slab,
    t_min: f32,
    work: &impl Work,
    search: &mut S,
    leaves: &mut impl VisitLeaf,
) -> bool {
    walk_after(None, (nodes, Some(root)), slab, t_min, work, search, leaves)
}

/// [`walk`], if there is a root, after a leaf that is beside the tree.
#[inline(always)]
pub(super) fn walk_after<S: Search>(
    leaf: Option<&BvhNode>,
    (nodes, root): (&[BvhNode], Option<u32>),
    slab: &Slab,
    t_min: f32,
    work: &impl Work,
    search: &mut S,
    leaves: &mut impl VisitLeaf,
) -> bool {
    let mut root_waits = leaf.is_some();
    let mut node = match leaf {
        Some(leaf) => leaf,
        None => match entered_root(nodes, root, slab, t_min, work, search) {
            Some(root) => root,
            None => return false,
        },
    };
    let mut storage = Stack::<Entry, MAX_BVH_DEPTH>::storage();
    let mut stack = Stack::new(&mut storage);
    loop {
        if node.is_inner() {
            let (first, second) = (trusted(nodes, node.first), trusted(nodes, node.first + 1));
            work.nodes(2);
            let (near0, far0) = slab.interval(&first.bounds(), t_min);
            let (near1, far1) = slab.interval(&second.bounds(), t_min);
            let t_max = search.t_max();
            let (enters0, enters1) = (Slab::passes(near0, far0, t_max), Slab::passes(near1, far1, t_max));
            if enters0 & enters1 {
                let first_is_nearer = near0 <= near1;
                let farther = if first_is_nearer { (node.first + 1, near1) } else { (node.first, near0) };
                // SAFETY: a walk puts aside one node a level, and builders keep trees below MAX_BVH_DEPTH levels.
                unsafe { stack.push(farther) };
                node = if first_is_nearer { first } else { second };
                continue;
            } else if enters0 {
                node = first;
                continue;
            } else if enters1 {
                node = second;
                continue;
            }
        } else if leaves.visit(node, search) {
            return true;
        }
        if root_waits {
            root_waits = false;
            match entered_root(nodes, root, slab, t_min, work, search) {
                Some(root) => node = root,
                None => return false,
            }
            continue;
        }
        loop {
            match stack.pop() {
                None => return false,
                Some((index, near)) if Slab::passes(near, f32::INFINITY, search.t_max()) => {
                    node = trusted(nodes, index);
                    break;
                }
                Some(_) => {}
            }
        }
    }
}

/// The root, if the ray enters it.
#[inline(always)]
fn entered_root<'a>(
    nodes: &'a [BvhNode],
    root: Option<u32>,
    slab: &Slab,
    t_min: f32,
    work: &impl Work,
    search: &impl Search,
) -> Option<&'a BvhNode> {
    let root = trusted(nodes, root?);
    work.nodes(1);
    let (near, far) = slab.interval(&root.bounds(), t_min);
    if Slab::passes(near, far, search.t_max()) { Some(root) } else { None }
}
