//! Four triangles against sixteen rays.

use super::{Best, LaneFilters, Leg, MaskOf, arrays, lane_of};
use crate::bvh8::TriangleBlock;
use crate::bvh8::trace::lanes::{ConfirmedV, TriangleV, UNDERFLOW_SLACK};
use crate::bvh8::trace::walk::{ANY, Query};
use crate::simd::{Float, Kernel, Mask, Simd, Vec3V, cross, dot, each, subtract};
use eosphor_core::intersect::{LocalRay, PackedTriangle, SMALLEST_DETERMINANT};

/// What is the same for all rays about the triangles of a block: a triangle a lane, in memory.
struct Shared {
    normal: [[f32; 4]; 3],
    /// Lengths of the two edges, added and multiplied.
    sum: [f32; 4],
    product: [f32; 4],
    /// For rays from one point, with C the first vertex as seen from there: C × e2 ... turned so that the edge functions
    /// are products with the direction, and C · normal.
    function_u: [[f32; 4]; 3],
    function_v: [[f32; 4]; 3],
    t: [f32; 4],
}

#[inline(always)]
fn load3<S: Simd>(v: &[[f32; 4]; 3]) -> Vec3V<S::F4> {
    each!(k => S::F4::from_array(&v[k]))
}

#[inline(always)]
fn store3<S: Simd>(v: &Vec3V<S::F4>) -> [[f32; 4]; 3] {
    each!(k => v[k].to_array())
}

#[inline(always)]
fn lane3<S: Simd>(v: &[[f32; 4]; 3], lane: usize) -> Vec3V<S::F16> {
    each!(k => S::F16::splat(v[k][lane]))
}

impl Shared {
    #[inline(always)]
    fn new<S: Simd>(block: &TriangleBlock, origin: Option<[f32; 3]>) -> Shared {
        let (e1, e2) = (load3::<S>(&block.e1), load3::<S>(&block.e2));
        let normal = cross(&e1, &e2);
        let (length1, length2) = (S::F4::from_array(&block.length1), S::F4::from_array(&block.length2));
        let nothing = [[0.0; 4]; 3];
        let (mut function_u, mut function_v, mut t) = (nothing, nothing, [0.0; 4]);
        if let Some(origin) = origin {
            let v0 = load3::<S>(&block.v0);
            let from_origin = subtract(&v0, &each!(k => S::F4::splat(origin[k])));
            function_u = store3::<S>(&cross(&e2, &from_origin));
            function_v = store3::<S>(&cross(&e1, &from_origin));
            t = dot(&normal, &from_origin).to_array();
        }
        Shared {
            normal: store3::<S>(&normal),
            sum: length1.add(length2).to_array(),
            product: length1.mul(length2).to_array(),
            function_u,
            function_v,
            t,
        }
    }
}

impl<S: Simd> Best<S> {
    /// Tests up to four triangles; whether any ray has a new hit.
    ///
    /// First lets pass all rays that may meet a triangle before their end: with edges a little further out than in
    /// `PackedTriangle::test_edges`. Few are left, and core's test decides about each.
    #[inline(always)]
    pub(super) unsafe fn test_block<const QUERY: Query>(
        &mut self,
        block: &TriangleBlock,
        leg: &Leg<S>,
        filters: Option<&LaneFilters<S>>,
        active: MaskOf<S>,
        one_origin: Option<[f32; 3]>,
        t_max: &mut S::F16,
    ) -> bool {
        let ray = &leg.ray;
        let shared = Shared::new::<S>(block, one_origin);
        let one_point = one_origin.is_some();
        let mut changed = false;
        let mut lane = 0;
        // Unused lanes come last.
        let used = block.count::<S>();
        while lane < used {
            let normal = lane3::<S>(&shared.normal, lane);
            let determinant = dot(&normal, &ray.direction);
            let sign = determinant.sign();
            let size = determinant.xor(sign);
            let (u, v);
            if one_point {
                u = dot(&lane3::<S>(&shared.function_u, lane), &ray.direction);
                v = dot(&lane3::<S>(&shared.function_v, lane), &ray.direction);
            } else {
                let r = cross(&subtract(&lane3::<S>(&block.v0, lane), &ray.origin), &ray.direction);
                u = dot(&r, &lane3::<S>(&block.e2, lane));
                v = dot(&r, &lane3::<S>(&block.e1, lane));
            }
            let u = u.xor(sign);
            let v = v.xor(sign.negate());
            let least = u.min(v).min(size.sub(u).sub(v));
            let slack = ray.edge_slack.fma(S::F16::splat(shared.sum[lane]), S::F16::splat(UNDERFLOW_SLACK));
            let candidates = slack.negate().le(least).and(active);
            if candidates.any() {
                // Bounds of `t`, for rays that are steep.
                let t = if one_point {
                    S::F16::splat(shared.t[lane])
                } else {
                    dot(&normal, &subtract(&lane3::<S>(&block.v0, lane), &ray.origin))
                };
                let product = S::F16::splat(shared.product[lane]);
                let inverse = S::F16::splat(1.0).div(size);
                let t = t.mul(inverse).xor(sign);
                let t_slack = ray.t_slack.mul(product.mul(inverse));
                let (low, high) = (t.sub(t_slack), t.add(t_slack));
                let late = t_max.lt(low);
                let early = high.lt(ray.t_min);
                let steep = ray.steep.fma(product, S::F16::splat(SMALLEST_DETERMINANT)).le(size);
                let mut mask = candidates.without(late.or(early).and(steep));
                let primitive = block.primitive[lane];
                if let Some(filters) = filters {
                    mask = filters.apply(mask, leg.instance, primitive, determinant);
                }
                let sure = slack.le(least).and(steep);
                if QUERY == ANY {
                    let hidden = mask.and(sure).and(leg.after.lt(low)).and(high.lt(*t_max));
                    if hidden.any() {
                        *t_max = S::F16::splat(f32::NEG_INFINITY).or_else(hidden, *t_max);
                        changed = true;
                        mask = mask.without(hidden);
                    }
                }
                if mask.any() {
                    let triangle = TriangleV {
                        v0: lane3::<S>(&block.v0, lane),
                        e1: lane3::<S>(&block.e1, lane),
                        e2: lane3::<S>(&block.e2, lane),
                        normal,
                    };
                    let mut hits = triangle.confirm(ray, inverse.xor(sign), t, mask, sure);
                    if hits.unsure.any() {
                        // SAFETY: the caller's.
                        unsafe { S::run(Decide { leg, triangle: &block.get(lane), hits: &mut hits }) };
                    }
                    changed |= self.offer::<QUERY>(&hits, leg, primitive, t_max);
                }
            }
            lane += 1;
        }
        changed
    }

    /// Takes hits that count where they are the best; whether there are such.
    #[inline(always)]
    pub(super) fn offer<const QUERY: Query>(
        &mut self,
        hits: &ConfirmedV<S::F16>,
        leg: &Leg<S>,
        primitive: u32,
        t_max: &mut S::F16,
    ) -> bool {
        let (mut counts, t) = (hits.counts, hits.t);
        if let Some((near, far)) = leg.world_interval {
            counts = counts.and(near.le(far.min(t)));
        }
        if QUERY == ANY {
            let hidden = counts.and(t.le(*t_max));
            *t_max = S::F16::splat(f32::NEG_INFINITY).or_else(hidden, *t_max);
            return hidden.any();
        }
        let (instance_v, primitive_v) =
            (S::F16::splat(f32::from_bits(leg.instance)), S::F16::splat(f32::from_bits(primitive)));
        let mut better = counts.and(t.lt(*t_max));
        let ties = counts.and(t.le(*t_max)).without(better);
        if ties.any() {
            let same = instance_v.same_bits(self.instance).and(primitive_v.bits_below(self.primitive));
            better = better.or(ties.and(instance_v.bits_below(self.instance).or(same)));
        }
        *t_max = t.or_else(better, *t_max);
        self.u = hits.u.or_else(better, self.u);
        self.v = hits.v.or_else(better, self.v);
        self.primitive = primitive_v.or_else(better, self.primitive);
        self.instance = instance_v.or_else(better, self.instance);
        better.any()
    }
}

/// Core decides about rays that are not sure, one by one: a function of its own, since it is rare and large.
struct Decide<'a, S: Simd> {
    leg: &'a Leg<S>,
    triangle: &'a PackedTriangle,
    hits: &'a mut ConfirmedV<S::F16>,
}

impl<S: Simd> Kernel for Decide<'_, S> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<X: Simd>(self) {
        let Decide { leg, triangle, hits } = self;
        let (origin, direction) = (arrays::<S>(&leg.ray.origin), arrays::<S>(&leg.ray.direction));
        let t_min = leg.ray.t_min.to_array();
        let (mut t, mut u, mut v) = (hits.t.to_array(), hits.u.to_array(), hits.v.to_array());
        let mut counts = hits.counts.bits();
        let mut lanes = hits.unsure.bits();
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 15;
            lanes &= lanes - 1;
            let (o, d) = (lane_of(&origin, lane), lane_of(&direction, lane));
            let ray = LocalRay::new(o, d, t_min.as_ref()[lane], leg.extent);
            let hit = triangle.test(&ray, false);
            counts |= (hit.counts(&ray) as u32) << lane;
            t.as_mut()[lane] = hit.t;
            u.as_mut()[lane] = hit.u;
            v.as_mut()[lane] = hit.v;
        }
        hits.counts = MaskOf::<S>::from_bits(counts);
        hits.t = S::F16::from_array(&t);
        hits.u = S::F16::from_array(&u);
        hits.v = S::F16::from_array(&v);
    }
}
