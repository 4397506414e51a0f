//! Searches that put off what is unclear until the walk is over.
//!
//! Deciding takes double precision now and then, and so a function of its own on GPUs; where a loop calls one, what the loop
//! works with lies in memory. A walk that decides afterwards keeps it in registers. It loses little by that: of the rays, few
//! meet something unclear, and they go on to what is behind it.

use crate::hierarchy::candidates::{Placement, PrimitivesView};
use crate::hierarchy::search::{OfferOutcome, PrimitiveSlot, Search};
use crate::intersect::TriangleHit;
use crate::ray::{PrimitiveId, Ray};
use core::mem::MaybeUninit;

/// How many primitives a walk defers; a ray that meets more takes another walk.
const MOST: usize = 16;

/// Storage for deferred primitives: their instances and numbers. It is apart from [`DeferredCandidates`], so that their number
/// can live in a register; and the two are apart from each other, or else the loop that finds them counts in pairs.
pub(super) struct DeferredStorage {
    instances: [MaybeUninit<u32>; MOST],
    primitives: [MaybeUninit<u32>; MOST],
}

/// A search that puts off what is unclear.
pub(super) struct DeferredCandidates<'a, S> {
    /// With what is certain.
    pub(super) search: S,
    storage: &'a mut DeferredStorage,
    /// How many there are; one more than there is room for, if there was none left.
    count: u32,
}

impl<'a, S: Search> DeferredCandidates<'a, S> {
    #[inline(always)]
    pub(super) const fn storage() -> DeferredStorage {
        DeferredStorage {
            instances: [MaybeUninit::uninit(); MOST],
            primitives: [MaybeUninit::uninit(); MOST],
        }
    }

    #[inline(always)]
    pub(super) fn new(search: S, storage: &'a mut DeferredStorage) -> Self {
        DeferredCandidates { search, storage, count: 0 }
    }

    /// Decides what was put off. `false` if there was no room for all of it.
    #[inline(always)]
    pub(super) fn decide_deferred(&mut self, primitives: &PrimitivesView, world_ray: &Ray) -> bool {
        if self.count as usize > MOST {
            return false;
        }
        // What a kernel keeps in registers would otherwise lie in memory from its start.
        let (primitives, world_ray) = (&{ *primitives }, &{ *world_ray });
        let mut k = 0;
        while k < self.count {
            // SAFETY: those below `count` were written.
            let place = unsafe {
                let instance = self.storage.instances.get_unchecked(k as usize).assume_init();
                PrimitiveSlot {
                    instance,
                    primitive: self.storage.primitives.get_unchecked(k as usize).assume_init(),
                }
            };
            let placement = Placement { instance: place.instance, world_ray };
            if self.search.unclear(primitives, place, place.id(primitives), &placement) {
                break;
            }
            k += 1;
        }
        true
    }
}

impl<S: Search> Search for DeferredCandidates<'_, S> {
    type Whole = Self;

    #[inline(always)]
    fn whole(&mut self) -> &mut Self {
        self
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.search.t_max()
    }

    #[inline(always)]
    fn end(&self) -> f64 {
        self.search.end()
    }

    #[inline(always)]
    fn offer_certain(&mut self, place: PrimitiveSlot, low: f32, high: f32) -> OfferOutcome {
        self.search.offer_certain(place, low, high)
    }

    #[inline(always)]
    fn unclear(&mut self, _: &PrimitivesView, place: PrimitiveSlot, _: PrimitiveId, _: &Placement) -> bool {
        let place_in = self.count as usize;
        self.count += 1;
        if place_in >= MOST {
            return true;
        }
        self.storage.instances[place_in].write(place.instance);
        self.storage.primitives[place_in].write(place.primitive);
        false
    }

    #[inline(always)]
    fn offer(
        &mut self,
        primitives: &PrimitivesView,
        ray: &Ray,
        place: PrimitiveSlot,
        id: PrimitiveId,
        hit: &TriangleHit,
    ) -> bool {
        self.search.offer(primitives, ray, place, id, hit)
    }

    #[inline(always)]
    fn has(&self, primitives: &PrimitivesView, id: PrimitiveId) -> bool {
        self.search.has(primitives, id)
    }
}
