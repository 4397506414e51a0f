//! What a traversal looks for, and what it has found so far.
//!
//! Most hits are certain long before they are computed: the ray passes so far within the edges that rounding cannot have
//! brought it there, and nothing that was met before is near. Of such a hit bounds of its `t` are kept, which is little
//! where registers are scarce; it is computed when the search is over, or when something comes close.

use super::SPHERE_REFERENCE;
use super::candidates::{Placement, PrimitivesView, item};
use crate::material::NONE;
use crate::ray::{Hit, PrimitiveId, Ray};

/// Where a primitive is: the instance that places it, and its number in the array of triangles or, with
/// [`SPHERE_REFERENCE`], of spheres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) instance: u32,
    pub(super) primitive: u32,
}

impl Place {
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

/// What became of a hit that was offered by its bounds.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Offered {
    /// It has to be computed to tell.
    Unclear,
    /// Taken.
    Taken,
    /// It ends the search.
    Ends,
}

/// What is looked for, and what was found so far.
pub(super) trait Search {
    /// Hits beyond this cannot matter any more.
    fn t_max(&self) -> f32;
    /// Offers a hit of a triangle that counts for certain, with bounds of its `t`.
    fn offer_certain(&mut self, place: Place, low: f32, high: f32) -> Offered;
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
        t: f32,
    ) -> bool;
    /// Whether the best hit so far is one of this triangle, and others of it do not matter.
    fn has(&self, primitives: &PrimitivesView, id: PrimitiveId) -> bool;
}

/// The nearest hit.
pub(super) struct Closest {
    /// Where the best hit is; its primitive is [`NONE`] as long as there is none.
    place: Place,
    /// The best hit is no earlier than this,
    low: f32,
    /// and no later than this.
    high: f32,
}

impl Closest {
    #[inline(always)]
    pub(super) fn new(t_max: f32) -> Closest {
        Closest { place: Place { instance: 0, primitive: NONE }, low: t_max, high: t_max }
    }

    /// The hit, computed.
    #[inline(always)]
    pub(super) fn hit(&self, primitives: &PrimitivesView, ray: &Ray) -> Hit {
        let place = self.place;
        if place.primitive == NONE {
            return Hit::miss(ray.t_max);
        }
        let id = place.id(primitives);
        if place.primitive & SPHERE_REFERENCE != 0 {
            return Hit { t: self.low, u: 0.0, v: 0.0, id };
        }
        let is_certain = self.low < self.high;
        let hit = if is_certain {
            primitives.confirmed_triangle(place, ray)
        } else {
            primitives.exact_triangle(place, ray)
        };
        debug_assert!(hit.meets & (self.low <= hit.t) & (hit.t <= self.high), "{place:?} {ray:?}");
        Hit { t: hit.t, u: hit.u, v: hit.v, id }
    }
}

impl Search for Closest {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.high
    }

    #[inline(always)]
    fn offer_certain(&mut self, place: Place, low: f32, high: f32) -> Offered {
        if high < self.low {
            *self = Closest { place, low, high };
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
        t: f32,
    ) -> bool {
        if self.low < self.high {
            let best = primitives.exact_triangle(self.place, ray).t;
            (self.low, self.high) = (best, best);
        }
        let is_first = self.place.primitive == NONE;
        if (t < self.high) | ((t == self.high) && (is_first || id.before(self.place.id(primitives)))) {
            *self = Closest { place, low: t, high: t };
        }
        false
    }

    #[inline(always)]
    fn has(&self, primitives: &PrimitivesView, id: PrimitiveId) -> bool {
        self.place.primitive != NONE && self.place.id(primitives) == id
    }
}

/// Any hit.
pub(super) struct Any {
    pub(super) t_max: f32,
    pub(super) found: bool,
}

impl Search for Any {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn offer_certain(&mut self, _: Place, _: f32, high: f32) -> Offered {
        self.found |= high <= self.t_max;
        if self.found { Offered::Ends } else { Offered::Unclear }
    }

    #[inline(always)]
    fn offer(&mut self, _: &PrimitivesView, _: &Ray, _: Place, _: PrimitiveId, t: f32) -> bool {
        self.found |= t <= self.t_max;
        self.found
    }

    #[inline(always)]
    fn has(&self, _: &PrimitivesView, _: PrimitiveId) -> bool {
        false
    }
}

/// The nearest hit after another one.
pub(super) struct Next {
    after: Hit,
    nearest: Closest,
}

impl Next {
    #[inline(always)]
    pub(super) fn new(t_max: f32, after: &Hit) -> Next {
        Next { after: *after, nearest: Closest::new(t_max) }
    }

    /// The hit, computed.
    #[inline(always)]
    pub(super) fn hit(&self, primitives: &PrimitivesView, ray: &Ray) -> Hit {
        self.nearest.hit(primitives, ray)
    }
}

impl Search for Next {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.nearest.t_max()
    }

    #[inline(always)]
    fn offer_certain(&mut self, place: Place, low: f32, high: f32) -> Offered {
        if low > self.after.t { self.nearest.offer_certain(place, low, high) } else { Offered::Unclear }
    }

    #[inline(always)]
    fn offer(
        &mut self,
        primitives: &PrimitivesView,
        ray: &Ray,
        place: Place,
        id: PrimitiveId,
        t: f32,
    ) -> bool {
        if (self.after.t < t) | ((self.after.t == t) & self.after.id.before(id)) {
            self.nearest.offer(primitives, ray, place, id, t);
        }
        false
    }

    /// A sphere has two hits, a triangle one.
    #[inline(always)]
    fn has(&self, primitives: &PrimitivesView, id: PrimitiveId) -> bool {
        self.nearest.has(primitives, id)
    }
}
