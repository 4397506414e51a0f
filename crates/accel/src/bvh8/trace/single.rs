//! One ray at a time: eight boxes or four triangles a step.

use super::found::{ANY, CLOSEST, Found, NEXT, Query, STACK};
use super::single_leaf::{PrimitiveLeaves, ToldLeaves};
use super::single_ray::SingleRay;
use crate::bvh8::view::Bvh8View;
use crate::bvh8::{Child, EMPTY, LEAF, Node8, PLACE};
use crate::simd::{Float, Kernel, Mask, Simd, each};
use eosphor_core::hierarchy::Work;
use eosphor_core::intersect::Slab;
use eosphor_core::ray::{Ray, RayFilter};
use std::mem::MaybeUninit;

/// Where the planes that rays of an octant meet first start in a node, in bytes, for each axis; and those that they meet last.
/// (Computed: after each leaf the next node waits for it, and a table would be a load more.)
#[inline(always)]
pub(super) fn near_and_far_planes(octant: usize) -> [[usize; 3]; 2] {
    let near = [(octant & 1) << 5, 64 + ((octant & 2) << 4), 128 + ((octant & 4) << 3)];
    [near, [near[0] ^ 32, near[1] ^ 32, near[2] ^ 32]]
}

/// Eight planes of a node.
///
/// # Safety
/// The place is one of [`near_and_far_planes`].
#[inline(always)]
pub(super) unsafe fn planes<S: Simd>(node: &Node8, place: usize) -> S::F8 {
    // SAFETY: whole nodes: a node has planes at each of these places.
    unsafe { S::F8::load(node.planes.as_ptr().cast::<u8>().add(place).cast()) }
}

/// Searches the whole scene for one ray. `work` is told of boxes and primitives before they are tested.
///
/// # Safety
/// The CPU has the instruction set.
#[inline(always)]
pub(super) unsafe fn trace<S: Simd, W: Work + Copy, const QUERY: Query>(
    bvh: &Bvh8View,
    ray: &Ray,
    filter: &RayFilter,
    work: W,
    found: &mut Found,
) {
    let root = bvh.world_root;
    if SingleRay::is_usual(ray, bvh.near) {
        let local = SingleRay::of_world::<S>(ray, bvh.world);
        let search = Search::<W, QUERY, true> {
            bvh,
            root,
            ray: &local,
            instance: 0,
            filter,
            work,
            found: &mut *found,
        };
        // SAFETY: instruction set: promised to this function. Closed view: the root is the scene's.
        unsafe { search.run::<S>() };
    } else {
        // SAFETY: instruction set: promised to this function. Closed view: the root is the scene's.
        unsafe { S::run(Unusual::<W, QUERY> { bvh, ray, filter, work, found }) };
    }
    if bvh.instance_root != EMPTY && !(QUERY == ANY && found.any) {
        // SAFETY: instruction set: promised to this function. Closed view: the root is that of the instances' tree.
        unsafe { trace_instances::<S, W, QUERY>(bvh, bvh.instance_root, ray, filter, work, found) };
    }
    if QUERY == NEXT {
        // SAFETY: instruction set: promised to this function.
        unsafe { S::run(Complete { bvh, ray, found }) };
    }
}

/// A ray from far away or with numbers that are unusual: a function of its own, since it is rare.
struct Unusual<'a, W, const QUERY: Query> {
    bvh: &'a Bvh8View<'a>,
    ray: &'a Ray,
    filter: &'a RayFilter,
    work: W,
    found: &'a mut Found,
}

impl<W: Work + Copy, const QUERY: Query> Kernel for Unusual<'_, W, QUERY> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Simd>(self) {
        let Unusual { bvh, ray, filter, work, found } = self;
        if let Some(local) = SingleRay::of_any::<S>(ray, bvh.world, &bvh.bounds[0]) {
            local.enter(found);
            // SAFETY: instruction set: a kernel is run below its own. Closed view: the root is the scene's.
            unsafe { search::<S, W, QUERY>(bvh, bvh.world_root, &local, 0, filter, work, found) };
        }
    }
}

/// Computes the rest of the best hit's `t`: a function of its own, since it is large.
struct Complete<'a> {
    bvh: &'a Bvh8View<'a>,
    ray: &'a Ray,
    found: &'a mut Found,
}

impl Kernel for Complete<'_> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Simd>(self) {
        self.found.complete(self.bvh, self.ray);
    }
}

/// Searches a part of the tree over the instances, and theirs.
///
/// # Safety
/// As for [`trace`]; `root` is a child of that tree.
#[inline(always)]
pub(super) unsafe fn trace_instances<S: Simd, W: Work + Copy, const QUERY: Query>(
    bvh: &Bvh8View,
    root: Child,
    ray: &Ray,
    filter: &RayFilter,
    work: W,
    found: &mut Found,
) {
    let world_ray = SingleRay::to_instances::<S>(ray, &bvh.instance_bounds);
    let Some(world_ray) = world_ray.filter(|ray| !ray.origin[3].is_nan()) else { return };
    let slab = Slab::new(ray.origin, ray.direction, 0.0);
    let mut leaves = InstanceLeaves { bvh, ray, from: world_ray.from, slab: &slab, filter, work };
    world_ray.enter(found);
    // SAFETY: instruction set: promised to this function. Closed view: so is the root.
    unsafe { walk::<S, QUERY, false>(bvh.instance_nodes, root, &world_ray, work, found, &mut leaves) };
}

/// What a walk does at a leaf. (A trait and not a closure, because closures cannot be made to be inlined.)
pub(super) trait VisitLeaf<S: Simd> {
    /// `true` ends the walk.
    ///
    /// # Safety
    /// The CPU has the instruction set, and the leaf is one of the tree.
    unsafe fn visit<const QUERY: Query>(&mut self, leaf: Child, found: &mut Found) -> bool;

    /// Says that a child will be looked at soon. `nodes` is where those of the tree begin.
    fn prefetch(&self, nodes: *const u8, child: Child);
}

struct InstanceLeaves<'a, W> {
    bvh: &'a Bvh8View<'a>,
    ray: &'a Ray,
    /// From where the walk through the tree over the instances measures.
    from: Option<f64>,
    slab: &'a Slab,
    filter: &'a RayFilter,
    work: W,
}

impl<S: Simd, W: Work + Copy> VisitLeaf<S> for InstanceLeaves<'_, W> {
    #[inline(always)]
    fn prefetch(&self, _: *const u8, _: Child) {}

    #[inline(always)]
    unsafe fn visit<const QUERY: Query>(&mut self, leaf: Child, found: &mut Found) -> bool {
        let (bvh, ray, number) = (self.bvh, self.ray, leaf & PLACE);
        let instance = &bvh.instances[number as usize];
        let (near, far) = self.slab.interval(&instance.world_bounds, ray.t_min);
        if self.from.is_none() && !Slab::passes(near, far, found.end) {
            return false;
        }
        let map = &instance.object_from_world;
        let geometry = instance.geometry as usize;
        let size = bvh.size_of(geometry);
        let Some(local) = SingleRay::of_object::<S>(ray, map, size, &bvh.bounds[geometry]) else {
            return false;
        };
        local.enter(found);
        // SAFETY: instruction set: promised to this function. Closed view: the root is the geometry's.
        let over = unsafe {
            search::<S, W, QUERY>(bvh, bvh.roots[geometry], &local, number, self.filter, self.work, found)
        };
        if local.from.is_some() | self.from.is_some() {
            found.measure_from(self.from);
        }
        over
    }
}

/// Searches a part of a geometry's tree, in its space; `true` ends the whole search.
///
/// # Safety
/// As for [`trace`]; `root` is a child of that tree.
#[inline(always)]
pub(super) unsafe fn search<S: Simd, W: Work + Copy, const QUERY: Query>(
    bvh: &Bvh8View,
    root: Child,
    ray: &SingleRay,
    instance: u32,
    filter: &RayFilter,
    work: W,
    found: &mut Found,
) -> bool {
    // SAFETY: instruction set: promised to this function. Closed view: so is the root.
    let over = unsafe {
        if is_forward(ray, found) {
            S::run(Search::<W, QUERY, true> { bvh, root, ray, instance, filter, work, found: &mut *found })
        } else {
            S::run(Search::<W, QUERY, false> { bvh, root, ray, instance, filter, work, found: &mut *found })
        }
    };
    if QUERY == CLOSEST && ray.from.is_some() {
        found.close(bvh, &ray.world);
    }
    over
}

/// A search: a function of its own, which keeps the code small. `FORWARD` as for [`walk`].
struct Search<'a, W, const QUERY: Query, const FORWARD: bool> {
    bvh: &'a Bvh8View<'a>,
    root: Child,
    ray: &'a SingleRay<'a>,
    instance: u32,
    filter: &'a RayFilter,
    work: W,
    found: &'a mut Found,
}

impl<W: Work + Copy, const QUERY: Query, const FORWARD: bool> Kernel for Search<'_, W, QUERY, FORWARD> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> bool {
        let Search { bvh, root, ray, instance, filter, work, found } = self;
        let mut leaves = ToldLeaves { leaves: PrimitiveLeaves { bvh, ray, instance, filter }, work };
        // SAFETY: instruction set: a kernel is run below its own. Closed view: the root was promised to `search` or `trace`.
        unsafe { walk::<S, QUERY, FORWARD>(bvh.nodes, root, ray, work, found, &mut leaves) }
    }
}

/// The next child that waits and may have a hit.
///
/// # Safety
/// As many children wait, each with where the ray enters it.
#[inline(always)]
unsafe fn pop<const QUERY: Query>(
    children: *const Child,
    nears: *const f32,
    count: &mut usize,
    end: f32,
) -> Option<Child> {
    while *count > 0 {
        *count -= 1;
        // SAFETY: stack room: places below the count have been written, as promised to this function.
        unsafe {
            if QUERY == ANY || *nears.add(*count) <= end {
                return Some(*children.add(*count));
            }
        }
    }
    None
}

/// Whether a ray begins at its origin or beyond and none of its numbers is NaN, and neither is its end.
#[inline(always)]
pub(super) fn is_forward(ray: &SingleRay, found: &Found) -> bool {
    // (A ray with numbers out of range has a `t_min` of NaN.)
    (0.0 <= ray.origin[3]) & (0.0 <= found.end)
}

/// Visits the leaves that the ray enters, roughly from near to far; `true` where a leaf ended the walk. A node is left
/// out only when the ray enters it beyond the best hit, never at equality: there a tie may wait.
///
/// `FORWARD`: the ray is one ([`is_forward`]). Then distances are compared by their bits as whole numbers, which takes a CPU a
/// cycle and not four: of numbers of which one is not below 0 the largest is the same, and a box that is left before that is
/// left out either way. (On a Xeon rays are 5 to 15 percent faster so, with AVX2 and AVX-512.)
///
/// # Safety
/// The CPU has the instruction set; `root` is [`EMPTY`] or a child of the tree of these nodes.
#[inline(always)]
pub(super) unsafe fn walk<S: Simd, const QUERY: Query, const FORWARD: bool>(
    nodes: &[Node8],
    root: Child,
    ray: &SingleRay,
    work: impl Work,
    found: &mut Found,
    leaves: &mut impl VisitLeaf<S>,
) -> bool {
    let mut children = MaybeUninit::<[Child; STACK]>::uninit();
    let mut nears = MaybeUninit::<[f32; STACK]>::uninit();
    let (children, nears) = (children.as_mut_ptr().cast::<Child>(), nears.as_mut_ptr().cast::<f32>());
    let mut count = 0usize;
    let mut at = root;
    if root == EMPTY {
        return false;
    }
    loop {
        // Loaded again after leaves, and not saved before: most rays visit one leaf or two.
        let ray = std::hint::black_box(ray);
        let inverse = each!(k => S::F8::splat(ray.inverse[k]));
        let near_offset = each!(k => S::F8::splat(ray.near_offset[k]));
        let far_offset = each!(k => S::F8::splat(ray.far_offset[k]));
        let (t_min, t_max) = (S::F8::splat(ray.origin[3]), S::F8::splat(found.end));
        // (From the first node, so that nothing but the number of a node is to be added.)
        let first = nodes.as_ptr().cast::<u8>();
        let [near_planes, far_planes] =
            near_and_far_planes(ray.octant as usize).map(|places| each!(k => first.wrapping_add(places[k])));
        while at & LEAF == 0 {
            // SAFETY: closed view: children are numbers of nodes, and no path is longer than the stack has room for.
            unsafe {
                let node = nodes.get_unchecked(at as usize);
                work.nodes(8);
                let offset = at as usize * size_of::<Node8>();
                let planes = |from: *const u8| S::F8::load(from.wrapping_add(offset).cast());
                let [x0, y0, z0] = each!(k => planes(near_planes[k]).fma(inverse[k], near_offset[k]));
                let [x1, y1, z1] = each!(k => planes(far_planes[k]).fma(inverse[k], far_offset[k]));
                let (near, far, entered);
                if FORWARD {
                    near = S::larger8(S::larger8(x0, y0), S::larger8(z0, t_min));
                    far = S::smaller8(S::smaller8(x1, y1), S::smaller8(z1, t_max));
                    entered = S::not_above8(near, far);
                } else {
                    near = x0.max(y0).max(z0.max(t_min));
                    far = x1.min(y1).min(z1.min(t_max));
                    entered = near.le(far).bits();
                }
                let others = entered & entered.wrapping_sub(1);
                debug_assert!(count + 8 <= STACK);
                if others == 0 {
                    // None, or one: on to it.
                    at = if entered != 0 {
                        *node.children.get_unchecked(entered.trailing_zeros() as usize)
                    } else if let Some(next) = pop::<QUERY>(children, nears, &mut count, found.end) {
                        next
                    } else {
                        return false;
                    };
                } else if QUERY == ANY && others & (others - 1) == 0 {
                    // Two, the usual case: what is written as one number is read sooner than a part of a register.
                    let (a, b) =
                        (entered.trailing_zeros() as usize & 7, others.trailing_zeros() as usize & 7);
                    *children.add(count) = node.children[a];
                    count += 1;
                    at = node.children[b];
                } else if QUERY == ANY {
                    let node_children = S::F8::load(node.children.as_ptr().cast());
                    S::compress8(node_children, entered, children.add(count).cast());
                    count += entered.count_ones() as usize - 1;
                    // The last one is on top: on to it without asking the stack.
                    at = *node.children.get_unchecked(31 - entered.leading_zeros() as usize);
                } else if others & (others - 1) == 0 {
                    // Two, the usual case: the nearer one first.
                    let (a, b) =
                        (entered.trailing_zeros() as usize & 7, others.trailing_zeros() as usize & 7);
                    let (near_a, near_b) = (S::lane8(near, a), S::lane8(near, b));
                    let (child_a, child_b) = (node.children[a], node.children[b]);
                    let a_first = near_a <= near_b;
                    let waiting = if a_first { child_b } else { child_a };
                    leaves.prefetch(first, waiting);
                    *children.add(count) = waiting;
                    *nears.add(count) = if a_first { near_b } else { near_a };
                    count += 1;
                    at = if a_first { child_a } else { child_b };
                } else {
                    let bits = *node.orders.get_unchecked(ray.octant as usize);
                    let order = S::order8(bits);
                    let near = S::permute8(near, order);
                    let far = S::permute8(far, order);
                    // (By the comparison from before, which said that there are three: where one is NaN the two differ,
                    // and the count of what waits must not go below 0.)
                    let entered = if FORWARD { S::not_above8(near, far) } else { near.le(far).bits() };
                    let node_children = S::F8::load(node.children.as_ptr().cast());
                    S::compress8(S::permute8(node_children, order), entered, children.add(count).cast());
                    S::compress8(near, entered, nears.add(count));
                    count += entered.count_ones() as usize - 1;
                    let lane = 31 - entered.leading_zeros();
                    at = *node.children.get_unchecked((bits >> (3 * lane) & 7) as usize);
                }
            }
        }
        while at & LEAF != 0 {
            // SAFETY: instruction set: promised to this function. Closed view: the leaf is one of this tree.
            if unsafe { leaves.visit::<QUERY>(at, found) } {
                return true;
            }
            // SAFETY: stack room: places below the count have been written.
            let next = unsafe { pop::<QUERY>(children, nears, &mut count, found.end) };
            let Some(next) = next else { return false };
            at = next;
        }
    }
}
