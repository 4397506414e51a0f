//! What a traversal looks for, and what it has found so far.
//!
//! Most hits are clear, and their bounds of `t` tell which comes first. Of such a hit no more than that is kept, which is
//! little where registers are scarce; it is computed when the search is over. Where bounds overlap, double precision tells.

use super::SPHERE_REFERENCE;
use super::candidates::{Placement, PrimitivesView, trusted};
use super::moved_bounds::{around, around_end};
use crate::intersect::{T_ERROR, T_ROUNDING, TriangleHit};
use crate::material::NONE;
use crate::out_of_line::out_of_line_on_gpus;
use crate::ray::{Hit, PrimitiveId, Ray, UNKNOWN_REST};

/// Where a primitive is: the instance that places it, and its number in the array of triangles or, with
/// [`SPHERE_REFERENCE`], of spheres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PrimitiveSlot {
    pub(crate) instance: u32,
    pub(crate) primitive: u32,
}

impl PrimitiveSlot {
    const NONE: PrimitiveSlot = PrimitiveSlot { instance: 0, primitive: NONE };

    /// Its name.
    #[inline(always)]
    pub(crate) fn id(self, primitives: &PrimitivesView) -> PrimitiveId {
        let primitive = if self.primitive & SPHERE_REFERENCE == 0 {
            trusted(primitives.triangles, self.primitive).primitive
        } else {
            *trusted(primitives.sphere_primitives, self.primitive & !SPHERE_REFERENCE)
        };
        PrimitiveId { instance: self.instance, primitive }
    }
}

/// What became of a certain hit that was offered by its bounds.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum OfferOutcome {
    /// It has to be compared in double precision.
    Unclear,
    /// Taken.
    Taken,
    /// It ends the search.
    Ends,
}

/// What is looked for, and what was found so far.
pub(crate) trait Search {
    /// The search of which this one is a view from elsewhere.
    type Whole: Search;
    /// It.
    fn whole(&mut self) -> &mut Self::Whole;
    /// Hits beyond this cannot matter any more. Like all bounds, from the point that the search measures from.
    fn t_max(&self) -> f32;
    /// The same in double precision.
    fn end(&self) -> f64;
    /// Offers a hit of a triangle that is certain, with bounds of its `t`.
    fn offer_certain(&mut self, place: PrimitiveSlot, low: f32, high: f32) -> OfferOutcome;
    /// A primitive whose hits have to be computed to tell; `true` ends the search.
    #[inline(always)]
    fn unclear(
        &mut self,
        primitives: &PrimitivesView,
        place: PrimitiveSlot,
        id: PrimitiveId,
        placement: &Placement,
    ) -> bool
    where
        Self: Sized,
    {
        // What has been cut is met again.
        !self.has(primitives, id) && self.decide(primitives, place, id, placement)
    }
    /// Computes the hits of a primitive, and offers them to itself; `true` ends the search.
    fn decide(
        &mut self,
        primitives: &PrimitivesView,
        place: PrimitiveSlot,
        id: PrimitiveId,
        placement: &Placement,
    ) -> bool
    where
        Self: Sized,
    {
        primitives.decide(place, id, placement, self)
    }
    /// Offers a hit that was computed; `true` ends the search.
    fn offer(
        &mut self,
        primitives: &PrimitivesView,
        ray: &Ray,
        place: PrimitiveSlot,
        id: PrimitiveId,
        hit: &TriangleHit,
    ) -> bool;
    /// Whether the best hit so far is one of this triangle, and others of it do not matter.
    fn has(&self, primitives: &PrimitivesView, id: PrimitiveId) -> bool;
}

/// Defines [`Search::decide`] of a search by a function of its own on GPUs. That one gets a copy: what a walk keeps in registers
/// would otherwise lie in memory.
macro_rules! decide_by_function {
    ($function:ident) => {
        #[inline(always)]
        fn decide(
            &mut self,
            primitives: &PrimitivesView,
            place: PrimitiveSlot,
            id: PrimitiveId,
            placement: &Placement,
        ) -> bool {
            let mut search = *self;
            let ends = $function(primitives, place, id, placement, &mut search);
            *self = search;
            ends
        }
    };
}

/// Defines such a function.
macro_rules! decision {
    ($function:ident, $search:ty) => {
        out_of_line_on_gpus! {
            fn $function(
                primitives: &PrimitivesView,
                place: PrimitiveSlot,
                id: PrimitiveId,
                placement: &Placement,
                search: &mut $search,
            ) -> bool {
                primitives.decide(place, id, placement, search)
            }
        }
    };
}

decision! { decide_closest, Closest }
decision! { decide_any, Any }
decision! { decide_next, Next }

/// At least as large as a number that was rounded to this.
#[inline(always)]
pub fn upper(t: f32) -> f32 {
    t + t.abs() * T_ROUNDING
}

/// What the `t` of a hit may be wrong by that was found for this ray, but for rounding.
#[inline(always)]
fn error_of_last(ray: &Ray, last: &Hit) -> f32 {
    if last.t_rest != UNKNOWN_REST {
        return 0.0;
    }
    let (o, d) = (ray.origin.abs(), ray.direction.abs());
    // Twice what it can be, for the rounding of this.
    let from_0 = ((o.x + o.y) + o.z) / ((d.x + d.y) + d.z);
    2.0 * T_ERROR * (from_0 + last.t.abs())
}

/// Where a hit lies whose `t` is known like this, in a query for the next one: from here to there.
#[inline(always)]
pub fn bounds_of_last(ray: &Ray, last: &Hit) -> (f32, f32) {
    if !last.t.is_finite() {
        return (last.t, last.t);
    }
    let t = last.t64() as f32;
    let error = T_ROUNDING * t.abs() + error_of_last(ray, last);
    (t - error, t + error)
}

/// The nearest hit.
#[derive(Clone, Copy)]
pub(crate) struct Closest {
    /// Where the best hit is; its primitive is [`NONE`] as long as there is none.
    place: PrimitiveSlot,
    /// The best hit is no earlier than this,
    low: f32,
    /// and no later than this.
    high: f32,
    /// The best hit, if it has been computed.
    hit: TriangleHit,
    is_known: bool,
    /// The point that the search measures from, as a `t` of the world ray.
    from: f64,
}

impl Closest {
    #[inline(always)]
    pub(crate) fn new(t_max: f32, from: f64) -> Closest {
        let (low, high) = if from == 0.0 { (t_max, upper(t_max)) } else { around_end(t_max, from) };
        Closest { place: PrimitiveSlot::NONE, low, high, hit: TriangleHit::NOWHERE, is_known: false, from }
    }

    /// Bounds of a hit that was computed.
    #[inline(always)]
    fn bounds(
        &self,
        primitives: &PrimitivesView,
        ray: &Ray,
        place: PrimitiveSlot,
        hit: &TriangleHit,
    ) -> (f32, f32) {
        if self.from == 0.0 {
            return hit.bounds();
        }
        around(primitives.t64(place, hit, ray), self.from, 0.0)
    }

    #[inline(always)]
    fn is_none(&self) -> bool {
        self.place.primitive == NONE
    }

    /// The hit, computed.
    #[inline(always)]
    pub(crate) fn hit(&self, primitives: &PrimitivesView, ray: &Ray) -> Hit {
        if self.is_none() {
            return Hit::miss(ray.t_max);
        }
        let hit = if self.is_known { self.hit } else { primitives.exact_triangle(self.place, ray) };
        debug_assert!(hit.meets, "{:?} {ray:?} {hit:?}", self.place);
        Hit { t: hit.t, t_rest: hit.t_rest, u: hit.u, v: hit.v, id: self.place.id(primitives) }
    }

    /// [`Closest::hit`] with its rest.
    #[inline(always)]
    fn precise_hit(&self, primitives: &PrimitivesView, ray: &Ray) -> Hit {
        let hit = self.hit(primitives, ray);
        if hit.t_rest != UNKNOWN_REST {
            return hit;
        }
        Hit { t_rest: primitives.rest(self.place, hit.t, ray), ..hit }
    }

    #[inline(always)]
    fn take(&mut self, place: PrimitiveSlot, hit: &TriangleHit, (low, high): (f32, f32)) {
        *self = Closest { place, low, high, hit: *hit, is_known: true, from: self.from };
    }

    /// The `t` of the best hit, in double precision.
    #[inline(always)]
    fn t64(&self, primitives: &PrimitivesView, ray: &Ray) -> f64 {
        if self.is_known {
            primitives.t64(self.place, &self.hit, ray)
        } else {
            primitives.t64(self.place, &primitives.exact_triangle(self.place, ray), ray)
        }
    }
}

impl Search for Closest {
    type Whole = Self;

    decide_by_function! { decide_closest }

    #[inline(always)]
    fn whole(&mut self) -> &mut Self {
        self
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.high
    }

    #[inline(always)]
    fn end(&self) -> f64 {
        if self.is_known && !self.hit.is_clear {
            self.hit.t as f64 + self.hit.t_rest as f64 - self.from
        } else {
            self.high as f64
        }
    }

    #[inline(always)]
    fn offer_certain(&mut self, place: PrimitiveSlot, low: f32, high: f32) -> OfferOutcome {
        if high < self.low {
            (self.place, self.low, self.high, self.is_known) = (place, low, high, false);
            return OfferOutcome::Taken;
        }
        OfferOutcome::Unclear
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
        let bounds = self.bounds(primitives, ray, place, hit);
        let (low, high) = bounds;
        if self.is_none() || high < self.low {
            self.take(place, hit, bounds);
        } else if low <= self.high {
            let (t, best) = (primitives.t64(place, hit, ray), self.t64(primitives, ray));
            if (t < best) | ((t == best) && id.before(self.place.id(primitives))) {
                self.take(place, hit, bounds);
            }
        }
        false
    }

    #[inline(always)]
    fn has(&self, primitives: &PrimitivesView, id: PrimitiveId) -> bool {
        !self.is_none() && self.place.id(primitives) == id
    }
}

/// Any hit.
#[derive(Clone, Copy)]
pub(crate) struct Any {
    end: f32,
    pub(crate) found: bool,
}

impl Any {
    #[inline(always)]
    pub(crate) fn new(t_max: f32, from: f64) -> Any {
        let end = if from == 0.0 { upper(t_max) } else { around_end(t_max, from).1 };
        Any { end, found: false }
    }
}

impl Search for Any {
    type Whole = Self;

    decide_by_function! { decide_any }

    #[inline(always)]
    fn whole(&mut self) -> &mut Self {
        self
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.end
    }

    #[inline(always)]
    fn end(&self) -> f64 {
        self.end as f64
    }

    #[inline(always)]
    fn offer_certain(&mut self, _: PrimitiveSlot, _: f32, _: f32) -> OfferOutcome {
        self.found = true;
        OfferOutcome::Ends
    }

    #[inline(always)]
    fn offer(
        &mut self,
        _: &PrimitivesView,
        _: &Ray,
        _: PrimitiveSlot,
        _: PrimitiveId,
        _: &TriangleHit,
    ) -> bool {
        self.found = true;
        true
    }

    #[inline(always)]
    fn has(&self, _: &PrimitivesView, _: PrimitiveId) -> bool {
        false
    }
}

/// The nearest hit after another one.
#[derive(Clone, Copy)]
pub(crate) struct Next {
    after: Hit,
    /// The other one is no earlier than this, and no later than that, from the ray's origin;
    after_bounds: (f32, f32),
    /// and from where the search measures.
    after_high: f32,
    nearest: Closest,
}

impl Next {
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, after: &Hit, from: f64) -> Next {
        let after_bounds = bounds_of_last(ray, after);
        let after_high = if from == 0.0 {
            after_bounds.1
        } else {
            around(after.t64(), from, error_of_last(ray, after) as f64).1
        };
        Next { after: *after, after_bounds, after_high, nearest: Closest::new(ray.t_max, from) }
    }

    /// After nothing: what [`Closest`] finds, too.
    #[inline(always)]
    pub(crate) fn from_start(ray: &Ray) -> Next {
        let start = Hit { t: f32::NEG_INFINITY, t_rest: 0.0, u: 0.0, v: 0.0, id: PrimitiveId::NONE };
        Next::new(ray, &start, 0.0)
    }

    /// The hit, computed, with its rest.
    #[inline(always)]
    pub(crate) fn hit(&self, primitives: &PrimitivesView, ray: &Ray) -> Hit {
        self.nearest.precise_hit(primitives, ray)
    }

    /// The hit as [`Closest`] gives it.
    #[inline(always)]
    pub(crate) fn closest(&self, primitives: &PrimitivesView, ray: &Ray) -> Hit {
        self.nearest.hit(primitives, ray)
    }

    /// Whether a hit comes after the other one.
    #[inline(always)]
    fn is_after(
        &self,
        primitives: &PrimitivesView,
        ray: &Ray,
        place: PrimitiveSlot,
        id: PrimitiveId,
        hit: &TriangleHit,
    ) -> bool {
        let (low, high) = hit.bounds();
        let (after_low, after_high) = self.after_bounds;
        if (low > after_high) | (high < after_low) {
            return low > after_high;
        }
        let after = &self.after;
        // A triangle has one hit.
        if (id == after.id) & (place.primitive & SPHERE_REFERENCE == 0) {
            return false;
        }
        let mut rest = after.t_rest;
        if rest == UNKNOWN_REST {
            rest = primitives.rest_by_name(after, ray);
        }
        let after_t = after.t as f64 + rest as f64;
        let t = primitives.t64(place, hit, ray);
        (after_t < t) | ((after_t == t) & after.id.before(id))
    }
}

impl Search for Next {
    type Whole = Self;

    decide_by_function! { decide_next }

    #[inline(always)]
    fn whole(&mut self) -> &mut Self {
        self
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.nearest.t_max()
    }

    #[inline(always)]
    fn end(&self) -> f64 {
        self.nearest.end()
    }

    #[inline(always)]
    fn offer_certain(&mut self, place: PrimitiveSlot, low: f32, high: f32) -> OfferOutcome {
        if low > self.after_high {
            self.nearest.offer_certain(place, low, high)
        } else {
            OfferOutcome::Unclear
        }
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
        if self.is_after(primitives, ray, place, id, hit) {
            self.nearest.offer(primitives, ray, place, id, hit);
        }
        false
    }

    /// A sphere has two hits, a triangle one.
    #[inline(always)]
    fn has(&self, primitives: &PrimitivesView, id: PrimitiveId) -> bool {
        self.nearest.has(primitives, id)
    }
}
