//! A batch of rays as a stream.

use super::super::batch::Batch;
use super::super::found::{ANY, Found, Query};
use super::super::single;
use super::super::single_ray::SingleRay;
use super::{BELOW, FINISHED, NOBODY, SLOTS, Slot, Stream};
use crate::bvh8::EMPTY;
use crate::simd::Simd;
use eosphor_core::hierarchy::IgnoreWork;
use std::mem::MaybeUninit;

impl<const QUERY: Query> Batch<'_, QUERY> {
    /// Rays `first .. end`.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Whole batch: `end` is no more than the rays.
    #[inline(always)]
    pub(in super::super) unsafe fn stream<S: Simd>(&mut self, first: usize, end: usize) {
        let mut slots = MaybeUninit::<[Slot; SLOTS]>::uninit();
        let slots = slots.as_mut_ptr().cast::<Slot>();
        let mut stream = Stream::<QUERY>::new(self.bvh, slots);
        let mut next = first;
        // SAFETY: instruction set and whole batch: promised to this function. Written places: slots without a ray are in no list
        // but that of finished ones; their numbers, and what is read below their stacks, are written here. Stack room: there are
        // as many slots as lists have places for.
        unsafe {
            for k in 0..SLOTS {
                (&raw mut (*slots.add(k)).number).write(NOBODY);
                // What is read below the lowest child that waits.
                (&raw mut (*slots.add(k)).nears).cast::<[f32; BELOW]>().write([f32::NEG_INFINITY; BELOW]);
                stream.lists.put((k * size_of::<Slot>()) as u32, FINISHED);
            }
            loop {
                let count = stream.lists.take(FINISHED);
                let mut k = 0;
                while k < count {
                    let number = stream.lists.get(FINISHED, k);
                    let slot = &mut *stream.slot(number);
                    self.finish::<S>(slot);
                    while next < end {
                        let ray = next;
                        next += 1;
                        if self.start::<S>(slot, ray as u32) {
                            stream.put(number);
                            break;
                        }
                        self.one_by_one::<S>(ray, ray + 1);
                    }
                    k += 1;
                }
                if stream.lists.counts == 0 {
                    return;
                }
                stream.step::<S>();
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
        slot.number = number;
        slot.begin(self.bvh.world_root, self.filters.of(number as usize), Found::nothing(ray.t_max));
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
            if slot.is_full {
                return self.one_by_one::<S>(number, number + 1);
            }
            if self.bvh.instance_root != EMPTY && !(QUERY == ANY && found.any) {
                let (root, ray) = (self.bvh.instance_root, self.rays.get_unchecked(number));
                single::trace_instances::<S, _, QUERY>(self.bvh, root, ray, slot.filter, IgnoreWork, found);
            }
            if QUERY == ANY {
                *self.hidden.get_unchecked_mut(number) = found.any;
            } else {
                *self.hits.get_unchecked_mut(number) = found.best;
            }
        }
    }
}
