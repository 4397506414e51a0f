//! Four triangles against the rays of packets.

use super::decide::Decide;
use super::few::{FEW, hide};
use super::interval::Interval;
use super::look::{Look, Shared, lane3};
use super::{Best, LocalPacket, MaskOf, Packet, PartMask, Query16, TO_LOW};
use crate::bvh8::TriangleBlock;
use crate::bvh8::trace::found::{ANY, Query};
use crate::bvh8::trace::lanes::{Determinant, EdgesV, PlanesV, StepTriangles};
use crate::simd::{Float, Mask, Simd};
use std::mem::MaybeUninit;

/// Packets that come to a leaf.
pub(super) struct Leaf<'a, 'b, S: Simd, const N: usize> {
    pub(super) packets: &'a mut [Packet<S>; N],
    pub(super) queries: &'a [Query16<'b, S>; N],
    pub(super) legs: &'a [LocalPacket<'a, S>; N],
    /// Bits of those with rays that enter it.
    pub(super) live: u32,
    /// These rays.
    pub(super) active: &'a [MaskOf<S>; N],
    pub(super) ends: &'a mut [S::F16; N],
}

impl<S: Simd, const N: usize> Leaf<'_, '_, S, N> {
    /// Tests up to four triangles; whether any ray has a new hit. After a first look few rays are left, for which core's
    /// first step is computed.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Closed view: the block is there. One origin: the interval is that of these rays.
    #[inline(always)]
    pub(super) unsafe fn test_block<const QUERY: Query, const ONE_ORIGIN: bool, const IS_LARGE: bool>(
        self,
        number: u32,
        interval: &Interval<S, N>,
    ) -> bool {
        let Leaf { packets, queries, legs, mut live, mut active, ends } = self;
        // SAFETY: closed view: leaves name blocks.
        let block = unsafe { queries[0].bvh.blocks.get_unchecked(number as usize) };
        let skipped = queries[0].skipped(block, legs[0].instance);
        let mut changed = false;
        let mut left = [MaskOf::<S>::from_bits(0); N];
        if QUERY == ANY && IS_LARGE {
            let mut k = 0;
            while k < N {
                left[k] = active[k];
                let rays = active[k].bits();
                if live >> k & 1 == 1 && rays.count_ones() <= FEW {
                    let (hidden, unclear) = hide::<S>(&queries[k], &legs[k], block, skipped, rays, &ends[k]);
                    ends[k].replace(MaskOf::<S>::from_bits(hidden), S::F16::splat(f32::NEG_INFINITY));
                    changed |= hidden != 0;
                    left[k] = MaskOf::<S>::from_bits(unclear);
                    live &= !(u32::from(unclear == 0) << k);
                }
                k += 1;
            }
            if live == 0 {
                return changed;
            }
            active = &left;
        }
        let shared = Shared::new::<S, ONE_ORIGIN, N>(block, interval);
        // Unused lanes come last.
        let used = block.count::<S>();
        let mut looks = [const { MaybeUninit::<Look<S>>::uninit() }; 4];
        let mut lanes = [MaskOf::<S>::from_bits(0); 4];
        let mut k = 0;
        while k < N {
            if (N == 1 && !IS_LARGE) || live >> k & 1 == 1 {
                let leg = &legs[k];
                // First at all triangles: a CPU that guesses wrong what one of them says would have to wait for each.
                let mut left = 0u32;
                let mut lane = 0;
                while lane < used {
                    if skipped >> lane & 1 == 1 {
                        lane += 1;
                        continue;
                    }
                    // SAFETY: one origin: the interval was made for these rays, with as many moments as packets.
                    let look = unsafe {
                        let moment = &*interval.moments.as_ptr().cast::<MaybeUninit<_>>().add(k);
                        shared.look::<S, ONE_ORIGIN>(block, lane, leg, moment, active[k])
                    };
                    left |= u32::from(look.lanes.any()) << lane;
                    lanes[lane & 3] = look.lanes;
                    if QUERY == ANY {
                        looks[lane & 3].write(look);
                    }
                    lane += 1;
                }
                while left != 0 {
                    let lane = left.trailing_zeros() as usize & 3;
                    left &= left - 1;
                    let tested = Tested { number, lane, block, shared: &shared };
                    let (best, query, end) = (&mut packets[k].best, &queries[k], &mut ends[k]);
                    // SAFETY: instruction set and one origin: promised to this function. Written places: for `ANY`, the look is.
                    changed |= unsafe {
                        best.test::<QUERY, ONE_ORIGIN>(query, leg, &tested, lanes[lane], &looks[lane], end)
                    };
                }
            }
            k += 1;
        }
        changed
    }
}

impl<S: Simd> Query16<'_, S> {
    /// Bits of the triangles of a block of this instance that all rays leave out.
    #[inline(always)]
    fn skipped(&self, block: &TriangleBlock, instance: u32) -> u32 {
        let Some(filter) = self.shared_filter else { return 0 };
        // SAFETY: lanes: four numbers of 32 bits are four floats.
        let primitives = unsafe { S::F4::load(block.primitive.as_ptr().cast()) };
        let (start, target) = (filter.start, filter.target);
        // (No closure: it would be compiled for any CPU.)
        let is_start = primitives.same_bits(S::F4::splat(f32::from_bits(start.primitive))).bits();
        let is_target = primitives.same_bits(S::F4::splat(f32::from_bits(target.primitive))).bits();
        is_start & u32::from(start.instance == instance).wrapping_neg()
            | is_target & u32::from(target.instance == instance).wrapping_neg()
    }
}

impl<S: Simd> Best<S> {
    /// Tests the rays that a first look has left.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. One origin: what is shared was made for these rays. Written places: for [`ANY`], the look
    /// is.
    #[inline(always)]
    unsafe fn test<const QUERY: Query, const ONE_ORIGIN: bool>(
        &mut self,
        query: &Query16<S>,
        leg: &LocalPacket<S>,
        tested: &Tested,
        mut lanes: MaskOf<S>,
        look: &MaybeUninit<Look<S>>,
        end: &mut S::F16,
    ) -> bool {
        let Tested { lane, block, shared, .. } = *tested;
        if let Some(filters) = query.lane_filters {
            let sign = Determinant::new(&lane3(&shared.normal, lane), &leg.own.direction).sign;
            lanes = filters.apply(lanes, leg.instance, block.primitive[lane], sign);
        }
        let mut changed = false;
        if QUERY == ANY {
            // SAFETY: one origin and written places: promised to this function.
            let (meets, others) = unsafe {
                shared.meet::<S, ONE_ORIGIN>(block, lane, leg, look.assume_init_ref(), lanes, *end)
            };
            end.replace(meets, S::F16::splat(f32::NEG_INFINITY));
            changed = meets.any();
            lanes = others;
            if !lanes.any() {
                return changed;
            }
        }
        // SAFETY: instruction set and one origin: promised to this function.
        unsafe {
            changed |= self.test_part::<QUERY, ONE_ORIGIN, 0>(query, leg, tested, lanes, end);
            if S::PART == 8 {
                changed |= self.test_part::<QUERY, ONE_ORIGIN, 1>(query, leg, tested, lanes, end);
            }
        }
        changed
    }

    /// # Safety
    /// Instruction set: the CPU has it. One origin: what is shared was made for these rays.
    #[inline(always)]
    unsafe fn test_part<const QUERY: Query, const ONE_ORIGIN: bool, const PART: usize>(
        &mut self,
        query: &Query16<S>,
        leg: &LocalPacket<S>,
        tested: &Tested,
        lanes: MaskOf<S>,
        end: &mut S::F16,
    ) -> bool {
        let Tested { number, lane, block, shared } = *tested;
        let lanes = S::mask_part(lanes, PART);
        if S::PART < 16 && !lanes.any() {
            return false;
        }
        let rays = leg.step_rays(PART);
        // SAFETY: one origin: promised to this function.
        let triangle = unsafe { shared.triangle::<S, ONE_ORIGIN>(block, lane, leg, PART) };
        let determinant = Determinant::new(&lane3(&shared.normal, lane), &rays.direction);
        let slack = triangle.plane.slack(rays.edge_slack);
        let planes = triangle.plane.meet(rays.length, &determinant, slack);
        let lanes = lanes.without(planes.is_beyond(rays.t_min, S::part(end, PART)));
        if QUERY != ANY && !lanes.any() {
            return false;
        }
        let StepTriangles { from_origin, e1, e2, .. } = &triangle;
        let edges = EdgesV::new(from_origin, e1, e2, &rays.direction, &determinant);
        let lanes = lanes.without(edges.least.lt(slack.negate()));
        if !lanes.any() {
            return false;
        }
        let place = number << 2 | lane as u32;
        let clear = lanes.and(planes.is_clear(&rays, &edges, slack, determinant.size));
        let candidates = Candidates { part: PART, planes, edges, place, lanes, clear };
        // SAFETY: instruction set: promised to this function.
        unsafe { self.offer::<QUERY>(query, &candidates, leg, end) }
    }

    /// Takes what the first step says of a triangle; whether any ray has a new hit.
    ///
    /// # Safety
    /// Instruction set: the CPU has it.
    #[inline(always)]
    unsafe fn offer<const QUERY: Query>(
        &mut self,
        query: &Query16<S>,
        candidates: &Candidates<S>,
        leg: &LocalPacket<S>,
        ends: &mut S::F16,
    ) -> bool {
        let Candidates { part, planes, edges, place, lanes: mask, clear } = candidates;
        let (part, place, mask, clear) = (*part, *place, *mask, *clear);
        let end = S::part(ends, part);
        let block = &query.bvh.blocks[(place >> 2) as usize];
        let primitive = block.primitive[(place & 3) as usize];
        if QUERY == ANY {
            S::part_mut(ends, part).replace(clear, S::Part::splat(f32::NEG_INFINITY));
            let unclear = mask.without(clear);
            let mut changed = clear.any();
            if unclear.any() {
                let nothing = S::Part::splat(0.0);
                let mut own_ends = *ends;
                let decide = Decide::<S, QUERY> {
                    query,
                    leg,
                    place,
                    first: part * S::PART,
                    lanes: unclear.bits(),
                    clear: 0,
                    t: nothing,
                    error: nothing,
                    u: nothing,
                    v: nothing,
                    best: self,
                    ends: &mut own_ends,
                };
                // SAFETY: instruction set: promised to this function.
                changed |= unsafe { S::run(decide) };
                *ends = own_ends;
            }
            return changed;
        }
        let (u, v) = (edges.u.mul(planes.inverse), edges.v.mul(planes.inverse));
        let best_t = S::part(&self.t, part);
        let low = best_t.sub(S::Part::splat(TO_LOW).mul(end.sub(best_t)));
        // NaN where nothing was met so far, without an end.
        let better = clear.without(low.le(planes.high));
        let mut changed = better.any();
        let (place_v, primitive_v) =
            (S::Part::splat(f32::from_bits(place)), S::Part::splat(f32::from_bits(primitive)));
        let instance_v = S::Part::splat(f32::from_bits(leg.instance));
        if changed {
            S::part_mut(ends, part).replace(better, planes.high);
            self.take(part, better, [planes.t, u, v, place_v, primitive_v]);
            // The world comes first.
            if leg.instance != 0 {
                S::part_mut(&mut self.instance, part).replace(better, instance_v);
            }
            self.precise &= !(better.bits() << (part * S::PART));
        }
        // What is not beyond the best hit and not before it, or not clear.
        let mut lanes = mask.without(better);
        if lanes.any() {
            // What has been cut is met again.
            let is_primitive = S::part(&self.primitive, part).same_bits(primitive_v);
            let is_instance = S::part(&self.instance, part).same_bits(instance_v);
            lanes = lanes.without(is_primitive.and(is_instance));
        }
        if lanes.any() {
            let (t, error, mut own_ends) = (planes.t, planes.error, *ends);
            let decide = Decide::<S, QUERY> {
                query,
                leg,
                place,
                first: part * S::PART,
                lanes: lanes.bits(),
                clear: clear.bits(),
                t,
                error,
                u,
                v,
                best: self,
                ends: &mut own_ends,
            };
            // SAFETY: instruction set: promised to this function.
            changed |= unsafe { S::run(decide) };
            *ends = own_ends;
        }
        changed
    }

    /// Takes better hits: t, u, v, place and primitive.
    #[inline(always)]
    fn take(&mut self, part: usize, better: PartMask<S>, hits: [S::Part; 5]) {
        let [t, u, v, place, primitive] = hits;
        S::part_mut(&mut self.t, part).replace(better, t);
        S::part_mut(&mut self.u, part).replace(better, u);
        S::part_mut(&mut self.v, part).replace(better, v);
        S::part_mut(&mut self.place, part).replace(better, place);
        S::part_mut(&mut self.primitive, part).replace(better, primitive);
    }
}

/// A triangle of a block that is tested.
#[derive(Clone, Copy)]
struct Tested<'a> {
    number: u32,
    lane: usize,
    block: &'a TriangleBlock,
    shared: &'a Shared,
}

/// Rays of a part that may meet a triangle.
struct Candidates<S: Simd> {
    part: usize,
    planes: PlanesV<S::Part>,
    edges: EdgesV<S::Part>,
    /// As [`Found::place`].
    place: u32,
    lanes: PartMask<S>,
    clear: PartMask<S>,
}
