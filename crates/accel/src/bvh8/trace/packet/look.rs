//! A first look at the triangles of a block: which of sixteen rays may meet one.

use super::interval::Interval;
use super::{LocalPacket, MaskOf};
use crate::bvh8::TriangleBlock;
use crate::bvh8::trace::lanes::{Determinant, StepPlanes, StepTriangles, distance as distance_of};
use crate::simd::{Float, Mask, Simd, Vec3V, cross, dot, each, subtract};
use eosphor_core::intersect::UNDERFLOW_SLACK;
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
    /// For rays of one origin.
    seen: MaybeUninit<Seen>,
    /// For rays of many: the edges from the first vertex.
    edges: MaybeUninit<[[[f32; 4]; 3]; 2]>,
}

/// Triangles as seen from one point.
struct Seen {
    /// With C the first vertex as seen from there: C × e2 and C × e1, turned so that the edge functions are products with
    /// the direction, but for rounding.
    function_u: [[f32; 4]; 3],
    function_v: [[f32; 4]; 3],
    /// As in [`StepPlanes`].
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
    pub(super) fn new<S: Simd, const ONE_ORIGIN: bool, const N: usize>(
        block: &TriangleBlock,
        interval: &Interval<S, N>,
    ) -> Shared {
        let v0 = load3::<S>(&block.v0);
        let e1 = subtract(&load3::<S>(&block.v1), &v0);
        let e2 = subtract(&load3::<S>(&block.v2), &v0);
        let normal = cross(&e1, &e2);
        let lengths = S::F4::from_array(&block.lengths);
        let (mut seen, mut edges) = (MaybeUninit::uninit(), MaybeUninit::uninit());
        let both_slacks;
        if ONE_ORIGIN {
            let from_origin = subtract(&v0, &each!(k => S::F4::splat(interval.origin[k])));
            let distance = distance_of(&from_origin, S::F4::splat(interval.origin[3]), lengths);
            let distance_with_lengths = distance.add(lengths.abs());
            both_slacks = S::F4::splat(-2.0).mul(distance_with_lengths).mul(lengths);
            seen.write(Seen {
                function_u: store3::<S>(&cross(&e2, &from_origin)),
                function_v: store3::<S>(&cross(&e1, &from_origin)),
                from_origin: store3::<S>(&from_origin),
                distance: distance.to_array(),
                distance_with_lengths: distance_with_lengths.to_array(),
                numerator: dot(&normal, &from_origin).to_array(),
            });
        } else {
            // From 0, where moments are counted from.
            let distance =
                distance_of(&v0, S::F4::splat(interval.origin_distance), lengths).add(lengths.abs());
            both_slacks = S::F4::splat(-BOTH_SLACKS * interval.most_slack)
                .mul(distance)
                .fma(lengths, S::F4::splat(-UNDERFLOW_SLACK));
            edges.write([store3::<S>(&e1), store3::<S>(&e2)]);
        }
        Shared { normal: store3::<S>(&normal), both_slacks: both_slacks.to_array(), seen, edges }
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
        // SAFETY: one origin: it was made for others, as promised to this function.
        let [e1, e2] = unsafe { self.edges.assume_init_ref() };
        (lane3(e1, lane), lane3(e2, lane))
    }

    /// # Safety
    /// It was made for rays of one origin.
    #[inline(always)]
    unsafe fn seen(&self) -> &Seen {
        // SAFETY: one origin: it was made for such rays, as promised to this function.
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
        leg: &LocalPacket<S>,
        moment: &MaybeUninit<Vec3V<S::F16>>,
        active: MaskOf<S>,
    ) -> Look<S> {
        let direction = &leg.own.direction;
        let determinant = Determinant::new(&lane3(&self.normal, lane), direction);
        let Determinant { sign, size } = determinant;
        let both_slacks = S::F16::splat(self.both_slacks[lane]);
        let (u, v, outside);
        if ONE_ORIGIN {
            // SAFETY: one origin: it was made for these rays, as promised to this function.
            let seen = unsafe { self.seen() };
            u = dot(&lane3(&seen.function_u, lane), direction);
            v = dot(&lane3(&seen.function_v, lane), direction);
            outside = leg.local.edge_slack.fma(both_slacks, S::F16::splat(-UNDERFLOW_SLACK));
        } else {
            let v0 = lane3::<S::F16>(&block.v0, lane);
            // SAFETY: one origin: it was made for others, as promised to this function, and their moments have been written.
            let moment = unsafe { moment.assume_init_ref() };
            // The first vertex cross the direction, less the moment.
            let r = [
                v0[1].fms(direction[2], v0[2].fma(direction[1], moment[0])),
                v0[2].fms(direction[0], v0[0].fma(direction[2], moment[1])),
                v0[0].fms(direction[1], v0[1].fma(direction[0], moment[2])),
            ];
            // SAFETY: one origin: it was made for others, as promised to this function.
            let (e1, e2) = unsafe { self.edges::<_, false>(block, lane) };
            u = dot(&r, &e2);
            v = dot(&r, &e1);
            outside = both_slacks;
        }
        let (u, v) = (u.xor(sign), v.xor(sign.negate()));
        let least = u.min(v).min(size.sub(u).sub(v));
        Look { determinant, least, outside, lanes: active.without(least.lt(outside)) }
    }

    /// Of the rays that may meet a triangle, those that meet it for certain, and those that may do so between their ends. The
    /// bounds of `t` are core's, which follow from how far each ray starts from the triangle: bounds of the whole tree would
    /// leave most rays that start near a small triangle undecided.
    ///
    /// # Safety
    /// It was made for such rays.
    #[inline(always)]
    pub(super) unsafe fn meet<S: Simd, const ONE_ORIGIN: bool>(
        &self,
        block: &TriangleBlock,
        lane: usize,
        leg: &LocalPacket<S>,
        look: &Look<S>,
        lanes: MaskOf<S>,
        end: S::F16,
    ) -> (MaskOf<S>, MaskOf<S>) {
        let local = leg.local;
        // SAFETY: one origin: it was made for these rays, as promised to this function.
        let (_, plane) = unsafe { self.plane::<_, ONE_ORIGIN>(block, lane, &leg.own.origin, local.reach) };
        let slack = plane.slack(local.edge_slack);
        let planes = plane.meet(local.length, &look.determinant, slack);
        let beyond = planes.is_beyond(local.t_min, end);
        // Core would say the same of these edges: they are further in than it asks for.
        let inside = lanes.and(look.outside.negate().le(look.least)).and(planes.is_steep);
        let meets = inside.and(local.t_min.lt(planes.low)).and(planes.high.le(leg.own.t_max));
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
        leg: &LocalPacket<S>,
        part: usize,
    ) -> StepTriangles<S::Part> {
        let origin = each!(k => S::part(&leg.own.origin[k], part));
        // SAFETY: one origin: it was made for these rays, as promised to this function.
        unsafe {
            let (from_origin, plane) =
                self.plane::<_, ONE_ORIGIN>(block, lane, &origin, S::part(&leg.local.reach, part));
            let (e1, e2) = self.edges::<_, ONE_ORIGIN>(block, lane);
            StepTriangles { e1, e2, from_origin, plane }
        }
    }

    /// The first vertex and the plane of one of the triangles, as seen from these origins of rays with this reach.
    ///
    /// # Safety
    /// It was made for such rays.
    #[inline(always)]
    unsafe fn plane<F: Float, const ONE_ORIGIN: bool>(
        &self,
        block: &TriangleBlock,
        lane: usize,
        origin: &Vec3V<F>,
        reach: F,
    ) -> (Vec3V<F>, StepPlanes<F>) {
        let lengths = F::splat(block.lengths[lane]);
        let (from_origin, distance, distance_with_lengths, numerator);
        if ONE_ORIGIN {
            // SAFETY: one origin: it was made for these rays, as promised to this function.
            let seen = unsafe { self.seen() };
            from_origin = lane3(&seen.from_origin, lane);
            distance = F::splat(seen.distance[lane]);
            distance_with_lengths = F::splat(seen.distance_with_lengths[lane]);
            numerator = F::splat(seen.numerator[lane]);
        } else {
            from_origin = subtract(&lane3(&block.v0, lane), origin);
            distance = distance_of(&from_origin, reach, lengths);
            distance_with_lengths = distance.add(lengths.abs());
            numerator = dot(&lane3(&self.normal, lane), &from_origin);
        }
        let product = F::splat(block.product[lane]);
        (from_origin, StepPlanes { product, lengths, distance, distance_with_lengths, numerator })
    }
}
