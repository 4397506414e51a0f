//! Many rays in flight, each on its own way.
//!
//! One ray's next step hangs on the one before: a node's planes come from memory, and where the ray goes from there no CPU can
//! guess. Here many rays take their steps in turn, all those at nodes, then all those at leaves. So the CPU works on several at
//! once, and it need not guess: what a ray does next is a number that says into which list it goes. No ray is tested against
//! anything else than it would be alone.

mod blocks;
mod scattered;

use super::found::{ANY, Found, Query};
use super::single;
use super::single_leaf::{PrimitiveLeaves, prefetch};
use super::single_ray::SingleRay;
use crate::bvh8::view::Bvh8View;
use crate::bvh8::{Child, EMPTY, SPHERE};
use crate::simd::{Float, Mask, Simd, each};
use eosphor_core::ray::RayFilter;

/// Rays in flight. (With 16 and 64 a stream is 5 percent slower; 48 is as good.)
const SLOTS: usize = 32;
/// Children that may wait for a ray, and eight more, since whole vectors are written. (Where assertions look for faults, some rays
/// have more.)
const ROOM: usize = if cfg!(debug_assertions) { 16 } else { 64 };
/// Places below those, so that eight can be read at a time.
const BELOW: usize = 8;

/// A ray in flight: one of the world that is usual ([`SingleRay::is_usual`]).
#[repr(C, align(64))]
struct Slot<'a> {
    ray: SingleRay<'a>,
    found: Found,
    filter: &'a RayFilter,
    at: Child,
    /// Of children on the stack. Where the ray is at a node that has just been tested, the place of the next one.
    waiting: u32,
    /// Its number in a batch, or [`NOBODY`].
    number: u32,
    /// More children wait than there is room for: the search is not over.
    is_full: bool,
    /// Where the ray enters the children that wait.
    nears: [f32; BELOW + ROOM],
    children: [Child; ROOM],
    /// So that it is an odd number of cache lines.
    _line: [u64; 8],
}

/// Slots then lie in different sets of the cache.
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

impl<'a> Slot<'a> {
    /// Begins a search from a child on, with what has been found. The ray is there already.
    #[inline(always)]
    fn begin(&mut self, at: Child, filter: &'a RayFilter, found: Found) {
        self.found = found;
        self.filter = filter;
        self.at = at;
        self.is_full = false;
        self.waiting = 1;
        // What is never beyond anything.
        self.nears[BELOW] = f32::NEG_INFINITY;
        self.children[0] = EMPTY;
    }
}

/// Slots, and what they do next.
struct Stream<'a, 's, const QUERY: Query> {
    bvh: &'a Bvh8View<'a>,
    /// From which on slots are counted, in bytes.
    slots: *mut Slot<'s>,
    lists: Lists,
}

impl<'a, 's, const QUERY: Query> Stream<'a, 's, QUERY> {
    #[inline(always)]
    fn new(bvh: &'a Bvh8View<'a>, slots: *mut Slot<'s>) -> Stream<'a, 's, QUERY> {
        Stream { bvh, slots, lists: Lists { slots: [[0; SLOTS]; 4], counts: 0 } }
    }

    /// Takes a slot that has begun.
    ///
    /// # Safety
    /// Stack room: there are fewer than [`SLOTS`] in the lists, and the slot is not.
    #[inline(always)]
    unsafe fn put(&mut self, slot: u32) {
        // SAFETY: stack room: promised to this function.
        unsafe {
            let at = (*self.slot(slot)).at;
            self.lists.put(slot, what(at));
        }
    }

    #[inline(always)]
    fn slot(&self, slot: u32) -> *mut Slot<'s> {
        self.slots.wrapping_byte_add(slot as usize)
    }

    /// A step of all rays. Those whose search is over are in the list of finished ones.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Closed view: so are the slots.
    #[inline(always)]
    unsafe fn step<S: Simd>(&mut self) {
        // SAFETY: promised to this function. Stack room: a slot is put into one list where it is taken from one, and into the list
        // that is gone through no more than have been taken from there.
        unsafe {
            self.visit_nodes::<S>();
            self.visit_leaves::<S>();
        }
    }

    /// A step of all rays at nodes.
    ///
    /// # Safety
    /// As for [`Stream::step`].
    #[inline(always)]
    unsafe fn visit_nodes<S: Simd>(&mut self) {
        let count = self.lists.take(NODE);
        // SAFETY: promised to this function.
        unsafe {
            let mut k = 0;
            while k < count {
                self.enter::<S>(&mut *self.slot(self.lists.get(NODE, k)));
                k += 1;
            }
            // In a second pass: what has just been written to a stack by eight cannot be read at once (1.07 times as fast).
            k = 0;
            while k < count {
                let number = self.lists.get(NODE, k);
                let slot = &mut *self.slot(number);
                let top = slot.waiting as usize;
                if top > ROOM - 8 {
                    slot.is_full = true;
                    self.lists.put(number, FINISHED);
                } else {
                    slot.at = *slot.children.get_unchecked(top);
                    prefetch::<S, 4>(self.bvh, self.bvh.nodes.as_ptr().cast(), slot.at);
                    let is_stale = QUERY != ANY && *slot.nears.get_unchecked(BELOW + top) > slot.found.end;
                    self.lists.put(number, if is_stale { STALE } else { what(slot.at) });
                }
                k += 1;
            }
            let count = self.lists.take(STALE);
            k = 0;
            while QUERY != ANY && k < count {
                let number = self.lists.get(STALE, k);
                let slot = &mut *self.slot(number);
                self.pop::<S>(slot);
                self.lists.put(number, what(slot.at));
                k += 1;
            }
        }
    }

    /// Tests the leaves that rays are at. Where too few of them are left to fill a register, they wait for others.
    ///
    /// # Safety
    /// As for [`Stream::step`].
    #[inline(always)]
    unsafe fn visit_leaves<S: Simd>(&mut self) {
        let count = self.lists.take(TRIANGLES);
        // Of a register that is not full the rest is the first of them again.
        let (mut group, mut members) = ([0; 4], 0);
        // SAFETY: promised to this function.
        unsafe {
            let mut k = 0;
            while k < count {
                let number = self.lists.get(TRIANGLES, k);
                k += 1;
                let slot = &mut *self.slot(number);
                if slot.at & SPHERE != 0 {
                    let (bvh, filter) = (self.bvh, slot.filter);
                    let mut leaves = PrimitiveLeaves { bvh, ray: &slot.ray, instance: 0, filter };
                    let is_over = leaves.visit::<S, QUERY>(slot.at, &mut slot.found);
                    self.leave::<S>(slot, number, is_over);
                    continue;
                }
                if members == 0 {
                    group = [number; 4];
                }
                group[members & 3] = number;
                members += 1;
                if members == S::PART / 4 {
                    self.test_blocks::<S>(&group, members);
                    members = 0;
                }
            }
            if self.lists.count(NODE) == 0 && members > 0 {
                self.test_blocks::<S>(&group, members);
                return;
            }
            k = 0;
            while k < members {
                self.lists.put(group[k], TRIANGLES);
                k += 1;
            }
        }
    }

    /// Goes on after a leaf.
    ///
    /// # Safety
    /// Stack room: a child waits, and the slot is in no list.
    #[inline(always)]
    unsafe fn leave<S: Simd>(&mut self, slot: &mut Slot, number: u32, is_over: bool) {
        // SAFETY: stack room: promised to this function.
        unsafe {
            if QUERY == ANY && is_over {
                self.lists.put(number, FINISHED);
            } else {
                self.pop::<S>(slot);
                self.lists.put(number, what(slot.at));
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
