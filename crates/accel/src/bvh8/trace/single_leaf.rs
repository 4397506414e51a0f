//! Leaves of triangles and spheres, for one ray at a time.

use super::single::{Place, VisitLeaf};
use super::single_ray::SingleRay;
use super::walk::{ANY, COUNTING, Found, KIND, NEXT, NOT_PENDING, Query};
use crate::bvh8::view::Bvh8View;
use crate::bvh8::{Child, INSTANCE, PLACE, SPHERE, TriangleBlock};
use crate::simd::{Float, Kernel, Mask, Simd, Vec3V, cross, dot, each};
use eosphor_core::intersect::{Confirmed, LocalRay, SMALLEST_DETERMINANT, STEEP, Slab, intersect_sphere};
use eosphor_core::ray::{Hit, PrimitiveId, RayFilter};

/// Leaves of triangles and spheres.
///
/// Most hits are certain long before they are known: the ray passes so far within the edges that rounding cannot have
/// brought it there, and nothing that was met before is near. Such a hit is left pending, with bounds of its `t`,
/// and computed when the search is over or something comes close.
pub(super) struct PrimitiveLeaves<'a> {
    bvh: &'a Bvh8View<'a>,
    ray: &'a SingleRay,
    place: &'a Place,
    filter: &'a RayFilter,
    /// Hits are later than this where they count.
    after: f32,
}

impl<S: Simd> VisitLeaf<S> for PrimitiveLeaves<'_> {
    #[inline(always)]
    unsafe fn visit<const QUERY: Query>(&mut self, leaf: Child, found: &mut Found) -> bool {
        if leaf & SPHERE != 0 {
            if QUERY & COUNTING != 0 {
                found.primitives += 1;
            }
            settle::<S, QUERY>(self.bvh, self.ray, self.place.instance, found);
            let number = (leaf & PLACE) as usize;
            return test_sphere::<QUERY>(self.bvh, number, &self.ray.local(), self.place, found);
        }
        debug_assert!(leaf & INSTANCE == 0);
        self.test_block::<S, QUERY>(leaf & PLACE, found)
    }
}

impl<'a> PrimitiveLeaves<'a> {
    #[inline(always)]
    pub(super) fn new(
        bvh: &'a Bvh8View<'a>,
        ray: &'a SingleRay,
        place: &'a Place,
        filter: &'a RayFilter,
    ) -> PrimitiveLeaves<'a> {
        let t_min = ray.origin[3];
        // NaN stays, and nothing is certain then.
        let after = if place.world_interval.0 > t_min { place.world_interval.0 } else { t_min };
        PrimitiveLeaves { bvh, ray, place, filter, after }
    }

    /// First lets pass all triangles of the block that the ray may meet before the end: with edges a little further out
    /// than in `PackedTriangle::test_edges`, by the same operations. Few are left, and core's test decides about each.
    #[inline(always)]
    fn test_block<S: Simd, const QUERY: Query>(&mut self, number: u32, found: &mut Found) -> bool {
        // SAFETY: leaves name blocks that the builder made.
        let block = unsafe { self.bvh.blocks.get_unchecked(number as usize) };
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
        // Bounds of `t`, for rays that are steep.
        let product = length1.mul(length2);
        let inverse = S::F4::splat(1.0).div(size);
        let t = dot(&normal, &from_origin).xor(sign).mul(inverse);
        let t_slack = S::F4::splat(ray.t_slack).mul(product.mul(inverse));
        let (low, high) = (t.sub(t_slack), t.add(t_slack));
        let steep = S::F4::splat(STEEP * ray.direction[3]);
        let steep = steep.fma(product, S::F4::splat(SMALLEST_DETERMINANT)).le(size);
        let late = S::F4::splat(found.end).lt(low);
        let early = high.lt(S::F4::splat(ray.origin[3]));
        let left = candidates.without(late.or(early).and(steep));
        let lanes = left.bits();
        if lanes == 0 {
            return false;
        }
        let clear = slack.le(least).and(steep);
        let alone = S::F4::splat(self.after).lt(low).and(high.lt(S::F4::splat(found.before)));
        let lane = lanes.trailing_zeros() as usize & 3;
        let id = PrimitiveId { instance: self.place.instance, primitive: block.primitive[lane] };
        let is_certain = (lanes & (lanes - 1) == 0) & (lanes & clear.and(alone).bits() != 0);
        if QUERY & KIND != NEXT && is_certain {
            let culled = self.filter.cull_back_faces & (sign.same_bits(zero).bits() >> lane & 1 == 1);
            if self.filter.skips(id) | culled {
                return false;
            }
            if QUERY & KIND == ANY {
                found.any = true;
                return true;
            }
            found.pending = number << 2 | lane as u32;
            found.best.id = id;
            (found.before, found.end) = (low.to_array()[lane], high.to_array()[lane]);
            return false;
        }
        if QUERY & KIND != NEXT && lanes & (lanes - 1) == 0 && found.best.id == id {
            // What has been cut is met again.
            return false;
        }
        // SAFETY: the caller's.
        unsafe { S::run(Compare::<QUERY> { leaves: self, block, lanes, found }) }
    }

    /// The whole test of a candidate.
    #[inline(always)]
    fn test_triangle<const QUERY: Query>(
        &self,
        block: &TriangleBlock,
        lane: usize,
        found: &mut Found,
    ) -> bool {
        let id = PrimitiveId { instance: self.place.instance, primitive: block.primitive[lane] };
        if self.filter.skips(id) {
            return false;
        }
        let ray = &self.ray.local();
        let hit = block.get(lane).test(ray, self.filter.cull_back_faces);
        let (near, far) = self.place.world_interval;
        if !(hit.counts(ray) & Slab::passes(near, far, hit.t)) {
            return false;
        }
        found.offer::<QUERY>(Hit { t: hit.t, u: hit.u, v: hit.v, id })
    }
}

/// Computes the hit that is pending.
#[inline(always)]
pub(super) fn settle<S: Simd, const QUERY: Query>(
    bvh: &Bvh8View,
    ray: &SingleRay,
    instance: u32,
    found: &mut Found,
) {
    if matches!(QUERY & KIND, ANY | NEXT) || found.pending == NOT_PENDING {
        return;
    }
    // SAFETY: what is pending is a triangle of a block.
    let block = unsafe { bvh.blocks.get_unchecked((found.pending >> 2) as usize) };
    let lane = (found.pending & 3) as usize;
    let local = &ray.local();
    let triangle = block.get(lane);
    let normal = triangle.normal();
    let mut hit = triangle.confirm(local, normal, normal.dot(local.direction));
    if !hit.meets {
        // SAFETY: the caller's.
        hit = unsafe { S::run(Decide { ray, block, lane }) };
    }
    debug_assert!(
        hit.counts(local) & (found.before <= hit.t) & (hit.t <= found.end),
        "{triangle:?} {local:?}"
    );
    let id = PrimitiveId { instance, primitive: triangle.primitive };
    found.set(Hit { t: hit.t, u: hit.u, v: hit.v, id });
}

/// Candidates that are not certain, or close to others: a function of its own, since it is rare and large.
struct Compare<'a, const QUERY: Query> {
    leaves: &'a PrimitiveLeaves<'a>,
    block: &'a TriangleBlock,
    lanes: u32,
    found: &'a mut Found,
}

impl<const QUERY: Query> Kernel for Compare<'_, QUERY> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> bool {
        let Compare { leaves, block, mut lanes, found } = self;
        settle::<S, QUERY>(leaves.bvh, leaves.ray, leaves.place.instance, found);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 3;
            lanes &= lanes - 1;
            if leaves.test_triangle::<QUERY>(block, lane, found) {
                return true;
            }
        }
        false
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
    bvh: &Bvh8View,
    number: usize,
    ray: &LocalRay,
    place: &Place,
    found: &mut Found,
) -> bool {
    let id = PrimitiveId { instance: place.instance, primitive: bvh.sphere_primitives[number] };
    let (near, far) = place.world_interval;
    for t in intersect_sphere(ray, &bvh.spheres[number]) {
        // Roots that are not hits are NaN.
        if !t.is_nan() && Slab::passes(near, far, t) && found.offer::<QUERY>(Hit { t, u: 0.0, v: 0.0, id }) {
            return true;
        }
    }
    false
}
