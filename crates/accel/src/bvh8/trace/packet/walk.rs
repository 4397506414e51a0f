//! The way of a group of rays through a tree.

use super::alone::SingleRays;
use super::block::Leaf;
use super::interval::Interval;
use super::{LocalPacket, MaskOf, Packet, Query16};
use crate::bvh8::trace::found::{ANY, Query, STACK};
use crate::bvh8::trace::single::{near_and_far_planes, planes};
use crate::bvh8::{Child, LEAF, Node8, PLACE, SPHERE, TriangleBlock};
use crate::simd::{Float, Kernel, Mask, Simd, each};
use std::mem::MaybeUninit;

/// A place on the stack: a child, and from bit 32 on a bit for each packet that has rays which enter it. (One number, since a
/// CPU waits where it has to put together what it reads from what was just written.)
type Waiting = u64;

/// Room for where rays enter what waits on the stack: of groups, more than a function's own stack should hold.
pub(in super::super) type Room<S, const N: usize> = MaybeUninit<[[<S as Simd>::F16; N]; STACK]>;

/// Says that a child will be looked at soon.
#[inline(always)]
fn prefetch<S: Simd>(nodes: &[Node8], blocks: &[TriangleBlock], child: Child) {
    let place = (child & PLACE) as usize;
    let at = if child & LEAF == 0 {
        nodes.as_ptr().wrapping_add(place).cast::<u8>()
    } else {
        blocks.as_ptr().wrapping_add(place).cast::<u8>()
    };
    S::prefetch(at);
    S::prefetch(at.wrapping_add(64));
    S::prefetch(at.wrapping_add(128));
    S::prefetch(at.wrapping_add(192));
}

/// The walk of a group, of N packets: a function of its own, which keeps the code small.
pub(super) struct Walk<'a, 'b, S: Simd, const QUERY: Query, const INSTANCES: bool, const N: usize> {
    pub(super) packets: &'a mut [Packet<S>; N],
    pub(super) queries: &'a [Query16<'b, S>; N],
    pub(super) root: Child,
    pub(super) legs: &'a [LocalPacket<'a, S>; N],
    pub(super) singles: &'a mut [SingleRays<'b>; N],
    pub(super) groups: [MaskOf<S>; N],
    pub(super) octant: usize,
    pub(super) room: &'a mut Room<S, N>,
}

/// The latest of the ends of rays.
#[inline(always)]
fn latest_of<S: Simd, const N: usize>(ends: &[S::F16; N], groups: &[MaskOf<S>; N]) -> f32 {
    let nowhere = S::F16::splat(f32::NEG_INFINITY);
    let mut latest = nowhere;
    let mut k = 1;
    while k < N {
        latest = latest.max(ends[k].or_else(groups[k], nowhere));
        k += 1;
    }
    latest.max(ends[0].or_else(groups[0], nowhere)).largest(MaskOf::<S>::from_bits(0xffff))
}

impl<S: Simd, const QUERY: Query, const INSTANCES: bool, const N: usize> Kernel
    for Walk<'_, '_, S, QUERY, INSTANCES, N>
{
    type Output = ();

    #[inline(always)]
    unsafe fn run<X: Simd>(self) {
        // SAFETY: instruction set: promised to this function.
        unsafe { self.visit::<false>() };
    }
}

/// The same through a tree that is large ([`LARGE`](super::few::LARGE)).
pub(super) struct WalkLarge<'a, 'b, S: Simd, const QUERY: Query, const INSTANCES: bool, const N: usize>(
    pub(super) Walk<'a, 'b, S, QUERY, INSTANCES, N>,
);

impl<S: Simd, const QUERY: Query, const INSTANCES: bool, const N: usize> Kernel
    for WalkLarge<'_, '_, S, QUERY, INSTANCES, N>
{
    type Output = ();

    #[inline(always)]
    unsafe fn run<X: Simd>(self) {
        // (Never called of others, which then need not be compiled.)
        if QUERY == ANY && !INSTANCES {
            // SAFETY: instruction set: promised to this function.
            unsafe { self.0.visit::<true>() };
        }
    }
}

impl<S: Simd, const QUERY: Query, const INSTANCES: bool, const N: usize>
    Walk<'_, '_, S, QUERY, INSTANCES, N>
{
    /// Visits the leaves that a group of rays enters, roughly from near to far.
    ///
    /// # Safety
    /// Instruction set: the CPU has it.
    #[inline(always)]
    unsafe fn visit<const IS_LARGE: bool>(self) {
        // One by one: the compiler would load several at once from where they were just stored one by one, for which the CPU has
        // to wait until the stores are over.
        // SAFETY: written places: the fields are live, and not used again.
        let (packets, queries, legs, singles) = unsafe {
            (
                std::ptr::read_volatile(&raw const self.packets),
                std::ptr::read_volatile(&raw const self.queries),
                std::ptr::read_volatile(&raw const self.legs),
                std::ptr::read_volatile(&raw const self.singles),
            )
        };
        let (root, groups, octant) = (self.root, self.groups, self.octant);
        let bvh = queries[0].bvh;
        let nodes = if INSTANCES { bvh.instance_nodes } else { bvh.nodes };
        let leaves_by_bounds = queries[0].leaves_by_bounds;
        let boxes_extent = if INSTANCES { bvh.instance_bounds.extent() } else { legs[0].extent };
        let interval = Interval::<S, N>::new(legs, boxes_extent, &groups, octant);
        // Not even at infinity.
        let never = S::F16::splat(f32::NAN);
        let [near_planes, far_planes] = near_and_far_planes(octant);
        let mut stack = MaybeUninit::<[Waiting; STACK]>::uninit();
        let (stack, nears) =
            (stack.as_mut_ptr().cast::<Waiting>(), self.room.as_mut_ptr().cast::<[S::F16; N]>());
        let mut count = 0usize;
        let mut at = root;
        let mut members = 0;
        // Where each ray enters the node; NaN where it does not.
        let mut near = [never; N];
        let mut ends = [never; N];
        let mut k = 0;
        while k < N {
            near[k] = legs[k].local.t_min.or_else(groups[k], never);
            ends[k] = packets[k].end;
            members |= u32::from(groups[k].any()) << k;
            k += 1;
        }
        // Of all rays, no earlier than the latest end.
        let mut latest = S::F8::splat(latest_of::<S, N>(&ends, &groups));
        let mut ends_changed = false;
        let mut active = groups;
        loop {
            let mut live = 0;
            k = 0;
            while k < N {
                if N == 1 || members >> k & 1 == 1 {
                    active[k] = near[k].le(ends[k]);
                    let bits = active[k].bits();
                    if bits.count_ones() > queries[k].alone {
                        live |= 1 << k;
                    } else if bits != 0 {
                        packets[k].end = ends[k];
                        let (query, leg, singles) = (&queries[k], &legs[k], &mut singles[k]);
                        // SAFETY: instruction set: a kernel is run below its own. Closed view: the child is one of this tree.
                        unsafe { packets[k].go_on_alone::<QUERY, INSTANCES>(query, at, leg, singles, bits) };
                        ends[k] = packets[k].end;
                        ends_changed = true;
                    }
                }
                k += 1;
            }
            if live == 0 {
                // No one is left.
            } else if at & LEAF == 0 {
                if ends_changed {
                    latest = S::F8::splat(latest_of::<S, N>(&ends, &groups));
                    ends_changed = false;
                }
                // SAFETY: closed view: children are numbers of nodes, and no path is longer than the stack has room for.
                unsafe {
                    let node = nodes.get_unchecked(at as usize);
                    let (ns, no) = (&interval.near_scale, &interval.near_offset);
                    let (fs, fo) = (&interval.far_scale, &interval.far_offset);
                    let [x0, y0, z0] = each!(k => planes::<S>(node, near_planes[k]).fma(ns[k], no[k]));
                    let [x1, y1, z1] = each!(k => planes::<S>(node, far_planes[k]).fma(fs[k], fo[k]));
                    let first = x0.max(y0).max(z0.max(interval.t_min));
                    let last = x1.min(y1).min(z1.min(latest));
                    let order = *node.orders.get_unchecked(octant);
                    let lanes = S::order8(order);
                    let mut entered = S::permute8(first, lanes).le(S::permute8(last, lanes)).bits();
                    debug_assert!(count + 8 <= STACK);
                    while entered != 0 {
                        let place = entered.trailing_zeros();
                        entered &= entered - 1;
                        let slot = (order >> (3 * place) & 7) as usize;
                        if QUERY == ANY && !INSTANCES && leaves_by_bounds {
                            let child = *node.children.get_unchecked(slot);
                            if child & (LEAF | SPHERE) == LEAF {
                                nears.add(count).write(near);
                                prefetch::<S>(nodes, bvh.blocks, child);
                                stack.add(count).write(Waiting::from(child) | Waiting::from(live) << 32);
                                count += 1;
                                continue;
                            }
                        }
                        let box_planes = node.planes.as_ptr().cast::<f32>().add(slot).cast::<u8>();
                        let low = each!(k => S::F16::splat(*box_planes.add(near_planes[k]).cast::<f32>()));
                        let high = each!(k => S::F16::splat(*box_planes.add(far_planes[k]).cast::<f32>()));
                        let child_nears = nears.add(count).cast::<S::F16>();
                        let mut child_members = 0u32;
                        k = 0;
                        while k < N {
                            if N == 1 || live >> k & 1 == 1 {
                                let (slab, t_min) = (&legs[k].local.slab, legs[k].local.t_min);
                                let (i, no, fo) = (&slab.inverse, &slab.near_offset, &slab.far_offset);
                                let [x0, y0, z0] = each!(k => low[k].fma(i[k], no[k]));
                                let [x1, y1, z1] = each!(k => high[k].fma(i[k], fo[k]));
                                let child_near = x0.max(y0).max(z0.max(t_min));
                                let child_far = x1.min(y1).min(z1.min(ends[k]));
                                let enters = child_near.le(child_far).and(active[k]);
                                if enters.any() {
                                    child_nears.add(k).write(child_near.or_else(enters, never));
                                    child_members |= 1 << k;
                                }
                            }
                            k += 1;
                        }
                        if child_members != 0 {
                            let child = *node.children.get_unchecked(slot);
                            if N > 1 {
                                prefetch::<S>(nodes, bvh.blocks, child);
                            }
                            stack.add(count).write(Waiting::from(child) | Waiting::from(child_members) << 32);
                            count += 1;
                        }
                    }
                }
            } else if !INSTANCES && at & SPHERE == 0 {
                let place = at & PLACE;
                let leaf =
                    Leaf { packets: &mut *packets, queries, legs, live, active: &active, ends: &mut ends };
                // SAFETY: closed view: leaves name blocks. One origin: the interval says what these rays are.
                ends_changed |= unsafe {
                    if interval.is_one_origin {
                        leaf.test_block::<QUERY, true, IS_LARGE>(place, &interval)
                    } else {
                        leaf.test_block::<QUERY, false, IS_LARGE>(place, &interval)
                    }
                };
            } else {
                k = 0;
                while k < N {
                    if live >> k & 1 == 1 {
                        let (packet, query, leg, place) =
                            (&mut packets[k], &queries[k], &legs[k], at & PLACE);
                        packet.end = ends[k];
                        // SAFETY: instruction set: a kernel is run below its own. Closed view: the leaf is one of this tree.
                        ends_changed |= unsafe {
                            if INSTANCES {
                                packet.visit_instance::<QUERY>(query, place, leg, active[k])
                            } else {
                                packet.test_sphere::<QUERY>(query, place, leg, active[k].bits())
                            }
                        };
                        ends[k] = packet.end;
                    }
                    k += 1;
                }
            }
            if count == 0 {
                break;
            }
            count -= 1;
            // SAFETY: stack room: places below the count have been written, for these members.
            unsafe {
                let waiting = *stack.add(count);
                (at, members) = (waiting as Child, (waiting >> 32) as u32);
                let from = nears.add(count).cast::<S::F16>();
                k = 0;
                while k < N {
                    if N == 1 || members >> k & 1 == 1 {
                        near[k] = from.add(k).read();
                    }
                    k += 1;
                }
            }
        }
        k = 0;
        while k < N {
            packets[k].end = ends[k];
            k += 1;
        }
    }
}
