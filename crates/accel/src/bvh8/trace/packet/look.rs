//! A first look at the triangles of a block: which of sixteen rays may meet one.

use super::interval::Interval;
use super::{Leg, MaskOf};
use crate::bvh8::TriangleBlock;
use crate::bvh8::trace::lanes::{Determinant, StepTriangles, distance as distance_of};
use crate::bvh8::trace::walk::{ANY, Query};
use crate::simd::{Float, Mask, Simd, Vec3V, cross, dot, each, subtract};
use eosphor_core::intersect::{T_SLACK, T_UNDERFLOW, UNDERFLOW_SLACK};
use std::mem::MaybeUninit;

/// Rays of many origins: over the sum of core's edge slack (8 · 2^-24), its rounding (6 · 2^-24), that of products with
/// moments (7 · 2^-24), and that of the third edge function (4 · 2^-24).
const BOTH_SLACKS: f32 = 4.0;

/// What is the same for all rays about the triangles of a block: a triangle a lane, in memory.
pub(super) struct Shared {
    pub(super) normal: [[f32; 4]; 3],
    /// More than both that rounding and core's can change edge functions by, with its sign turned; for rays of one origin,
    /// times the rays' [`EDGE_SLACK`](eosphor_core::intersect::EDGE_SLACK).
    both_slacks: [f32; 4],
    /// For [`ANY`].
    numerators: MaybeUninit<Numerators>,
    /// For rays of one origin.
    seen: MaybeUninit<Seen>,
    /// For rays of many: the edges from the first vertex.
    edges: MaybeUninit<[[[f32; 4]; 3]; 2]>,
}

/// The normal's product with the first vertex, as seen from where all rays start, or from 0; and what that, less the product
/// with the rays' origins, may be wrong by.
struct Numerators {
    value: [f32; 4],
    slack: [f32; 4],
}

/// Triangles as seen from one point.
struct Seen {
    /// With C the first vertex as seen from there: C × e2 and C × e1, turned so that the edge functions are products with
    /// the direction, but for rounding.
    function_u: [[f32; 4]; 3],
    function_v: [[f32; 4]; 3],
    /// As in [`StepTriangles`].
    from_origin: [[f32; 4]; 3],
    distance: [f32; 4],
    distance_with_lengths: [f32; 4],
    numerator: [f32; 4],
}

/// A first look at a triangle.
pub(super) struct Look<S: Simd> {
    pub(super) determinant: Determinant<S::F16>,
    /// The least edge function, and by how much it may differ from the true one and from core's, with its sign turned.
    least: S::F16,
    outside: S::F16,
    /// Rays that may meet it.
    pub(super) lanes: MaskOf<S>,
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
pub(super) fn lane3<F: Float>(v: &[[f32; 4]; 3], lane: usize) -> Vec3V<F> {
    each!(k => F::splat(v[k][lane]))
}

impl Shared {
    #[inline(always)]
    pub(super) fn new<S: Simd, const QUERY: Query, const ONE_ORIGIN: bool, const N: usize>(
        block: &TriangleBlock,
        interval: &Interval<S, N>,
    ) -> Shared {
        let v0 = load3::<S>(&block.v0);
        let e1 = subtract(&load3::<S>(&block.v1), &v0);
        let e2 = subtract(&load3::<S>(&block.v2), &v0);
        let normal = cross(&e1, &e2);
        let lengths = S::F4::from_array(&block.lengths);
        let (mut numerators, mut seen, mut edges) =
            (MaybeUninit::uninit(), MaybeUninit::uninit(), MaybeUninit::uninit());
        let (distance, numerator, both_slacks);
        if ONE_ORIGIN {
            let from_origin = subtract(&v0, &each!(k => S::F4::splat(interval.origin[k])));
            distance = distance_of(&from_origin, S::F4::splat(interval.origin[3]));
            let distance_with_lengths = distance.add(lengths.abs());
            numerator = dot(&normal, &from_origin);
            both_slacks = S::F4::splat(-2.0).mul(distance_with_lengths).mul(lengths);
            seen.write(Seen {
                function_u: store3::<S>(&cross(&e2, &from_origin)),
                function_v: store3::<S>(&cross(&e1, &from_origin)),
                from_origin: store3::<S>(&from_origin),
                distance: distance.to_array(),
                distance_with_lengths: distance_with_lengths.to_array(),
                numerator: numerator.to_array(),
            });
        } else {
            distance = S::F4::splat(interval.most_distance);
            numerator = dot(&normal, &v0);
            both_slacks = S::F4::splat(-BOTH_SLACKS * interval.most_distance * interval.most_slack)
                .fma(lengths, S::F4::splat(-UNDERFLOW_SLACK));
        }
        if !ONE_ORIGIN {
            edges.write([store3::<S>(&e1), store3::<S>(&e2)]);
        }
        if QUERY == ANY {
            let product = S::F4::splat(T_SLACK).mul(S::F4::from_array(&block.product));
            let slack = product.fma(distance, S::F4::splat(T_UNDERFLOW)).to_array();
            numerators.write(Numerators { value: numerator.to_array(), slack });
        }
        Shared { normal: store3::<S>(&normal), both_slacks: both_slacks.to_array(), numerators, seen, edges }
    }

    /// The edges of one of the triangles.
    ///
    /// # Safety
    /// It was made for such rays.
    #[inline(always)]
    unsafe fn edges<F: Float, const ONE_ORIGIN: bool>(
        &self,
        block: &TriangleBlock,
        lane: usize,
    ) -> (Vec3V<F>, Vec3V<F>) {
        if ONE_ORIGIN {
            let v0 = lane3(&block.v0, lane);
            return (subtract(&lane3(&block.v1, lane), &v0), subtract(&lane3(&block.v2, lane), &v0));
        }
        // SAFETY: the caller's.
        let [e1, e2] = unsafe { self.edges.assume_init_ref() };
        (lane3(e1, lane), lane3(e2, lane))
    }

    /// # Safety
    /// It was made for rays of one origin.
    #[inline(always)]
    unsafe fn seen(&self) -> &Seen {
        // SAFETY: the caller's.
        unsafe { self.seen.assume_init_ref() }
    }

    /// Lets pass the rays that may meet one of the triangles, of these: with edges a little further out than core's, and
    /// with edge functions of fewer operations.
    ///
    /// # Safety
    /// It was made for such rays.
    #[inline(always)]
    pub(super) unsafe fn look<S: Simd, const ONE_ORIGIN: bool>(
        &self,
        block: &TriangleBlock,
        lane: usize,
        leg: &Leg<S>,
        moment: &MaybeUninit<Vec3V<S::F16>>,
        active: MaskOf<S>,
    ) -> Look<S> {
        let direction = &leg.own.direction;
        let determinant = Determinant::new(&lane3(&self.normal, lane), direction);
        let Determinant { sign, size } = determinant;
        let both_slacks = S::F16::splat(self.both_slacks[lane]);
        let (u, v, outside);
        if ONE_ORIGIN {
            // SAFETY: the caller's.
            let seen = unsafe { self.seen() };
            u = dot(&lane3(&seen.function_u, lane), direction);
            v = dot(&lane3(&seen.function_v, lane), direction);
            outside = leg.local.edge_slack.fma(both_slacks, S::F16::splat(-UNDERFLOW_SLACK));
        } else {
            let v0 = lane3::<S::F16>(&block.v0, lane);
            // SAFETY: they do not start at one point.
            let moment = unsafe { moment.assume_init_ref() };
            // The first vertex cross the direction, less the moment.
            let r = [
                v0[1].fms(direction[2], v0[2].fma(direction[1], moment[0])),
                v0[2].fms(direction[0], v0[0].fma(direction[2], moment[1])),
                v0[0].fms(direction[1], v0[1].fma(direction[0], moment[2])),
            ];
            // SAFETY: the caller's.
            let (e1, e2) = unsafe { self.edges::<_, false>(block, lane) };
            u = dot(&r, &e2);
            v = dot(&r, &e1);
            outside = both_slacks;
        }
        let (u, v) = (u.xor(sign), v.xor(sign.negate()));
        let least = u.min(v).min(size.sub(u).sub(v));
        Look { determinant, least, outside, lanes: active.without(least.lt(outside)) }
    }

    /// Of the rays that may meet a triangle, those that meet it for certain, and those that may do so between their ends.
    /// Double precision would say the same: its errors are nothing beside these bounds. Of rays that are within the edges for
    /// certain, they hold: the determinant is three times what edge functions may be wrong by.
    ///
    /// # Safety
    /// It was made for [`ANY`].
    #[inline(always)]
    pub(super) unsafe fn meet<S: Simd, const ONE_ORIGIN: bool>(
        &self,
        block: &TriangleBlock,
        lane: usize,
        leg: &Leg<S>,
        look: &Look<S>,
        lanes: MaskOf<S>,
        end: S::F16,
    ) -> (MaskOf<S>, MaskOf<S>) {
        let Determinant { sign, size } = look.determinant;
        // SAFETY: the caller's.
        let numerators = unsafe { self.numerators.assume_init_ref() };
        let mut numerator = S::F16::splat(numerators.value[lane]);
        if !ONE_ORIGIN {
            let (normal, origin) = (lane3::<S::F16>(&self.normal, lane), &leg.own.origin);
            let behind =
                normal[2].fma(origin[2], normal[1].fma(origin[1], normal[0].fms(origin[0], numerator)));
            numerator = behind.negate();
        }
        let inverse = S::F16::splat(1.0).div(size);
        let t = numerator.xor(sign).mul(inverse);
        let slack = S::F16::splat(T_SLACK * block.product[lane]);
        let along = t.abs().mul(leg.local.length);
        let error = along.fma(slack, S::F16::splat(numerators.slack[lane])).mul(inverse);
        let (low, high, t_min) = (t.sub(error), t.add(error), leg.local.t_min);
        let inside = lanes.and(look.outside.negate().le(look.least));
        let beyond = inside.and(high.lt(t_min).or(end.lt(low)));
        let meets = inside.and(t_min.lt(low)).and(high.le(leg.own.t_max));
        (meets, lanes.without(beyond).without(meets))
    }

    /// One of the triangles, as seen from the origin of each ray of a part.
    ///
    /// # Safety
    /// It was made for such rays.
    #[inline(always)]
    pub(super) unsafe fn triangle<S: Simd, const ONE_ORIGIN: bool>(
        &self,
        block: &TriangleBlock,
        lane: usize,
        leg: &Leg<S>,
        part: usize,
    ) -> StepTriangles<S::Part> {
        let lengths = S::Part::splat(block.lengths[lane]);
        let (from_origin, distance, distance_with_lengths, numerator);
        if ONE_ORIGIN {
            // SAFETY: the caller's.
            let seen = unsafe { self.seen() };
            from_origin = lane3(&seen.from_origin, lane);
            distance = S::Part::splat(seen.distance[lane]);
            distance_with_lengths = S::Part::splat(seen.distance_with_lengths[lane]);
            numerator = S::Part::splat(seen.numerator[lane]);
        } else {
            from_origin = subtract(&lane3(&block.v0, lane), &each!(k => S::part(&leg.own.origin[k], part)));
            distance = distance_of(&from_origin, S::part(&leg.local.reach, part));
            distance_with_lengths = distance.add(lengths.abs());
            numerator = dot(&lane3(&self.normal, lane), &from_origin);
        }
        // SAFETY: the caller's.
        let (e1, e2) = unsafe { self.edges::<_, ONE_ORIGIN>(block, lane) };
        StepTriangles {
            e1,
            e2,
            product: S::Part::splat(block.product[lane]),
            lengths,
            from_origin,
            distance,
            distance_with_lengths,
            numerator,
        }
    }
}
