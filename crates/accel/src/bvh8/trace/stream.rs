//! Many rays in flight, each on its own way.
//!
//! One ray's next step hangs on the one before, and a step takes some fifty cycles from the node's load to the next node's
//! number. Here 32 rays take their steps in turn: all node steps, then all leaf steps, so that the processor works on
//! several at once, and branches go the same way again and again. Nothing is computed that a single ray would not.

use super::single;
use super::single::{PrimitiveLeaves, SingleRay, VisitLeaf, WORLD, skipped_in};
use super::walk::{ANY, Found, Query, STACK};
use crate::bvh8::{Bvh8, Child, EMPTY, LEAF};
use crate::simd::{Float, Mask, Simd, each};
use eosphor_core::ray::{Ray, RayFilter};
use std::mem::MaybeUninit;

/// Rays in flight.
const SLOTS: usize = 32;
/// Leaf steps wait until there are so many.
const LEAVES_AT_ONCE: usize = 4;

/// The lowest entry of each stack.
const DONE: Child = EMPTY;

/// A ray in flight.
#[repr(C, align(64))]
struct Slot {
    ray: SingleRay,
    found: Found,
    at: Child,
    count: u32,
    /// Its number in the batch.
    number: u32,
    skipped: [u32; 2],
    cull_back_faces: bool,
    nears: [f32; STACK],
    children: [Child; STACK],
}

/// Numbers of slots.
#[derive(Clone, Copy)]
struct List {
    slots: [u8; SLOTS],
    len: usize,
}

impl List {
    const EMPTY: List = List { slots: [0; SLOTS], len: 0 };
}

/// Which list a slot goes to after a step.
const NODE: usize = 0;
const TRIANGLES: usize = 1;
const STALE: usize = 2;
const FINISHED: usize = 3;

/// Where rays come from and answers go to.
pub(super) trait Source {
    /// Number, ray and filter of the next ray.
    fn next(&mut self) -> Option<(u32, &Ray, &RayFilter)>;
    /// Takes what a ray has found.
    fn finish(&mut self, number: u32, found: &Found);
    /// A ray and its filter again.
    fn ray(&self, number: u32) -> (&Ray, &RayFilter);
}

/// Traces all rays of a source.
///
/// # Safety
/// The CPU has the instruction set.
#[inline(always)]
pub(super) unsafe fn trace<S: Simd, const QUERY: Query>(bvh: &Bvh8, source: &mut impl Source) {
    let root = bvh.roots[0];
    let extent = bvh.geometries[0].extent;
    let mut slots = MaybeUninit::<[Slot; SLOTS]>::uninit();
    let slots = slots.as_mut_ptr().cast::<Slot>();
    let mut lists = [List::EMPTY; 4];
    // All slots wait for a ray.
    let mut k = 0;
    while k < SLOTS {
        lists[FINISHED].slots[k] = k as u8;
        k += 1;
    }
    lists[FINISHED].len = SLOTS;
    let mut first_round = true;
    // SAFETY: slots are written before they come into any list but the first; lists hold each slot at most once, so
    // they never run over; the rest is the caller's.
    unsafe {
        loop {
            // Finished rays out, new ones in.
            let finished = lists[FINISHED];
            lists[FINISHED].len = 0;
            let mut k = 0;
            while k < finished.len {
                let slot = &mut *slots.add(finished.slots[k] as usize);
                if !first_round {
                    finish::<S, QUERY>(bvh, slot, source);
                }
                if let Some((number, ray, filter)) = source.next() {
                    (&raw mut slot.ray).write(SingleRay::new::<S>(
                        ray.origin,
                        ray.direction,
                        ray.t_min,
                        extent,
                    ));
                    (&raw mut slot.found).write(Found::nothing(ray.t_max));
                    (slot.number, slot.count, slot.at) = (number, 1, root);
                    slot.skipped = skipped_in(0, filter);
                    slot.cull_back_faces = filter.cull_back_faces;
                    slot.nears[0] = f32::NEG_INFINITY;
                    slot.children[0] = DONE;
                    classify(&mut lists, finished.slots[k], root, false);
                }
                k += 1;
            }
            first_round = false;
            // One step for each ray at a node.
            let nodes = lists[NODE];
            lists[NODE].len = 0;
            let mut k = 0;
            while k < nodes.len {
                let slot = &mut *slots.add(nodes.slots[k] as usize);
                enter::<S, QUERY>(bvh, slot);
                pop::<QUERY>(slot, nodes.slots[k], &mut lists);
                k += 1;
            }
            // Entries that the best hit has overtaken.
            while lists[STALE].len > 0 {
                let stale = lists[STALE];
                lists[STALE].len = 0;
                let mut k = 0;
                while k < stale.len {
                    let slot = &mut *slots.add(stale.slots[k] as usize);
                    pop::<QUERY>(slot, stale.slots[k], &mut lists);
                    k += 1;
                }
            }
            if lists[TRIANGLES].len >= LEAVES_AT_ONCE || lists[NODE].len == 0 {
                let leaves = lists[TRIANGLES];
                lists[TRIANGLES].len = 0;
                let mut k = 0;
                while k < leaves.len {
                    let slot = &mut *slots.add(leaves.slots[k] as usize);
                    let mut visitor = PrimitiveLeaves {
                        bvh,
                        ray: &slot.ray,
                        place: &WORLD,
                        skipped: slot.skipped,
                        cull_back_faces: slot.cull_back_faces,
                    };
                    let at = slot.at;
                    if VisitLeaf::<S>::visit::<QUERY>(&mut visitor, at, &mut slot.found) {
                        classify(&mut lists, leaves.slots[k], DONE, false);
                    } else {
                        pop::<QUERY>(slot, leaves.slots[k], &mut lists);
                    }
                    k += 1;
                }
            }
            let waiting = lists[NODE].len + lists[TRIANGLES].len + lists[STALE].len + lists[FINISHED].len;
            if waiting == 0 {
                return;
            }
        }
    }
}

/// Puts a slot into the list of what it does next.
#[inline(always)]
fn classify(lists: &mut [List; 4], slot: u8, at: Child, stale: bool) {
    let class = if at & LEAF == 0 { NODE } else { TRIANGLES };
    let class = if at == DONE { FINISHED } else { class };
    let list = &mut lists[if stale { STALE } else { class }];
    // SAFETY: a slot is in one list at a time, so there is room.
    unsafe { *list.slots.get_unchecked_mut(list.len) = slot };
    list.len += 1;
}

#[inline(always)]
unsafe fn pop<const QUERY: Query>(slot: &mut Slot, number: u8, lists: &mut [List; 4]) {
    slot.count -= 1;
    let top = slot.count as usize;
    // SAFETY: the lowest entry is the end of the walk.
    unsafe {
        slot.at = *slot.children.get_unchecked(top);
        let stale = QUERY != ANY && *slot.nears.get_unchecked(top) > slot.found.best.t;
        classify(lists, number, slot.at, stale);
    }
}

/// Tests the eight children of a node and puts those that the ray enters onto its stack.
#[inline(always)]
unsafe fn enter<S: Simd, const QUERY: Query>(bvh: &Bvh8, slot: &mut Slot) {
    let ray = &slot.ray;
    let inverse = each!(k => S::F8::splat(ray.inverse[k]));
    let near_planes = each!(k => 2 * k + (ray.octant >> k & 1));
    // SAFETY: inner nodes are numbers that the builder made; stacks have room by their length.
    unsafe {
        let node = bvh.nodes.get_unchecked(slot.at as usize);
        let [x0, y0, z0] = each!(k => single::planes::<S>(node, near_planes[k])
            .fma(inverse[k], S::F8::splat(ray.near_offset[k])));
        let [x1, y1, z1] = each!(k => single::planes::<S>(node, near_planes[k] ^ 1)
            .fma(inverse[k], S::F8::splat(ray.far_offset[k])));
        let near = x0.max(y0).max(z0.max(S::F8::splat(ray.origin[3])));
        let far = x1.min(y1).min(z1.min(S::F8::splat(slot.found.best.t)));
        let children = S::F8::load(node.children.as_ptr().cast());
        let count = slot.count as usize;
        debug_assert!(count + 8 <= STACK);
        let entered;
        if QUERY == ANY {
            entered = near.le(far).bits();
            S::compress8(children, entered, slot.children.as_mut_ptr().add(count).cast());
        } else {
            let order = S::order8(*node.orders.get_unchecked(ray.octant));
            let near = S::permute8(near, order);
            entered = near.le(S::permute8(far, order)).bits();
            let children = S::permute8(children, order);
            S::compress8(children, entered, slot.children.as_mut_ptr().add(count).cast());
            S::compress8(near, entered, slot.nears.as_mut_ptr().add(count));
        }
        slot.count += entered.count_ones();
    }
}

/// A ray is through with the world's own tree.
#[inline(always)]
unsafe fn finish<S: Simd, const QUERY: Query>(bvh: &Bvh8, slot: &mut Slot, source: &mut impl Source) {
    if bvh.instance_root != EMPTY && !(QUERY == ANY && slot.found.any) {
        let (ray, filter) = source.ray(slot.number);
        // SAFETY: the caller's.
        unsafe {
            single::trace_instances::<S, QUERY>(bvh, bvh.instance_root, ray, filter, &mut slot.found);
        }
    }
    source.finish(slot.number, &slot.found);
}
