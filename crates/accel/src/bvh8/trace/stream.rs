//! Many rays in flight, each on its own way.
//!
//! One ray's next step hangs on the one before: a node's planes come from memory, and where the ray goes from there no CPU can
//! guess. Here many rays take their steps in turn, all those at nodes, then all those at leaves. So the CPU works on several at
//! once, and its guesses are about lists and not about rays. No ray is tested against anything else than it would be alone.

use super::batch::Batch;
use super::found::{ANY, Found, Query};
use super::single;
use super::single_leaf::{PrimitiveLeaves, prefetch};
use super::single_ray::SingleRay;
use crate::bvh8::{Child, EMPTY};
use crate::simd::{Float, Simd, each};
use eosphor_core::ray::RayFilter;
use std::mem::MaybeUninit;

/// Blocks of a hierarchy that stays in a core's own cache. There a ray's next step waits for little. (Where assertions look for
/// faults, all hierarchies have streams.)
const NEAR: usize = if cfg!(debug_assertions) { 0 } else { 4000 };
/// Scattered rays that are a stream.
const STREAM: usize = 16;

/// Rays in flight.
const SLOTS: usize = 32;
/// Children that may wait for a ray, and eight more, since whole vectors are written. A ray with more is traced alone. (Where
/// assertions look for faults, some are.)
const ROOM: usize = if cfg!(debug_assertions) { 16 } else { 64 };

/// A ray in flight.
#[repr(C, align(64))]
struct Slot<'a> {
    ray: SingleRay<'a>,
    found: Found,
    filter: &'a RayFilter,
    at: Child,
    waiting: u32,
    /// Its number in the batch, or [`NOBODY`].
    number: u32,
    /// Where the ray enters the children that wait.
    nears: [f32; ROOM],
    children: [Child; ROOM],
}

/// An odd number of cache lines: so slots lie in different sets of the cache.
const _: () = assert!(size_of::<Slot>() / 64 % 2 == 1);

/// In place of the number of a ray.
const NOBODY: u32 = u32::MAX;

/// What a slot does next.
const NODE: usize = 0;
const TRIANGLES: usize = 1;
/// The child that it took lies beyond what has been found.
const STALE: usize = 2;
const FINISHED: usize = 3;

/// Slots by what they do next.
struct Lists {
    slots: [[u16; SLOTS]; 4],
    counts: [usize; 4],
}

impl Lists {
    const EMPTY: Lists = Lists { slots: [[0; SLOTS]; 4], counts: [0; 4] };

    /// # Safety
    /// A slot is in one list at a time.
    #[inline(always)]
    unsafe fn put(&mut self, slot: u16, what: usize) {
        // SAFETY: stack room: a list has a place for each slot, and each is in one list alone, as promised to this function.
        unsafe {
            let count = self.counts.get_unchecked_mut(what);
            *self.slots.get_unchecked_mut(what).get_unchecked_mut(*count) = slot;
            *count += 1;
        }
    }
}

impl<const QUERY: Query> Batch<'_, QUERY> {
    /// Whether so many scattered rays are traced sooner in a stream than one by one.
    #[inline(always)]
    pub(super) fn is_for_streams(&self, rays: usize) -> bool {
        (self.bvh.blocks.len() > NEAR) & (rays >= STREAM)
    }

    /// Rays `first .. end`.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Whole batch: `end` is no more than the rays.
    #[inline(always)]
    pub(super) unsafe fn stream<S: Simd>(&mut self, first: usize, end: usize) {
        let bvh = self.bvh;
        let mut slots = MaybeUninit::<[Slot; SLOTS]>::uninit();
        let slots = slots.as_mut_ptr().cast::<Slot>();
        let mut next = first;
        // One is read in a round, and the other one written for the next round. (They stay where they are: to copy what has just
        // been written in small pieces, a CPU waits.)
        let mut lists = [Lists::EMPTY, Lists::EMPTY];
        let mut round = 0;
        // SAFETY: instruction set and whole batch: promised to this function. Written places: slots without a ray are in no list
        // but that of finished ones, and their numbers are written here. Stack room: a slot is put into one list where it is
        // taken from one.
        unsafe {
            for k in 0..SLOTS {
                (&raw mut (*slots.add(k)).number).write(NOBODY);
                lists[1].put((k * size_of::<Slot>()) as u16, FINISHED);
            }
            loop {
                round ^= 1;
                let [a, b] = &mut lists;
                let (now, later) = if round == 1 { (b, a) } else { (a, b) };
                later.counts = [0; 4];
                let mut k = 0;
                while k < now.counts[FINISHED] {
                    let number = *now.slots[FINISHED].get_unchecked(k);
                    let slot = &mut *slots.byte_add(number as usize);
                    self.finish::<S>(slot);
                    while next < end {
                        let ray = next;
                        next += 1;
                        if self.start::<S>(slot, ray as u32) {
                            later.put(number, what(bvh.world_root, false));
                            break;
                        }
                        self.one_by_one::<S>(ray, ray + 1);
                    }
                    k += 1;
                }
                k = 0;
                while k < now.counts[NODE] {
                    let number = *now.slots[NODE].get_unchecked(k);
                    let slot = &mut *slots.byte_add(number as usize);
                    let what = self.enter::<S>(slot);
                    if slot.waiting as usize > ROOM - 8 {
                        self.one_by_one::<S>(slot.number as usize, slot.number as usize + 1);
                        slot.number = NOBODY;
                        later.put(number, FINISHED);
                    } else {
                        later.put(number, what);
                    }
                    k += 1;
                }
                k = 0;
                while k < now.counts[TRIANGLES] {
                    let number = *now.slots[TRIANGLES].get_unchecked(k);
                    let slot = &mut *slots.byte_add(number as usize);
                    let mut leaves =
                        PrimitiveLeaves { bvh, ray: &slot.ray, instance: 0, filter: slot.filter };
                    if leaves.visit::<S, QUERY>(slot.at, &mut slot.found) {
                        later.put(number, FINISHED);
                    } else {
                        self.pop::<S>(slot, number, later);
                    }
                    k += 1;
                }
                while QUERY != ANY && later.counts[STALE] > 0 {
                    // (What is put here has been taken from here before.)
                    let count = later.counts[STALE];
                    later.counts[STALE] = 0;
                    k = 0;
                    while k < count {
                        let number = *later.slots[STALE].get_unchecked(k);
                        self.pop::<S>(&mut *slots.byte_add(number as usize), number, later);
                        k += 1;
                    }
                }
                if later.counts == [0; 4] {
                    return;
                }
            }
        }
    }

    /// Puts a ray into a slot; `false` where it is none for streams.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Whole batch: the number is below the count of rays.
    #[inline(always)]
    unsafe fn start<'s, S: Simd>(&self, slot: &mut Slot<'s>, number: u32) -> bool
    where
        Self: 's,
    {
        // SAFETY: whole batch: promised to this function.
        let ray = unsafe { self.rays.get_unchecked(number as usize) };
        if !SingleRay::is_usual(ray, self.bvh.near) {
            return false;
        }
        slot.ray = SingleRay::of_world::<S>(ray, self.bvh.world);
        slot.found = Found::nothing(ray.t_max);
        slot.filter = self.filters.of(number as usize);
        slot.number = number;
        slot.at = self.bvh.world_root;
        slot.waiting = 1;
        slot.nears[0] = f32::NEG_INFINITY;
        slot.children[0] = EMPTY;
        true
    }

    /// Writes what the ray of a slot has found.
    ///
    /// # Safety
    /// As for [`Batch::start`].
    #[inline(always)]
    unsafe fn finish<S: Simd>(&mut self, slot: &mut Slot) {
        if slot.number == NOBODY {
            return;
        }
        let number = slot.number as usize;
        slot.number = NOBODY;
        let found = &mut slot.found;
        // SAFETY: instruction set and whole batch: promised to this function.
        unsafe {
            if self.bvh.instance_root != EMPTY && !(QUERY == ANY && found.any) {
                let ray = self.rays.get_unchecked(number);
                single::trace_instances::<S, _, QUERY>(
                    self.bvh,
                    self.bvh.instance_root,
                    ray,
                    slot.filter,
                    eosphor_core::hierarchy::IgnoreWork,
                    found,
                );
            }
            if QUERY == ANY {
                *self.hidden.get_unchecked_mut(number) = found.any;
            } else {
                *self.hits.get_unchecked_mut(number) = found.best;
            }
        }
    }

    /// Takes the child that waits on top.
    ///
    /// # Safety
    /// One waits, and the slot is in no list.
    #[inline(always)]
    unsafe fn pop<S: Simd>(&self, slot: &mut Slot, number: u16, lists: &mut Lists) {
        slot.waiting -= 1;
        let top = slot.waiting as usize;
        // SAFETY: stack room: one waits, as promised to this function, and a slot is put into one list.
        unsafe {
            let at = *slot.children.get_unchecked(top);
            slot.at = at;
            let is_stale = QUERY != ANY && *slot.nears.get_unchecked(top) > slot.found.end;
            prefetch::<S, 4>(self.bvh, self.bvh.nodes.as_ptr().cast(), at);
            lists.put(number, what(at, is_stale));
        }
    }

    /// Tests the eight children of a node, goes on to the first one that the ray enters, or to what waits on top, and puts the
    /// others onto its stack. Gives what the slot does next.
    ///
    /// # Safety
    /// Closed view: the slot is at a node. Stack room: eight more children have room.
    #[inline(always)]
    unsafe fn enter<S: Simd>(&self, slot: &mut Slot) -> usize {
        let (nodes, ray) = (self.bvh.nodes, &slot.ray);
        let inverse = each!(k => S::F8::splat(ray.inverse[k]));
        let [near_planes, far_planes] = single::near_and_far_planes(ray.octant as usize);
        // SAFETY: closed view and stack room: promised to this function.
        unsafe {
            let node = nodes.get_unchecked(slot.at as usize);
            let [x0, y0, z0] = each!(k => single::planes::<S>(node, near_planes[k])
                .fma(inverse[k], S::F8::splat(ray.near_offset[k])));
            let [x1, y1, z1] = each!(k => single::planes::<S>(node, far_planes[k])
                .fma(inverse[k], S::F8::splat(ray.far_offset[k])));
            // (Rays in slots are usual ones, which begin at their origin or beyond.)
            let near = S::larger8(S::larger8(x0, y0), S::larger8(z0, S::F8::splat(ray.origin[3])));
            let far = S::smaller8(S::smaller8(x1, y1), S::smaller8(z1, S::F8::splat(slot.found.end)));
            let children = S::F8::load(node.children.as_ptr().cast());
            let count = slot.waiting as usize;
            let top = *slot.children.get_unchecked(count - 1);
            let (entered, last, is_stale);
            if QUERY == ANY {
                entered = S::not_above8(near, far);
                S::compress8(children, entered, slot.children.as_mut_ptr().add(count).cast());
                last = 31 - (entered | 1).leading_zeros();
                is_stale = false;
            } else {
                is_stale = *slot.nears.get_unchecked(count - 1) > slot.found.end;
                let bits = *node.orders.get_unchecked(ray.octant as usize);
                let order = S::order8(bits);
                let near = S::permute8(near, order);
                entered = S::not_above8(near, S::permute8(far, order));
                let children = S::permute8(children, order);
                S::compress8(children, entered, slot.children.as_mut_ptr().add(count).cast());
                S::compress8(near, entered, slot.nears.as_mut_ptr().add(count));
                last = bits >> (3 * (31 - (entered | 1).leading_zeros())) & 7;
            }
            // (Not from the stack: what has just been written there by eight is not read at once.)
            let first = *node.children.get_unchecked(last as usize);
            let at = if entered == 0 { top } else { first };
            slot.at = at;
            slot.waiting = slot.waiting + entered.count_ones() - 1;
            prefetch::<S, 4>(self.bvh, self.bvh.nodes.as_ptr().cast(), at);
            what(at, (entered == 0) & is_stale)
        }
    }
}

/// What a slot does that is at a child.
#[inline(always)]
fn what(at: Child, is_stale: bool) -> usize {
    let what = (at >> 31) as usize + if at == EMPTY { 2 } else { 0 };
    if is_stale { STALE } else { what }
}
