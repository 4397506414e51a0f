//! What a traversal looks for, and what it has found so far.
//!
//! Most hits are clear, and their bounds of `t` tell which comes first. Of such a hit no more than that is kept, which is
//! little where registers are scarce; it is computed when the search is over. Where bounds overlap, double precision tells.

use super::SPHERE_REFERENCE;
use super::candidates::{Placement, PrimitivesView, item};
use crate::intersect::{T_ERROR, T_ROUNDING, TriangleHit};
use crate::material::NONE;
use crate::ray::{Hit, PrimitiveId, Ray, UNKNOWN_REST};

/// Where a primitive is: the instance that places it, and its number in the array of triangles or, with
/// [`SPHERE_REFERENCE`], of spheres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) instance: u32,
    pub(super) primitive: u32,
}

impl Place {
    const NONE: Place = Place { instance: 0, primitive: NONE };

    /// Its name.
    #[inline(always)]
    pub(super) fn id(self, primitives: &PrimitivesView) -> PrimitiveId {
        let primitive = if self.primitive & SPHERE_REFERENCE == 0 {
            item(primitives.triangles, self.primitive).primitive
        } else {
            *item(primitives.sphere_primitives, self.primitive & !SPHERE_REFERENCE)
        };
        PrimitiveId { instance: self.instance, primitive }
    }
}

/// What became of a clear hit that was offered by its bounds.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Offered {
    /// It has to be compared in double precision.
    Unclear,
    /// Taken.
    Taken,
    /// It ends the search.
    Ends,
}

/// What is looked for, and what was found so far.
pub(super) trait Search {
    /// Whether the walk measures `t` from elsewhere than the ray's origin. What it finds out about hits is no more than
    /// that they may be there.
    const IS_MOVED: bool = false;
    /// The search that measures from the ray's origin.
    type Whole: Search;
    /// It.
    fn whole(&mut self) -> &mut Self::Whole;
    /// Hits beyond this cannot matter any more.
    fn t_max(&self) -> f32;
    /// The same in double precision.
    fn end(&self) -> f64;
    /// Offers a clear hit of a triangle, with bounds of its `t`.
    fn offer_clear(&mut self, place: Place, low: f32, high: f32) -> Offered;
    /// A primitive whose hits have to be computed to tell; `true` ends the search.
    #[inline(always)]
    fn unclear(
        &mut self,
        primitives: &PrimitivesView,
        place: Place,
        id: PrimitiveId,
        placement: &Placement,
    ) -> bool
    where
        Self: Sized,
    {
        // What has been cut is met again.
        !self.has(primitives, id) && primitives.decide(place, id, placement, self)
    }
    /// Offers a hit that was computed; `true` ends the search.
    fn offer(
        &mut self,
        primitives: &PrimitivesView,
        ray: &Ray,
        place: Place,
        id: PrimitiveId,
        hit: &TriangleHit,
    ) -> bool;
    /// Whether the best hit so far is one of this triangle, and others of it do not matter.
    fn has(&self, primitives: &PrimitivesView, id: PrimitiveId) -> bool;
}

/// At least as large as a number that was rounded to this.
#[inline(always)]
pub fn upper(t: f32) -> f32 {
    t + t.abs() * T_ROUNDING
}

/// Where a hit lies whose `t` is known like this, in a query for the next one: from here to there.
#[inline(always)]
pub fn bounds_of_last(ray: &Ray, last: &Hit) -> (f32, f32) {
    if !last.t.is_finite() {
        return (last.t, last.t);
    }
    let (o, d) = (ray.origin.abs(), ray.direction.abs());
    let t = last.t64() as f32;
    let mut error = T_ROUNDING * t.abs();
    if last.t_rest == UNKNOWN_REST {
        // Twice what it can be, for the rounding of this.
        let from_0 = ((o.x + o.y) + o.z) / ((d.x + d.y) + d.z);
        error = 2.0 * T_ERROR * (from_0 + t.abs());
    }
    (t - error, t + error)
}

/// The nearest hit.
pub(super) struct Closest {
    /// Where the best hit is; its primitive is [`NONE`] as long as there is none.
    place: Place,
    /// The best hit is no earlier than this,
    low: f32,
    /// and no later than this.
    high: f32,
    /// The best hit, if it has been computed.
    hit: TriangleHit,
    is_known: bool,
}

impl Closest {
    #[inline(always)]
    pub(super) fn new(t_max: f32) -> Closest {
        Closest {
            place: Place::NONE,
            low: t_max,
            high: upper(t_max),
            hit: TriangleHit::NOWHERE,
            is_known: false,
        }
    }

    #[inline(always)]
    fn is_none(&self) -> bool {
        self.place.primitive == NONE
    }

    /// The hit, computed.
    #[inline(always)]
    pub(super) fn hit(&self, primitives: &PrimitivesView, ray: &Ray) -> Hit {
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
    fn take(&mut self, place: Place, hit: &TriangleHit) {
        let (low, high) = hit.bounds();
        *self = Closest { place, low, high, hit: *hit, is_known: true };
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
            self.hit.t as f64 + self.hit.t_rest as f64
        } else {
            self.high as f64
        }
    }

    #[inline(always)]
    fn offer_clear(&mut self, place: Place, low: f32, high: f32) -> Offered {
        if high < self.low {
            (self.place, self.low, self.high, self.is_known) = (place, low, high, false);
            return Offered::Taken;
        }
        Offered::Unclear
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
        let (low, high) = hit.bounds();
        if self.is_none() || high < self.low {
            self.take(place, hit);
        } else if low <= self.high {
            let (t, best) = (primitives.t64(place, hit, ray), self.t64(primitives, ray));
            if (t < best) | ((t == best) && id.before(self.place.id(primitives))) {
                self.take(place, hit);
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
pub(super) struct Any {
    pub(super) t_max: f32,
    pub(super) found: bool,
}

impl Search for Any {
    type Whole = Self;

    #[inline(always)]
    fn whole(&mut self) -> &mut Self {
        self
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        upper(self.t_max)
    }

    #[inline(always)]
    fn end(&self) -> f64 {
        upper(self.t_max) as f64
    }

    #[inline(always)]
    fn offer_clear(&mut self, _: Place, _: f32, _: f32) -> Offered {
        self.found = true;
        Offered::Ends
    }

    #[inline(always)]
    fn offer(&mut self, _: &PrimitivesView, _: &Ray, _: Place, _: PrimitiveId, _: &TriangleHit) -> bool {
        self.found = true;
        true
    }

    #[inline(always)]
    fn has(&self, _: &PrimitivesView, _: PrimitiveId) -> bool {
        false
    }
}

/// The nearest hit after another one.
pub(super) struct Next {
    after: Hit,
    /// The other one is no earlier than this, and no later than that.
    after_bounds: (f32, f32),
    nearest: Closest,
}

impl Next {
    #[inline(always)]
    pub(super) fn new(ray: &Ray, after: &Hit) -> Next {
        Next { after: *after, after_bounds: bounds_of_last(ray, after), nearest: Closest::new(ray.t_max) }
    }

    /// The hit, computed, with its rest.
    #[inline(always)]
    pub(super) fn hit(&self, primitives: &PrimitivesView, ray: &Ray) -> Hit {
        self.nearest.precise_hit(primitives, ray)
    }

    /// Whether a hit comes after the other one.
    #[inline(always)]
    fn is_after(
        &self,
        primitives: &PrimitivesView,
        ray: &Ray,
        place: Place,
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
            rest = primitives.rest_by_name(after.id, after.t, ray);
        }
        let after_t = after.t as f64 + rest as f64;
        let t = primitives.t64(place, hit, ray);
        (after_t < t) | ((after_t == t) & after.id.before(id))
    }
}

impl Search for Next {
    type Whole = Self;

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
    fn offer_clear(&mut self, place: Place, low: f32, high: f32) -> Offered {
        if low > self.after_bounds.1 { self.nearest.offer_clear(place, low, high) } else { Offered::Unclear }
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

/// Where a search ends, as seen from a point that a walk has moved the origin to.
#[inline(always)]
pub fn moved_end(end: f64, from: f64) -> f32 {
    // Of the sums in double precision, 2^-50 may be lost.
    upper((end - from + (end.abs() + from.abs()) * (1.0 / (1u64 << 50) as f64)) as f32)
}

/// A search by a walk that measures `t` from a point that it has moved the origin to.
pub(super) struct Moved<'a, S> {
    pub(super) search: &'a mut S,
    /// The ray's own `t` of that point.
    pub(super) from: f64,
}

impl<S: Search> Search for Moved<'_, S> {
    const IS_MOVED: bool = true;
    type Whole = S;

    #[inline(always)]
    fn whole(&mut self) -> &mut S {
        self.search
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        // Of the sums in double precision, 2^-50 may be lost.
        moved_end(self.search.end(), self.from)
    }

    #[inline(always)]
    fn end(&self) -> f64 {
        self.search.end() - self.from
    }

    #[inline(always)]
    fn offer_clear(&mut self, _: Place, _: f32, _: f32) -> Offered {
        Offered::Unclear
    }

    #[inline(always)]
    fn unclear(
        &mut self,
        primitives: &PrimitivesView,
        place: Place,
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
