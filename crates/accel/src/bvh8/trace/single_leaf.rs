//! Leaves of triangles and spheres, for one ray at a time.

use super::lanes::{StepRays, StepTriangles, distance, first_step};
use super::single::VisitLeaf;
use super::single_ray::SingleRay;
use super::walk::{ANY, COUNTING, Found, KIND, NEXT, NO_TRIANGLE, Offer, Query};
use crate::bvh8::view::Bvh8View;
use crate::bvh8::{Child, INSTANCE, PLACE, SPHERE, TriangleBlock};
use crate::simd::{Float, Kernel, Mask, Simd, Vec3V, cross, dot, each, subtract};
use eosphor_core::intersect::{
    TriangleHit, UNDERFLOW_SLACK, intersect_precisely, intersect_sphere, may_meet_sphere,
};
use eosphor_core::ray::{Hit, PrimitiveId, RayFilter, UNKNOWN_REST};

/// Leaves of triangles and spheres.
///
/// Most hits are clear, and by the bounds of their `t` nothing that was met before is near. Such a hit is taken as it is.
pub(super) struct PrimitiveLeaves<'a> {
    pub(super) bvh: &'a Bvh8View<'a>,
    pub(super) ray: &'a SingleRay<'a>,
    pub(super) instance: u32,
    pub(super) filter: &'a RayFilter,
}

impl<S: Simd> VisitLeaf<S> for PrimitiveLeaves<'_> {
    #[inline(always)]
    unsafe fn visit<const QUERY: Query>(&mut self, leaf: Child, found: &mut Found) -> bool {
        if leaf & SPHERE != 0 {
            if QUERY & COUNTING != 0 {
                found.primitives += 1;
            }
            let (leaves, number) = (&*self, (leaf & PLACE) as usize);
            // SAFETY: the caller's.
            return unsafe { S::run(SphereTest::<QUERY> { leaves, number, found }) };
        }
        debug_assert!(leaf & INSTANCE == 0);
        self.test_block::<S, QUERY>(leaf & PLACE, found)
    }
}

impl PrimitiveLeaves<'_> {
    /// The first step for all triangles of the block. Few are left, and of these most are hit clearly.
    #[inline(always)]
    fn test_block<S: Simd, const QUERY: Query>(&mut self, number: u32, found: &mut Found) -> bool {
        // SAFETY: leaves name blocks that the builder made.
        let block = unsafe { self.bvh.blocks.get_unchecked(number as usize) };
        let ray = self.ray;
        let zero = S::F4::splat(0.0);
        let v0 = load3::<S>(&block.v0);
        let (e1, e2) = (subtract(&load3::<S>(&block.v1), &v0), subtract(&load3::<S>(&block.v2), &v0));
        let direction = each!(k => S::F4::splat(ray.direction[k]));
        let from_origin = each!(k => v0[k].sub(S::F4::splat(ray.origin[k])));
        let r = cross(&from_origin, &direction);
        let normal = cross(&e1, &e2);
        let determinant = dot(&normal, &direction);
        let sign = determinant.sign();
        let size = determinant.xor(sign);
        let u = dot(&r, &e2).xor(sign);
        let v = dot(&r, &e1).xor(sign.xor(zero.negate()));
        let least = u.min(v).min(size.sub(u).sub(v));
        let (length1, length2) = (S::F4::from_array(&block.length1), S::F4::from_array(&block.length2));
        let distance = distance(&from_origin, S::F4::splat(ray.reach));
        let lengths = length1.add(length2);
        let slack = S::F4::splat(ray.edge_slack).mul(distance.add(lengths.abs()));
        let slack = slack.fma(lengths, S::F4::splat(UNDERFLOW_SLACK));
        if QUERY & COUNTING != 0 {
            found.primitives += block.count::<S>() as u32;
        }
        if least.lt(slack.negate()).bits() == 0xf {
            return false;
        }
        // The compiler finds what was computed already.
        let rays = StepRays {
            direction,
            t_min: S::F4::splat(ray.origin[3]),
            t_max: S::F4::splat(ray.world.t_max),
            length: S::F4::splat(ray.direction[3]),
            edge_slack: S::F4::splat(ray.edge_slack),
            scale: S::F4::splat(ray.scale),
        };
        let triangles = StepTriangles { e1, e2, normal, length1, length2, from_origin, distance };
        let step = first_step(&rays, &triangles);
        let end = S::F4::splat(found.end);
        let beyond = step.high.lt(rays.t_min).or(end.lt(step.low)).and(step.is_steep);
        let lanes = !step.misses.or(beyond).bits() & 0xf;
        if lanes == 0 {
            return false;
        }
        let lane = lanes.trailing_zeros() as usize & 3;
        let nearer = step.is_clear.and(step.high.lt(S::F4::splat(found.before)));
        let is_alone = lanes & (lanes - 1) == 0;
        let taken = lanes & nearer.bits() != 0 || QUERY & KIND == ANY && lanes & step.is_clear.bits() != 0;
        if QUERY & KIND != NEXT && is_alone & taken & ray.from.is_none() {
            let id = PrimitiveId { instance: self.instance, primitive: block.primitive[lane] };
            let culled = self.filter.cull_back_faces & (step.sign.same_bits(zero).bits() >> lane & 1 == 1);
            if self.filter.skips(id) | culled {
                return false;
            }
            if QUERY & KIND == ANY {
                found.any = true;
                return true;
            }
            let (t, u, v) = (step.t.to_array()[lane], step.u.to_array()[lane], step.v.to_array()[lane]);
            let (low, high) = (step.low.to_array()[lane], step.high.to_array()[lane]);
            found.take(Hit { t, t_rest: UNKNOWN_REST, u, v, id }, number << 2 | lane as u32, low, high);
            return false;
        }
        let clear = if ray.from.is_some() { 0 } else { step.is_clear.bits() };
        let hits = Clear {
            bits: clear,
            t: step.t.to_array(),
            error: step.error.to_array(),
            u: step.u.to_array(),
            v: step.v.to_array(),
        };
        let backs = step.sign.same_bits(zero).bits();
        // SAFETY: the caller's.
        unsafe { S::run(Compare::<QUERY> { leaves: self, number, lanes, hits: &hits, backs, found }) }
    }

    #[inline(always)]
    fn test_sphere<const QUERY: Query>(&self, number: usize, found: &mut Found) -> bool {
        let (bvh, ray) = (self.bvh, self.ray);
        let sphere = &bvh.spheres[number];
        if ray.origin[3].is_nan() || !may_meet_sphere(&ray.local(), sphere) {
            return false;
        }
        let id = PrimitiveId { instance: self.instance, primitive: bvh.sphere_primitives[number] };
        for crossing in intersect_sphere(sphere, &ray.world, ray.map) {
            // Roots that are not hits are NaN.
            if crossing.t.is_nan() {
                continue;
            }
            let hit = TriangleHit::of_sphere(&crossing);
            if found.offer::<QUERY>(&Offer { bvh, ray: &ray.world, hit, id, place: NO_TRIANGLE }) {
                return true;
            }
        }
        false
    }
}

/// A sphere: a function of its own, since it is rare and large.
struct SphereTest<'a, const QUERY: Query> {
    leaves: &'a PrimitiveLeaves<'a>,
    number: usize,
    found: &'a mut Found,
}

impl<const QUERY: Query> Kernel for SphereTest<'_, QUERY> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> bool {
        self.leaves.test_sphere::<QUERY>(self.number, self.found)
    }
}

/// What the first step says of the triangles of a block, and for which of them that is enough.
struct Clear {
    bits: u32,
    t: [f32; 4],
    error: [f32; 4],
    u: [f32; 4],
    v: [f32; 4],
}

/// Candidates that are not clear, or close to others: a function of its own, since it is rare and large.
struct Compare<'a, const QUERY: Query> {
    leaves: &'a PrimitiveLeaves<'a>,
    number: u32,
    lanes: u32,
    hits: &'a Clear,
    /// Those that are met from behind.
    backs: u32,
    found: &'a mut Found,
}

impl<const QUERY: Query> Kernel for Compare<'_, QUERY> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> bool {
        let Compare { leaves, number, mut lanes, hits, backs, found } = self;
        let (bvh, ray) = (leaves.bvh, leaves.ray);
        if leaves.filter.cull_back_faces {
            lanes &= !backs;
        }
        let block = &bvh.blocks[number as usize];
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 3;
            lanes &= lanes - 1;
            let id = PrimitiveId { instance: leaves.instance, primitive: block.primitive[lane] };
            // What has been cut is met again.
            let again = QUERY & KIND != ANY && found.best.id == id;
            if leaves.filter.skips(id) | again {
                continue;
            }
            let hit = if hits.bits >> lane & 1 == 1 {
                let (t, t_error, u, v) = (hits.t[lane], hits.error[lane], hits.u[lane], hits.v[lane]);
                TriangleHit { meets: true, is_clear: true, t, t_error, t_rest: UNKNOWN_REST, u, v }
            } else if ray.from.is_some() {
                moved_test(block, lane, bvh, ray, leaves.instance)
            } else {
                precise_test(block, lane, ray)
            };
            let place = number << 2 | lane as u32;
            if hit.meets && found.offer::<QUERY>(&Offer { bvh, ray: &ray.world, hit, id, place }) {
                return true;
            }
        }
        false
    }
}

#[inline(always)]
fn precise_test(block: &TriangleBlock, lane: usize, ray: &SingleRay) -> TriangleHit {
    if ray.origin[3].is_nan() {
        return TriangleHit::NOWHERE;
    }
    intersect_precisely(&block.get(lane), &ray.world, ray.map)
}

/// The whole test, for rays that are looked at from elsewhere.
#[inline(always)]
fn moved_test(
    block: &TriangleBlock,
    lane: usize,
    bvh: &Bvh8View,
    ray: &SingleRay,
    instance: u32,
) -> TriangleHit {
    let geometry = bvh.instances[instance as usize].geometry;
    let extent = bvh.geometries[geometry as usize].extent;
    eosphor_core::intersect::intersect_triangle(&block.get(lane), &ray.world, ray.map, extent)
}

#[inline(always)]
fn load3<S: Simd>(v: &[[f32; 4]; 3]) -> Vec3V<S::F4> {
    each!(k => S::F4::from_array(&v[k]))
}
