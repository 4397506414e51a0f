//! One ray at a time: eight boxes or four triangles a step.

use super::single_ray::SingleRay;
use super::walk::{ANY, COUNTING, Found, KIND, Query, STACK};
use crate::bvh8::{Bvh8, Child, EMPTY, INSTANCE, LEAF, Node8, PLACE, SPHERE, TriangleBlock};
use crate::simd::{Float, Kernel, Mask, Simd, Vec3V, cross, dot, each};
use eosphor_core::intersect::{Confirmed, LocalRay, SMALLEST_DETERMINANT, STEEP, Slab, intersect_sphere};
use eosphor_core::ray::{Hit, PrimitiveId, Ray, RayFilter};
use std::mem::MaybeUninit;

/// Where the planes that rays of an octant meet first start in a node, in bytes, for each axis; those on the far side are
/// 32 bytes away, one way or the other.
#[inline(always)]
pub(super) fn near_planes(octant: usize) -> [usize; 3] {
    each!(k => 64 * k + 32 * (octant >> k & 1))
}

/// Eight planes of a node.
///
/// # Safety
/// The place is one of [`near_planes`], or on the far side.
#[inline(always)]
pub(super) unsafe fn planes<S: Simd>(node: &Node8, place: usize) -> S::F8 {
    // SAFETY: the caller's.
    unsafe { S::F8::load(node.planes.as_ptr().cast::<u8>().add(place).cast()) }
}

/// Whose primitives these are, and when hits count there.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) instance: u32,
    /// Where the world ray is in the instance's world box.
    pub(super) world_interval: (f32, f32),
}

/// The world itself.
pub(super) static WORLD: Place = Place { instance: 0, world_interval: (f32::NEG_INFINITY, f32::INFINITY) };

/// Searches the whole scene for one ray.
///
/// # Safety
/// The CPU has the instruction set.
#[inline(always)]
pub(super) unsafe fn trace<S: Simd, const QUERY: Query>(
    bvh: &Bvh8,
    ray: &Ray,
    filter: &RayFilter,
    found: &mut Found,
) {
    let extent = bvh.geometries[0].extent;
    let local = SingleRay::new::<S>(ray.origin, ray.direction, ray.t_min, extent);
    let search = Search::<QUERY> { bvh, root: bvh.roots[0], ray: &local, place: &WORLD, filter, found };
    // SAFETY: the root is the scene's.
    unsafe { search.run::<S>() };
    if bvh.instance_root != EMPTY && !(QUERY & KIND == ANY && found.any) {
        // SAFETY: as above.
        unsafe { trace_instances::<S, QUERY>(bvh, bvh.instance_root, ray, filter, found) };
    }
}

/// Searches a part of the tree over the instances, and theirs.
///
/// # Safety
/// As for [`trace`]; `root` is a child of that tree.
#[inline(always)]
pub(super) unsafe fn trace_instances<S: Simd, const QUERY: Query>(
    bvh: &Bvh8,
    root: Child,
    ray: &Ray,
    filter: &RayFilter,
    found: &mut Found,
) {
    let extent = bvh.geometries[0].extent;
    let world = LocalRay::new(ray.origin, ray.direction, ray.t_min, extent);
    let world_ray = SingleRay::new::<S>(ray.origin, ray.direction, ray.t_min, extent);
    let mut leaves = InstanceLeaves { bvh, ray, world: &world, filter };
    // SAFETY: the caller's.
    unsafe { walk::<S, QUERY>(bvh, root, &world_ray, found, &mut leaves) };
}

/// What a walk does at a leaf. (A trait and not a closure, because closures cannot be made to be inlined.)
pub(super) trait VisitLeaf<S: Simd> {
    /// `true` ends the walk.
    ///
    /// # Safety
    /// The CPU has the instruction set, and the leaf is one of the tree.
    unsafe fn visit<const QUERY: Query>(&mut self, leaf: Child, found: &mut Found) -> bool;
}

struct InstanceLeaves<'a> {
    bvh: &'a Bvh8,
    ray: &'a Ray,
    world: &'a LocalRay,
    filter: &'a RayFilter,
}

impl<S: Simd> VisitLeaf<S> for InstanceLeaves<'_> {
    #[inline(always)]
    unsafe fn visit<const QUERY: Query>(&mut self, leaf: Child, found: &mut Found) -> bool {
        let (bvh, ray, number) = (self.bvh, self.ray, leaf & PLACE);
        let instance = &bvh.instances[number as usize];
        let (near, far) = self.world.slab.interval(&instance.world_bounds, self.world.t_min);
        if !Slab::passes(near, far, found.best.t) {
            return false;
        }
        let map = &instance.object_from_world;
        let extent = bvh.geometries[instance.geometry as usize].extent;
        let local =
            SingleRay::new::<S>(map.point(ray.origin), map.direction(ray.direction), ray.t_min, extent);
        let place = Place { instance: number, world_interval: (near, far) };
        let root = bvh.roots[instance.geometry as usize];
        // SAFETY: the caller's; the root is the geometry's.
        unsafe { search::<S, QUERY>(bvh, root, &local, &place, self.filter, found) }
    }
}

/// Leaves of triangles and spheres.
pub(super) struct PrimitiveLeaves<'a> {
    pub(super) bvh: &'a Bvh8,
    pub(super) ray: &'a SingleRay,
    pub(super) place: &'a Place,
    pub(super) filter: &'a RayFilter,
}

impl<S: Simd> VisitLeaf<S> for PrimitiveLeaves<'_> {
    #[inline(always)]
    unsafe fn visit<const QUERY: Query>(&mut self, leaf: Child, found: &mut Found) -> bool {
        if leaf & SPHERE != 0 {
            if QUERY & COUNTING != 0 {
                found.primitives += 1;
            }
            return test_sphere::<QUERY>(
                self.bvh,
                (leaf & PLACE) as usize,
                &self.ray.local(),
                self.place,
                found,
            );
        }
        debug_assert!(leaf & INSTANCE == 0);
        // SAFETY: leaves name blocks that the builder made.
        let block = unsafe { self.bvh.blocks.get_unchecked((leaf & PLACE) as usize) };
        self.test_block::<S, QUERY>(block, found)
    }
}

/// Searches a part of a geometry's tree, in its space; `true` ends the whole search.
///
/// # Safety
/// As for [`trace`]; `root` is a child of that tree.
#[inline(always)]
pub(super) unsafe fn search<S: Simd, const QUERY: Query>(
    bvh: &Bvh8,
    root: Child,
    ray: &SingleRay,
    place: &Place,
    filter: &RayFilter,
    found: &mut Found,
) -> bool {
    // SAFETY: the caller's.
    unsafe { S::run(Search::<QUERY> { bvh, root, ray, place, filter, found }) }
}

/// A search: a function of its own, which keeps the code small.
struct Search<'a, const QUERY: Query> {
    bvh: &'a Bvh8,
    root: Child,
    ray: &'a SingleRay,
    place: &'a Place,
    filter: &'a RayFilter,
    found: &'a mut Found,
}

impl<const QUERY: Query> Kernel for Search<'_, QUERY> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> bool {
        let Search { bvh, root, ray, place, filter, found } = self;
        let mut leaves = PrimitiveLeaves { bvh, ray, place, filter };
        // SAFETY: the caller's.
        unsafe { walk::<S, QUERY>(bvh, root, ray, found, &mut leaves) }
    }
}

/// Visits the leaves that the ray enters, roughly from near to far; `true` where a leaf ended the walk. A node is left
/// out only when the ray enters it beyond the best hit, never at equality: there a tie may wait.
#[inline(always)]
unsafe fn walk<S: Simd, const QUERY: Query>(
    bvh: &Bvh8,
    root: Child,
    ray: &SingleRay,
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
    let mut inverse = each!(k => S::F8::splat(ray.inverse[k]));
    let mut near_offset = each!(k => S::F8::splat(ray.near_offset[k]));
    let mut far_offset = each!(k => S::F8::splat(ray.far_offset[k]));
    let mut t_min = S::F8::splat(ray.origin[3]);
    let near_planes = near_planes(ray.octant);
    let mut t_max = S::F8::splat(found.end);
    loop {
        if at & LEAF == 0 {
            // SAFETY: inner nodes are numbers that the builder made; the stack has room by its length.
            unsafe {
                let node = bvh.nodes.get_unchecked(at as usize);
                if QUERY & COUNTING != 0 {
                    found.nodes += 8;
                }
                let [x0, y0, z0] =
                    each!(k => planes::<S>(node, near_planes[k]).fma(inverse[k], near_offset[k]));
                let [x1, y1, z1] =
                    each!(k => planes::<S>(node, near_planes[k] ^ 32).fma(inverse[k], far_offset[k]));
                let near = x0.max(y0).max(z0.max(t_min));
                let far = x1.min(y1).min(z1.min(t_max));
                let entered = near.le(far).bits();
                let others = entered & entered.wrapping_sub(1);
                debug_assert!(count + 8 <= STACK);
                if others == 0 {
                    // None, or one: on to it.
                    if entered != 0 {
                        at = *node.children.get_unchecked(entered.trailing_zeros() as usize);
                        continue;
                    }
                } else if QUERY & KIND == ANY {
                    let node_children = S::F8::load(node.children.as_ptr().cast());
                    S::compress8(node_children, entered, children.add(count).cast());
                    count += entered.count_ones() as usize - 1;
                    // The last one is on top: on to it without asking the stack.
                    at = *node.children.get_unchecked(31 - entered.leading_zeros() as usize);
                    continue;
                } else {
                    if others & (others - 1) == 0 {
                        // Two, the usual case: the nearer one first.
                        let (a, b) =
                            (entered.trailing_zeros() as usize & 7, others.trailing_zeros() as usize & 7);
                        let distances = near.to_array();
                        let (near_a, near_b) = (distances[a], distances[b]);
                        let (child_a, child_b) = (node.children[a], node.children[b]);
                        let a_first = near_a <= near_b;
                        *children.add(count) = if a_first { child_b } else { child_a };
                        *nears.add(count) = if a_first { near_b } else { near_a };
                        count += 1;
                        at = if a_first { child_a } else { child_b };
                        continue;
                    }
                    let bits = *node.orders.get_unchecked(ray.octant);
                    let order = S::order8(bits);
                    let near = S::permute8(near, order);
                    let entered = near.le(S::permute8(far, order)).bits();
                    let node_children = S::F8::load(node.children.as_ptr().cast());
                    S::compress8(S::permute8(node_children, order), entered, children.add(count).cast());
                    S::compress8(near, entered, nears.add(count));
                    count += entered.count_ones() as usize - 1;
                    let lane = 31 - entered.leading_zeros();
                    at = *node.children.get_unchecked((bits >> (3 * lane) & 7) as usize);
                    continue;
                }
            }
        } else {
            // SAFETY: the caller's.
            if unsafe { leaves.visit::<QUERY>(at, found) } {
                return true;
            }
            t_max = S::F8::splat(found.end);
            // Loaded again, and not saved before: most rays visit one leaf or two.
            let ray = std::hint::black_box(ray);
            inverse = each!(k => S::F8::splat(ray.inverse[k]));
            near_offset = each!(k => S::F8::splat(ray.near_offset[k]));
            far_offset = each!(k => S::F8::splat(ray.far_offset[k]));
            t_min = S::F8::splat(ray.origin[3]);
        }
        loop {
            if count == 0 {
                return false;
            }
            count -= 1;
            // SAFETY: below the count, the stack has been written.
            if QUERY & KIND == ANY || unsafe { *nears.add(count) } <= found.end {
                break;
            }
        }
        // SAFETY: as above.
        at = unsafe { *children.add(count) };
    }
}

impl PrimitiveLeaves<'_> {
    /// First lets pass all triangles of the block that the ray may meet before the end: with edges a little further out
    /// than in `PackedTriangle::test_edges`, by the same operations. Few are left, and core's test decides about each.
    #[inline(always)]
    fn test_block<S: Simd, const QUERY: Query>(&self, block: &TriangleBlock, found: &mut Found) -> bool {
        let ray = self.ray;
        let zero = S::F4::splat(0.0);
        let (e1, e2) = (load3::<S>(&block.e1), load3::<S>(&block.e2));
        let direction = each!(k => S::F4::splat(ray.direction[k]));
        let from_origin = each!(k => S::F4::from_array(&block.v0[k]).sub(S::F4::splat(ray.origin[k])));
        let r = cross(&from_origin, &direction);
        let normal = cross(&e1, &e2);
        let determinant = dot(&normal, &direction);
        let sign = determinant.sign();
        let size = determinant.xor(sign);
        let u = dot(&r, &e2).xor(sign);
        let v = dot(&r, &e1).xor(sign.xor(zero.negate()));
        let least = u.min(v).min(size.sub(u).sub(v));
        let (length1, length2) = (S::F4::from_array(&block.length1), S::F4::from_array(&block.length2));
        let slack = S::F4::splat(ray.edge_slack).mul(length1.add(length2));
        if QUERY & COUNTING != 0 {
            found.primitives += block.count::<S>() as u32;
        }
        let candidates = slack.negate().le(least);
        if !candidates.any() {
            return false;
        }
        // The end and t_min are compared with a `t` that is good for rays that are steep.
        let t = dot(&normal, &from_origin).xor(sign);
        let late = size.mul(S::F4::splat(found.end + ray.t_slack)).lt(t);
        let early = t.lt(size.mul(S::F4::splat(ray.origin[3] - ray.t_slack)));
        let steep = S::F4::splat(STEEP * ray.direction[3]);
        let steep = steep.fma(length1.mul(length2), S::F4::splat(SMALLEST_DETERMINANT)).le(size);
        let mut lanes = candidates.without(late.or(early).and(steep)).bits();
        let sure = slack.le(least).and(steep).bits();
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 3;
            lanes &= lanes - 1;
            if self.test_triangle::<S, QUERY>(block, lane, sure >> lane & 1 == 1, found) {
                return true;
            }
        }
        false
    }

    /// The whole test of a candidate; `sure` says that the first step was clear.
    #[inline(always)]
    fn test_triangle<S: Simd, const QUERY: Query>(
        &self,
        block: &TriangleBlock,
        lane: usize,
        sure: bool,
        found: &mut Found,
    ) -> bool {
        let id = PrimitiveId { instance: self.place.instance, primitive: block.primitive[lane] };
        if self.filter.skips(id) {
            return false;
        }
        let ray = &self.ray.local();
        let triangle = block.get(lane);
        let normal = triangle.normal();
        let determinant = normal.dot(ray.direction);
        // The front is where the ray goes against the normal; minus 0 counts as that.
        if self.filter.cull_back_faces & determinant.is_sign_positive() {
            return false;
        }
        let mut hit = triangle.confirm(ray, normal, determinant);
        // The search goes on with an end that is known long before the hit is.
        let mut end = hit.t_near + self.ray.t_slack;
        if !(hit.meets & sure & (self.ray.t_slack < f32::INFINITY)) {
            // SAFETY: the caller's.
            hit = unsafe { S::run(Decide { ray: self.ray, block, lane }) };
            end = hit.t;
        }
        let (near, far) = self.place.world_interval;
        if !(hit.counts(ray) & Slab::passes(near, far, hit.t)) {
            return false;
        }
        debug_assert!(end >= hit.t, "{end} {hit:?}");
        found.offer::<QUERY>(Hit { t: hit.t, u: hit.u, v: hit.v, id }, end)
    }
}

/// Core decides about a candidate that is not sure: a function of its own, since it is rare and large.
struct Decide<'a> {
    ray: &'a SingleRay,
    block: &'a TriangleBlock,
    lane: usize,
}

impl Kernel for Decide<'_> {
    type Output = Confirmed;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> Confirmed {
        self.block.get(self.lane).test(&self.ray.local(), false)
    }
}

#[inline(always)]
fn load3<S: Simd>(v: &[[f32; 4]; 3]) -> Vec3V<S::F4> {
    each!(k => S::F4::from_array(&v[k]))
}

#[cold]
fn test_sphere<const QUERY: Query>(
    bvh: &Bvh8,
    number: usize,
    ray: &LocalRay,
    place: &Place,
    found: &mut Found,
) -> bool {
    let id = PrimitiveId { instance: place.instance, primitive: bvh.sphere_primitives[number] };
    let (near, far) = place.world_interval;
    for t in intersect_sphere(ray, &bvh.spheres[number]) {
        // Roots that are not hits are NaN.
        if !t.is_nan() && Slab::passes(near, far, t) && found.offer::<QUERY>(Hit { t, u: 0.0, v: 0.0, id }, t)
        {
            return true;
        }
    }
    false
}
