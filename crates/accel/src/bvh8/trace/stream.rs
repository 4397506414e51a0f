//! Many rays in flight, each on its own way.
//!
//! One ray's next step hangs on the one before: a node's planes come from memory, and where the ray goes from there no CPU can
//! guess. Here many rays take their steps in turn, all those at nodes, then all those at leaves. So the CPU works on several at
//! once, and it need not guess: what a ray does next is a number that says into which list it goes. No ray is tested against
//! anything else than it would be alone.

mod blocks;

use super::batch::Batch;
use super::found::{ANY, Found, Query};
use super::single;
use super::single_leaf::{PrimitiveLeaves, prefetch};
use super::single_ray::SingleRay;
use crate::bvh8::{Child, EMPTY, SPHERE};
use crate::simd::{Float, Mask, Simd, each};
use eosphor_core::ray::RayFilter;
use std::mem::MaybeUninit;

/// Rays in flight. (With 16 and 64 a stream is 5 percent slower; 48 is as good.)
const SLOTS: usize = 32;
/// Children that may wait for a ray, and eight more, since whole vectors are written. A ray with more is traced alone. (Where
/// assertions look for faults, some are.)
const ROOM: usize = if cfg!(debug_assertions) { 16 } else { 64 };
/// Places below those, so that eight can be read at a time.
const BELOW: usize = 8;

/// A ray in flight.
#[repr(C, align(64))]
struct Slot<'a> {
    ray: SingleRay<'a>,
    found: Found,
    filter: &'a RayFilter,
    at: Child,
    /// Of children on the stack. Where the ray is at a node that has just been tested, the place of the next one.
    waiting: u32,
    /// Its number in the batch, or [`NOBODY`].
    number: u32,
    /// Where the ray enters the children that wait.
    nears: [f32; BELOW + ROOM],
    children: [Child; ROOM],
    _odd: [u64; 8],
}

/// An odd number of cache lines: so slots lie in different sets of the cache.
const _: () = assert!(size_of::<Slot>() / 64 % 2 == 1);

/// In place of the number of a ray.
const NOBODY: u32 = u32::MAX;

/// What a slot does next.
const NODE: u32 = 0;
const TRIANGLES: u32 = 1;
const FINISHED: u32 = 2;
/// The child that it took lies beyond what has been found.
const STALE: u32 = 3;

/// What a slot does that is at a child.
#[inline(always)]
fn what(at: Child) -> u32 {
    (at >> 31) + u32::from(at == EMPTY)
}

/// Slots, as offsets in bytes, by what they do next.
struct Lists {
    slots: [[u32; SLOTS]; 4],
    /// How many there are in each, sixteen bits each: so a slot is put into one of the lists without a branch.
    counts: u64,
}

impl Lists {
    /// # Safety
    /// A slot is in one list at a time.
    #[inline(always)]
    unsafe fn put(&mut self, slot: u32, what: u32) {
        let count = (self.counts >> (16 * what)) as u16;
        self.counts += 1 << (16 * what);
        // SAFETY: stack room: a list has a place for each slot, and each is in one list alone, as promised to this function.
        unsafe { *self.slots.get_unchecked_mut(what as usize).get_unchecked_mut(count as usize) = slot }
    }

    /// Empties a list; how many there were. They stay where they are until as many have been put there.
    #[inline(always)]
    fn take(&mut self, what: u32) -> usize {
        let count = self.count(what);
        self.counts &= !(0xffff << (16 * what));
        count
    }

    #[inline(always)]
    fn count(&self, what: u32) -> usize {
        usize::from((self.counts >> (16 * what)) as u16)
    }

    /// # Safety
    /// There have been more than `k` in this list.
    #[inline(always)]
    unsafe fn get(&self, what: u32, k: usize) -> u32 {
        // SAFETY: stack room: no list has more than it has places.
        unsafe { *self.slots.get_unchecked(what as usize).get_unchecked(k) }
    }
}

impl<const QUERY: Query> Batch<'_, QUERY> {
    /// Rays `first .. end`.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Whole batch: `end` is no more than the rays.
    #[inline(always)]
    pub(super) unsafe fn stream<S: Simd>(&mut self, first: usize, end: usize) {
        let mut slots = MaybeUninit::<[Slot; SLOTS]>::uninit();
        let slots = slots.as_mut_ptr().cast::<Slot>();
        let mut lists = Lists { slots: [[0; SLOTS]; 4], counts: 0 };
        let mut next = first;
        // SAFETY: instruction set and whole batch: promised to this function. Written places: slots without a ray are in no list
        // but that of finished ones, and their numbers are written here. Stack room: a slot is put into one list where it is
        // taken from one, and into the list that is gone through no more than have been taken from there.
        unsafe {
            for k in 0..SLOTS {
                (&raw mut (*slots.add(k)).number).write(NOBODY);
                lists.put((k * size_of::<Slot>()) as u32, FINISHED);
            }
            loop {
                let count = lists.take(FINISHED);
                let mut k = 0;
                while k < count {
                    let number = lists.get(FINISHED, k);
                    let slot = &mut *slots.byte_add(number as usize);
                    self.finish::<S>(slot);
                    while next < end {
                        let ray = next;
                        next += 1;
                        if self.start::<S>(slot, ray as u32) {
                            lists.put(number, what(slot.at));
                            break;
                        }
                        self.one_by_one::<S>(ray, ray + 1);
                    }
                    k += 1;
                }
                if lists.counts == 0 {
                    return;
                }
                self.visit_nodes::<S>(slots, &mut lists);
                self.visit_leaves::<S>(slots, &mut lists);
            }
        }
    }

    /// A step of all rays at nodes.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Whole batch: so are the rays. Closed view: so are the slots.
    #[inline(always)]
    unsafe fn visit_nodes<S: Simd>(&mut self, slots: *mut Slot, lists: &mut Lists) {
        let count = lists.take(NODE);
        // SAFETY: promised to this function.
        unsafe {
            let mut k = 0;
            while k < count {
                self.enter::<S>(&mut *slots.byte_add(lists.get(NODE, k) as usize));
                k += 1;
            }
            // In a second pass: what has just been written to a stack by eight cannot be read at once (1.07 times as fast).
            k = 0;
            while k < count {
                let number = lists.get(NODE, k);
                let slot = &mut *slots.byte_add(number as usize);
                let top = slot.waiting as usize;
                if top > ROOM - 8 {
                    self.one_by_one::<S>(slot.number as usize, slot.number as usize + 1);
                    slot.number = NOBODY;
                    lists.put(number, FINISHED);
                } else {
                    slot.at = *slot.children.get_unchecked(top);
                    prefetch::<S, 4>(self.bvh, self.bvh.nodes.as_ptr().cast(), slot.at);
                    let is_stale = QUERY != ANY && *slot.nears.get_unchecked(BELOW + top) > slot.found.end;
                    lists.put(number, if is_stale { STALE } else { what(slot.at) });
                }
                k += 1;
            }
            let count = lists.take(STALE);
            k = 0;
            while QUERY != ANY && k < count {
                let number = lists.get(STALE, k);
                let slot = &mut *slots.byte_add(number as usize);
                self.pop::<S>(slot);
                lists.put(number, what(slot.at));
                k += 1;
            }
        }
    }

    /// Tests the leaves that rays are at. Where too few of them are left to fill a register, they wait for others.
    ///
    /// # Safety
    /// As for [`Batch::visit_nodes`].
    #[inline(always)]
    unsafe fn visit_leaves<S: Simd>(&mut self, slots: *mut Slot, lists: &mut Lists) {
        let count = lists.take(TRIANGLES);
        // Of a register that is not full the rest is the first of them again.
        let (mut group, mut members) = ([0; 4], 0);
        // SAFETY: promised to this function.
        unsafe {
            let mut k = 0;
            while k < count {
                let number = lists.get(TRIANGLES, k);
                k += 1;
                let slot = &mut *slots.byte_add(number as usize);
                if slot.at & SPHERE != 0 {
                    let (bvh, filter) = (self.bvh, slot.filter);
                    let mut leaves = PrimitiveLeaves { bvh, ray: &slot.ray, instance: 0, filter };
                    let is_over = leaves.visit::<S, QUERY>(slot.at, &mut slot.found);
                    self.leave::<S>(slot, number, is_over, lists);
                    continue;
                }
                if members == 0 {
                    group = [number; 4];
                }
                group[members & 3] = number;
                members += 1;
                if members == S::PART / 4 {
                    self.test_blocks::<S>(slots, &group, members, lists);
                    members = 0;
                }
            }
            if lists.count(NODE) == 0 && members > 0 {
                self.test_blocks::<S>(slots, &group, members, lists);
                return;
            }
            k = 0;
            while k < members {
                lists.put(group[k], TRIANGLES);
                k += 1;
            }
        }
    }

    /// Goes on after a leaf.
    ///
    /// # Safety
    /// Stack room: a child waits, and the slot is in no list.
    #[inline(always)]
    unsafe fn leave<S: Simd>(&self, slot: &mut Slot, number: u32, is_over: bool, lists: &mut Lists) {
        // SAFETY: stack room: promised to this function.
        unsafe {
            if QUERY == ANY && is_over {
                lists.put(number, FINISHED);
            } else {
                self.pop::<S>(slot);
                lists.put(number, what(slot.at));
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
        slot.nears[BELOW] = f32::NEG_INFINITY;
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

    /// Takes the uppermost child that waits and does not lie beyond what has been found.
    ///
    /// # Safety
    /// Stack room: one waits.
    #[inline(always)]
    unsafe fn pop<S: Simd>(&self, slot: &mut Slot) {
        let mut top = slot.waiting as usize;
        // SAFETY: stack room: one waits, as promised to this function. The lowest is never beyond anything, and there are places
        // below it.
        unsafe {
            if QUERY == ANY {
                top -= 1;
            } else {
                let end = S::F8::splat(slot.found.end);
                let mut within;
                loop {
                    within = S::F8::load(slot.nears.as_ptr().add(BELOW + top - 8)).le(end).bits();
                    if within != 0 {
                        break;
                    }
                    top -= 8;
                }
                top = top + 31 - within.leading_zeros() as usize - 8;
            }
            slot.at = *slot.children.get_unchecked(top);
            slot.waiting = top as u32;
            prefetch::<S, 4>(self.bvh, self.bvh.nodes.as_ptr().cast(), slot.at);
        }
    }

    /// Tests the eight children of a node, and puts those that the ray enters onto its stack. The uppermost one, one of these or
    /// what has waited, is what it goes on to.
    ///
    /// # Safety
    /// Closed view: the slot is at a node. Stack room: eight more children have room.
    #[inline(always)]
    unsafe fn enter<S: Simd>(&self, slot: &mut Slot) {
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
            let entered;
            if QUERY == ANY {
                entered = S::not_above8(near, far);
                S::compress8(children, entered, slot.children.as_mut_ptr().add(count).cast());
            } else {
                let order = S::order8(*node.orders.get_unchecked(ray.octant as usize));
                let near = S::permute8(near, order);
                entered = S::not_above8(near, S::permute8(far, order));
                let children = S::permute8(children, order);
                S::compress8(children, entered, slot.children.as_mut_ptr().add(count).cast());
                S::compress8(near, entered, slot.nears.as_mut_ptr().add(BELOW + count));
            }
            slot.waiting = (count + entered.count_ones() as usize - 1) as u32;
        }
    }
}
