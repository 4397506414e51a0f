//! The way of a group of rays through a tree.

use super::alone::SingleRays;
use super::interval::Interval;
use super::{Leg, MaskOf, Packet, Query16};
use crate::bvh8::trace::single::{near_and_far_planes, planes};
use crate::bvh8::trace::walk::{ANY, Query, STACK};
use crate::bvh8::{Child, LEAF, PLACE, SPHERE};
use crate::simd::{Float, Kernel, Mask, Simd, each};
use std::mem::MaybeUninit;

/// The walk of a group: a function of its own, which keeps the code small.
pub(super) struct Walk<'a, 'b, S: Simd, const QUERY: Query, const INSTANCES: bool> {
    pub(super) packet: &'a mut Packet<S>,
    pub(super) query: &'a Query16<'b, S>,
    pub(super) root: Child,
    pub(super) leg: &'a Leg<'a, S>,
    pub(super) singles: &'a mut SingleRays<'b>,
    pub(super) group: MaskOf<S>,
    pub(super) octant: usize,
}

impl<S: Simd, const QUERY: Query, const INSTANCES: bool> Kernel for Walk<'_, '_, S, QUERY, INSTANCES> {
    type Output = ();

    /// Visits the leaves that a group of rays enters, roughly from near to far.
    #[inline(always)]
    unsafe fn run<X: Simd>(self) {
        // One by one: the compiler would load several at once from where they were just stored one by one, for which the CPU has
        // to wait until the stores are over.
        // SAFETY: they are live, and these fields are not used again.
        let (packet, query, leg, singles) = unsafe {
            (
                std::ptr::read_volatile(&raw const self.packet),
                std::ptr::read_volatile(&raw const self.query),
                std::ptr::read_volatile(&raw const self.leg),
                std::ptr::read_volatile(&raw const self.singles),
            )
        };
        let (root, group, octant) = (self.root, self.group, self.octant);
        let bvh = query.bvh;
        let nodes = if INSTANCES { bvh.instance_nodes } else { bvh.nodes };
        let boxes_extent = if INSTANCES { bvh.instance_bounds.extent() } else { leg.extent };
        let interval = Interval::<S>::new(leg, boxes_extent, group, octant);
        let nowhere = S::F16::splat(f32::NEG_INFINITY);
        // Not even at infinity.
        let never = S::F16::splat(f32::NAN);
        // Copies, which the compiler can keep in registers where there are enough.
        let (slab, t_min) = (leg.local.slab, leg.local.t_min);
        let mut end = packet.end;
        let [near_planes, far_planes] = near_and_far_planes(octant);
        let mut children = MaybeUninit::<[Child; STACK]>::uninit();
        let mut nears = MaybeUninit::<[S::F16; STACK]>::uninit();
        let (children, nears) = (children.as_mut_ptr().cast::<Child>(), nears.as_mut_ptr().cast::<S::F16>());
        let mut count = 0usize;
        let mut at = root;
        // Where each ray enters the node; NaN where it does not.
        let mut near = t_min.or_else(group, never);
        let mut latest = S::F8::splat(end.or_else(group, nowhere).largest(group));
        loop {
            let active = near.le(end);
            let bits = active.bits();
            let mut changed = false;
            if bits.count_ones() <= query.alone {
                if bits != 0 {
                    packet.end = end;
                    // SAFETY: the caller's.
                    unsafe { packet.go_on_alone::<QUERY, INSTANCES>(query, at, leg, singles, bits) };
                    end = packet.end;
                    changed = true;
                }
            } else if at & LEAF == 0 {
                // SAFETY: inner nodes are numbers that the builder made; the stack has room by its length.
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
                        let box_planes = node.planes.as_ptr().cast::<f32>().add(slot).cast::<u8>();
                        let [x0, y0, z0] = each!(k => S::F16::splat(*box_planes.add(near_planes[k]).cast::<f32>())
                                .fma(slab.inverse[k], slab.near_offset[k]));
                        let [x1, y1, z1] = each!(k => S::F16::splat(*box_planes.add(far_planes[k]).cast::<f32>())
                                .fma(slab.inverse[k], slab.far_offset[k]));
                        let child_near = x0.max(y0).max(z0.max(t_min));
                        let child_far = x1.min(y1).min(z1.min(end));
                        let enters = child_near.le(child_far).and(active);
                        if enters.any() {
                            *children.add(count) = *node.children.get_unchecked(slot);
                            nears.add(count).write(child_near.or_else(enters, never));
                            count += 1;
                        }
                    }
                }
            } else if INSTANCES {
                packet.end = end;
                // SAFETY: the caller's.
                changed = unsafe { packet.visit_instance::<QUERY>(query, at & PLACE, leg, active) };
                end = packet.end;
            } else if at & SPHERE != 0 {
                packet.end = end;
                // SAFETY: the caller's.
                changed = unsafe { packet.test_sphere::<QUERY>(query, at & PLACE, leg, bits) };
                end = packet.end;
            } else {
                let (best, place) = (&mut packet.best, at & PLACE);
                // SAFETY: the caller's.
                changed = unsafe {
                    if interval.is_one_origin {
                        best.test_block::<QUERY, true>(query, place, leg, active, &interval, &mut end)
                    } else {
                        best.test_block::<QUERY, false>(query, place, leg, active, &interval, &mut end)
                    }
                };
            }
            if changed {
                if QUERY == ANY && !nowhere.lt(end).and(group).any() {
                    break;
                }
                latest = S::F8::splat(end.largest(group));
            }
            if count == 0 {
                break;
            }
            count -= 1;
            // SAFETY: below the count, the stack has been written.
            unsafe {
                at = *children.add(count);
                near = nears.add(count).read();
            }
        }
        packet.end = end;
    }
}
