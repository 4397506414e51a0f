//! Queries for one ray that leave out instances by a mask and hits by a closure.
//!
//! The walk is that of single rays. Its leaves are other ones: every candidate is computed by core's own test and shown to the
//! closure before it can end the search or become the best hit, so nothing that is left out hides anything. Unfiltered queries
//! share no code with this but the walk.

use super::found::{ANY, Found, NEXT, NO_TRIANGLE, Offer, Query};
use super::lanes::{Determinant, EdgesV, StepPlanes, distance};
use super::single::{VisitLeaf, is_forward, walk};
use super::single_leaf::{load3, moved_test, prefetch};
use super::single_ray::SingleRay;
use crate::bvh8::view::Bvh8View;
use crate::bvh8::{Child, EMPTY, PLACE, SPHERE};
use crate::simd::{Float, Kernel, Mask, Simd, cross, dot, each, subtract};
use eosphor_core::hierarchy::IgnoreWork;
use eosphor_core::intersect::{Slab, TriangleHit, UNDERFLOW_SLACK, intersect_sphere, may_meet_sphere};
use eosphor_core::math::Affine;
use eosphor_core::ray::{Hit, PrimitiveId, Ray, RayFilter};

/// Which instances a query looks at: those whose mask has a bit in common with the query's.
#[derive(Clone, Copy, Debug)]
pub(super) struct InstanceMasks<'a> {
    /// A mask for each instance; `None` where all are looked at.
    pub(super) masks: Option<&'a [u32]>,
    /// The query's mask.
    pub(super) mask: u32,
}

impl InstanceMasks<'_> {
    /// Every instance is looked at.
    pub(super) const ALL: InstanceMasks<'static> = InstanceMasks { masks: None, mask: u32::MAX };

    #[inline(always)]
    fn show(&self, instance: u32) -> bool {
        self.masks.is_none_or(|masks| masks[instance as usize] & self.mask != 0)
    }
}

/// What a filtered query asks.
#[derive(Clone, Copy)]
pub(super) struct Asked<'a> {
    pub(super) bvh: &'a Bvh8View<'a>,
    pub(super) ray: &'a Ray,
    pub(super) filter: &'a RayFilter,
    pub(super) instances: InstanceMasks<'a>,
}

/// Whether a hit counts.
pub(super) type Accept<'a> = dyn FnMut(&Hit) -> bool + 'a;

/// A filtered query for one ray through the whole scene.
pub(super) struct Filtered<'a, 'f, const QUERY: Query> {
    pub(super) asked: Asked<'a>,
    pub(super) accept: &'a mut Accept<'f>,
    pub(super) found: &'a mut Found,
}

impl<const QUERY: Query> Kernel for Filtered<'_, '_, QUERY> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Simd>(self) {
        let Filtered { asked, accept, found } = self;
        let Asked { bvh, ray, instances, .. } = asked;
        if instances.show(0) {
            let usual = SingleRay::is_usual(ray, bvh.near);
            let local = if usual {
                Some(SingleRay::of_world::<S>(ray, bvh.world))
            } else {
                SingleRay::of_any::<S>(ray, bvh.world, &bvh.bounds[0])
            };
            if let Some(local) = local {
                local.enter(found);
                let leaves = FilteredLeaves { asked, ray: &local, instance: 0, accept: &mut *accept };
                // SAFETY: instruction set: promised to this function. Closed view: the root is that of geometry 0.
                unsafe { search::<S, QUERY>(bvh.world_root, leaves, found) };
            }
        }
        if bvh.instance_root != EMPTY && !(QUERY == ANY && found.any) {
            let world_ray = SingleRay::to_instances::<S>(ray, &bvh.instance_bounds);
            if let Some(world_ray) = world_ray.filter(|ray| !ray.origin[3].is_nan()) {
                let slab = Slab::new(ray.origin, ray.direction, 0.0);
                let mut leaves = FilteredInstances { asked, from: world_ray.from, slab: &slab, accept };
                world_ray.enter(found);
                let (nodes, root) = (bvh.instance_nodes, bvh.instance_root);
                // SAFETY: instruction set: promised to this function. Closed view: the root is that of the instances' tree.
                unsafe { walk::<S, QUERY, false>(nodes, root, &world_ray, IgnoreWork, found, &mut leaves) };
            }
        }
        if QUERY == NEXT {
            found.complete(bvh, ray);
        }
    }
}

/// Searches the tree of one geometry; `true` ends the whole search.
///
/// # Safety
/// Instruction set: the CPU has it. Closed view: the root is the geometry's.
#[inline(always)]
unsafe fn search<S: Simd, const QUERY: Query>(
    root: Child,
    leaves: FilteredLeaves,
    found: &mut Found,
) -> bool {
    // SAFETY: instruction set and closed view: promised to this function.
    unsafe {
        if is_forward(leaves.ray, found) {
            S::run(Search::<QUERY, true> { root, leaves, found })
        } else {
            S::run(Search::<QUERY, false> { root, leaves, found })
        }
    }
}

/// The search: a function of its own, which keeps the code small. `FORWARD` as for [`walk`].
struct Search<'a, 'f, const QUERY: Query, const FORWARD: bool> {
    root: Child,
    leaves: FilteredLeaves<'a, 'f>,
    found: &'a mut Found,
}

impl<const QUERY: Query, const FORWARD: bool> Kernel for Search<'_, '_, QUERY, FORWARD> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> bool {
        let Search { root, mut leaves, found } = self;
        let (nodes, ray) = (leaves.asked.bvh.nodes, leaves.ray);
        // SAFETY: instruction set and closed view: promised to this function.
        unsafe { walk::<S, QUERY, FORWARD>(nodes, root, ray, IgnoreWork, found, &mut leaves) }
    }
}

/// Leaves of the tree over the instances.
struct FilteredInstances<'a, 'f> {
    asked: Asked<'a>,
    /// From where the walk through the tree over the instances measures.
    from: Option<f64>,
    slab: &'a Slab,
    accept: &'a mut Accept<'f>,
}

impl<S: Simd> VisitLeaf<S> for FilteredInstances<'_, '_> {
    #[inline(always)]
    fn prefetch(&self, _: *const u8, _: Child) {}

    #[inline(always)]
    unsafe fn visit<const QUERY: Query>(&mut self, leaf: Child, found: &mut Found) -> bool {
        let (Asked { bvh, ray, instances, .. }, number) = (self.asked, leaf & PLACE);
        if !instances.show(number) {
            return false;
        }
        let instance = &bvh.instances[number as usize];
        let (near, far) = self.slab.interval(&instance.world_bounds, ray.t_min);
        if self.from.is_none() && !Slab::passes(near, far, found.end) {
            return false;
        }
        let map: &Affine = &instance.object_from_world;
        let geometry = instance.geometry as usize;
        let size = bvh.size_of(geometry);
        let Some(local) = SingleRay::of_object::<S>(ray, map, size, &bvh.bounds[geometry]) else {
            return false;
        };
        local.enter(found);
        let leaves =
            FilteredLeaves { asked: self.asked, ray: &local, instance: number, accept: &mut *self.accept };
        // SAFETY: instruction set: promised to this function. Closed view: the root is the geometry's.
        let over = unsafe { search::<S, QUERY>(bvh.roots[geometry], leaves, found) };
        if local.from.is_some() | self.from.is_some() {
            found.measure_from(self.from);
        }
        over
    }
}

/// Leaves of triangles and spheres.
struct FilteredLeaves<'a, 'f> {
    asked: Asked<'a>,
    /// The ray in the space of the instance.
    ray: &'a SingleRay<'a>,
    instance: u32,
    accept: &'a mut Accept<'f>,
}

impl<S: Simd> VisitLeaf<S> for FilteredLeaves<'_, '_> {
    #[inline(always)]
    fn prefetch(&self, nodes: *const u8, child: Child) {
        prefetch::<S, 3>(self.asked.bvh, nodes, child);
    }

    #[inline(always)]
    unsafe fn visit<const QUERY: Query>(&mut self, leaf: Child, found: &mut Found) -> bool {
        if leaf & SPHERE != 0 {
            self.test_sphere::<QUERY>((leaf & PLACE) as usize, found)
        } else {
            self.test_block::<S, QUERY>(leaf & PLACE, found)
        }
    }
}

impl FilteredLeaves<'_, '_> {
    /// Shows a hit to the closure, and offers it if that accepts; `true` ends the search.
    #[inline(always)]
    fn offer<const QUERY: Query>(
        &mut self,
        hit: TriangleHit,
        id: PrimitiveId,
        place: u32,
        found: &mut Found,
    ) -> bool {
        // What is beyond the best hit for certain need not be shown.
        if hit.bounds().0 > found.high {
            return false;
        }
        let shown = Hit { t: hit.t, t_rest: hit.t_rest, u: hit.u, v: hit.v, id };
        let offer = Offer { bvh: self.asked.bvh, ray: self.asked.ray, hit, id, place };
        (self.accept)(&shown) && found.offer::<QUERY>(&offer)
    }

    /// Runs the first step for all triangles of the block. Those that the ray may meet get the whole test, one by one.
    #[inline(always)]
    fn test_block<S: Simd, const QUERY: Query>(&mut self, number: u32, found: &mut Found) -> bool {
        let (Asked { bvh, filter, .. }, ray) = (self.asked, self.ray);
        let block = &bvh.blocks[number as usize];
        let v0 = load3::<S>(&block.v0);
        let e1 = subtract(&load3::<S>(&block.v1), &v0);
        let e2 = subtract(&load3::<S>(&block.v2), &v0);
        let direction = each!(k => S::F4::splat(ray.direction[k]));
        let from_origin = subtract(&v0, &each!(k => S::F4::splat(ray.origin[k])));
        let normal = cross(&e1, &e2);
        let determinant = Determinant::new(&normal, &direction);
        let edges = EdgesV::new(&from_origin, &e1, &e2, &direction, &determinant);
        let lengths = S::F4::from_array(&block.lengths);
        let outside = S::F4::splat(ray.outside).fma(lengths, S::F4::splat(-UNDERFLOW_SLACK));
        let near = !edges.least.lt(outside).bits() & 0xf;
        if near == 0 {
            return false;
        }
        let distance = distance(&from_origin, S::F4::splat(ray.reach), lengths);
        let plane = StepPlanes {
            product: S::F4::from_array(&block.product),
            lengths,
            distance,
            distance_with_lengths: distance.add(lengths.abs()),
            numerator: dot(&normal, &from_origin),
        };
        let slack = plane.slack(S::F4::splat(ray.edge_slack));
        let planes = plane.meet(S::F4::splat(ray.direction[3]), &determinant, slack);
        let beyond = planes.is_beyond(S::F4::splat(ray.origin[3]), S::F4::splat(found.end));
        let mut lanes = near & !edges.least.lt(slack.negate()).or(beyond).bits();
        if filter.cull_back_faces {
            lanes &= !determinant.sign.same_bits(S::F4::splat(0.0)).bits();
        }
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 3;
            lanes &= lanes - 1;
            let id = PrimitiveId { instance: self.instance, primitive: block.primitive[lane] };
            // What has been cut is met again.
            let again = QUERY != ANY && found.best.id == id;
            if filter.skips(id) | again {
                continue;
            }
            let hit = moved_test(block, lane, bvh, ray, self.instance);
            if hit.meets && self.offer::<QUERY>(hit, id, number << 2 | lane as u32, found) {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn test_sphere<const QUERY: Query>(&mut self, number: usize, found: &mut Found) -> bool {
        let (bvh, ray) = (self.asked.bvh, self.ray);
        let sphere = &bvh.spheres[number];
        if ray.origin[3].is_nan() || !may_meet_sphere(&ray.local(), sphere) {
            return false;
        }
        let id = PrimitiveId { instance: self.instance, primitive: bvh.sphere_primitives[number] };
        for crossing in intersect_sphere(sphere, &ray.world, ray.map) {
            // Roots that are not hits are NaN.
            let is_hit = !crossing.t.is_nan();
            if is_hit && self.offer::<QUERY>(TriangleHit::of_sphere(&crossing), id, NO_TRIANGLE, found) {
                return true;
            }
        }
        false
    }
}
