//! Searches that put off what is unclear until the walk is over.
//!
//! Deciding takes double precision now and then, and so a function of its own on GPUs; where a loop calls one, what the loop
//! works with lies in memory. A walk that decides afterwards keeps it in registers. It loses little by that: of the rays, few
//! meet something unclear, and they go on to what is behind it.

use super::candidates::{Placement, PrimitivesView};
use super::search::{Offered, Place, Search};
use crate::intersect::TriangleHit;
use crate::ray::{PrimitiveId, Ray};
use core::mem::MaybeUninit;

/// How many primitives a walk puts off; a ray that meets more takes another walk.
const MOST: usize = 16;

/// Room for primitives put off: their instances and numbers. Apart from [`PutOff`], so that their number can live in a
/// register; and apart from each other, or else the loop that finds them counts in pairs.
pub(super) struct Aside {
    instances: [MaybeUninit<u32>; MOST],
    primitives: [MaybeUninit<u32>; MOST],
}

/// A search that puts off what is unclear.
pub(super) struct PutOff<'a, S> {
    /// With what is certain.
    pub(super) search: S,
    aside: &'a mut Aside,
    /// How many there are; one more than there is room for, if there was none left.
    count: u32,
}

impl<'a, S: Search> PutOff<'a, S> {
    #[inline(always)]
    pub(super) const fn room() -> Aside {
        Aside { instances: [MaybeUninit::uninit(); MOST], primitives: [MaybeUninit::uninit(); MOST] }
    }

    #[inline(always)]
    pub(super) fn new(search: S, aside: &'a mut Aside) -> Self {
        PutOff { search, aside, count: 0 }
    }

    /// Decides what was put off. `false` if there was no room for all of it.
    #[inline(always)]
    pub(super) fn decide(&mut self, primitives: &PrimitivesView, world_ray: &Ray) -> bool {
        if self.count as usize > MOST {
            return false;
        }
        let mut k = 0;
        while k < self.count {
            // SAFETY: those below `count` were written.
            let place = unsafe {
                let instance = self.aside.instances.get_unchecked(k as usize).assume_init();
                Place { instance, primitive: self.aside.primitives.get_unchecked(k as usize).assume_init() }
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

impl<S: Search> Search for PutOff<'_, S> {
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
    fn offer_certain(&mut self, place: Place, low: f32, high: f32) -> Offered {
        self.search.offer_certain(place, low, high)
    }

    #[inline(always)]
    fn unclear(&mut self, _: &PrimitivesView, place: Place, _: PrimitiveId, _: &Placement) -> bool {
        let place_in = self.count as usize;
        self.count += 1;
        if place_in >= MOST {
            return true;
        }
        self.aside.instances[place_in].write(place.instance);
        self.aside.primitives[place_in].write(place.primitive);
        false
    }

    #[inline(always)]
    fn offer(
        &mut self,
        primitives: &PrimitivesView,
        ray: &Ray,
        place: Place,
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
