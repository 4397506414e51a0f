//! Searches seen from where a walk has moved the ray's origin to.

use super::candidates::{Placement, PrimitivesView};
use super::moved_bounds::{LOST, around, widening};
use super::search::{OfferOutcome, PrimitiveSlot, Search};
use crate::intersect::TriangleHit;
use crate::ray::{PrimitiveId, Ray};

/// What a search looks like from a point that a walk has moved the origin to.
pub(crate) struct Moved<'a, S> {
    pub(crate) search: &'a mut S,
    /// The search's `t` of that point.
    from: f64,
    /// The absolute value of the world ray's `t` at that point.
    distance: f64,
    /// If not, it is the search as it is.
    is_moved: bool,
}

impl<'a, S> Moved<'a, S> {
    /// To the point with these `t`, of the search and, as an absolute value, of the world ray.
    #[inline(always)]
    pub(crate) fn on(search: &'a mut S, from: f64, distance: f64) -> Self {
        Moved { search, from, distance, is_moved: true }
    }

    /// To the point with this `t`, of both, or nowhere.
    #[inline(always)]
    pub(crate) fn perhaps(search: &'a mut S, from: Option<f64>) -> Self {
        let (is_moved, from) = (from.is_some(), from.unwrap_or(0.0));
        Moved { search, from, distance: from.abs(), is_moved }
    }
}

impl<S: Search> Search for Moved<'_, S> {
    type Whole = S;

    #[inline(always)]
    fn whole(&mut self) -> &mut S {
        self.search
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        if !self.is_moved | (self.from == 0.0) {
            return self.search.t_max();
        }
        // What lies beyond the end by less than a `t` is rounded by may be a tie.
        around(self.search.end(), self.from, self.distance * LOST).1
    }

    #[inline(always)]
    fn end(&self) -> f64 {
        self.search.end() - self.from
    }

    /// The `t` of double precision, by which hits are ordered, has been rounded where the ray's own is large.
    #[inline(always)]
    fn offer_certain(&mut self, place: PrimitiveSlot, low: f32, high: f32) -> OfferOutcome {
        if !self.is_moved {
            return self.search.offer_certain(place, low, high);
        }
        let lost = self.distance * LOST;
        if self.from == 0.0 {
            return self.search.offer_certain(
                place,
                low - widening(low, lost as f32),
                high + widening(high, lost as f32),
            );
        }
        let low = around(low as f64, -self.from, lost).0;
        let high = around(high as f64, -self.from, lost).1;
        self.search.offer_certain(place, low, high)
    }

    #[inline(always)]
    fn unclear(
        &mut self,
        primitives: &PrimitivesView,
        place: PrimitiveSlot,
        id: PrimitiveId,
        placement: &Placement,
    ) -> bool {
        self.search.unclear(primitives, place, id, placement)
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
