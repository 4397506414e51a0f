//! What the traversals share: the kinds of query, what was found ([`Found`]), and how large stacks are.

use super::triangle_search::find_triangle;
use crate::bvh8::view::Bvh8View;
use eosphor_core::hierarchy::{bounds_of_last, moved_end, moved_start, upper};
use eosphor_core::intersect::{
    EDGE_SLACK, TriangleHit, UV_ERROR, intersect_precisely, intersect_triangle, t_rest,
};
use eosphor_core::ray::{Hit, PrimitiveId, Ray, UNKNOWN_REST};

/// The three queries, as constants so that each traversal is compiled for each.
pub(super) type Query = u8;
/// The nearest hit.
pub(super) const CLOSEST: Query = 0;
/// Whether there is any.
pub(super) const ANY: Query = 1;
/// The nearest hit after another one.
pub(super) const NEXT: Query = 2;

/// Places on a stack: at each level of the tree up to seven children wait, and a level has half the nodes of the one
/// below or a depth below that of the tree with two children a node, so 64 levels at most; and 8 more, since whole
/// vectors are written.
pub(super) const STACK: usize = 64 * 7 + 16;

/// In place of the place of a triangle.
pub(super) const NO_TRIANGLE: u32 = u32::MAX;

/// From this many lengths of both edges on, hits of a triangle are not clear: what edge functions may be wrong by is above
/// [`UV_ERROR`] of the determinant, which is at most a quarter of the square of that length. (Twice that, for rounding.)
const NEVER_CLEAR: f32 = 2.0 * 0.25 * UV_ERROR / EDGE_SLACK;

/// What a single ray has found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// The best hit, or a miss at the largest `t` that counts.
    pub(super) best: Hit,
    /// The place of the best hit's triangle, four times its block's number and its lane; or [`NO_TRIANGLE`].
    pub(super) place: u32,
    /// No earlier than the best hit: what starts beyond it is left out. From where the walk measures.
    pub(super) end: f32,
    /// A hit that is over before this is nearer than the best one. From where the walk measures.
    pub(super) before: f32,
    /// What the two are from the ray's origin, unless the best hit is open.
    pub(super) high: f32,
    pub(super) low: f32,
    /// From where the walk measures, if not from the ray's origin.
    pub(super) from: Option<f64>,
    /// For [`NEXT`]: only hits after this one count.
    pub(super) after: Option<Hit>,
    /// For [`ANY`]: there is one.
    pub(super) any: bool,
}

/// A hit that is offered.
pub(super) struct Offer<'a> {
    pub(super) bvh: &'a Bvh8View<'a>,
    pub(super) ray: &'a Ray,
    pub(super) hit: TriangleHit,
    pub(super) id: PrimitiveId,
    /// As [`Found::place`].
    pub(super) place: u32,
}

/// A hit's `t` in double precision.
fn t64(bvh: &Bvh8View, ray: &Ray, (t, rest): (f32, f32), id: PrimitiveId, place: u32) -> f64 {
    let rest = if rest == UNKNOWN_REST { rest_of(bvh, ray, t, id, place) } else { rest };
    f64::from(t) + f64::from(rest)
}

/// What the `t` of a triangle's hit lacks of that of double precision.
fn rest_of(bvh: &Bvh8View, ray: &Ray, t: f32, id: PrimitiveId, place: u32) -> f32 {
    let map = (id.instance != 0).then(|| &bvh.instances[id.instance as usize].object_from_world);
    let triangle = bvh.blocks[(place >> 2) as usize].get((place & 3) as usize);
    t_rest(&triangle, t, ray, map)
}

impl Found {
    #[inline(always)]
    pub(super) fn nothing(t_max: f32) -> Found {
        Found::with(Hit::miss(t_max), NO_TRIANGLE, t_max, upper(t_max))
    }

    /// A best hit, no earlier than `low` and no later than `high`.
    #[inline(always)]
    pub(super) fn with(best: Hit, place: u32, low: f32, high: f32) -> Found {
        Found { best, place, end: high, before: low, high, low, from: None, after: None, any: false }
    }

    /// Measures from elsewhere.
    #[cold]
    pub(super) fn measure_from(&mut self, from: Option<f64>) {
        self.from = from;
        (self.before, self.end) = match from {
            None => (self.low, self.high),
            Some(from) => {
                let is_precise = !self.best.is_miss() && self.best.t_rest != UNKNOWN_REST;
                let t = f64::from(self.best.t) + f64::from(self.best.t_rest);
                let (low, high) = if is_precise { (t, t) } else { (self.low.into(), self.high.into()) };
                (moved_start(low, from), moved_end(high, from))
            }
        };
    }

    /// Whether no more is known of the best hit than where it is, and bounds from where the walk measures.
    #[inline(always)]
    fn is_open(&self) -> bool {
        self.best.t.is_nan() & (self.place != NO_TRIANGLE)
    }

    /// Takes a hit by its bounds from where the walk measures, and leaves it open.
    #[inline(always)]
    pub(super) fn take_open(&mut self, id: PrimitiveId, place: u32, low: f32, high: f32) {
        self.best = Hit { t: f32::NAN, t_rest: UNKNOWN_REST, u: 0.0, v: 0.0, id };
        (self.place, self.before, self.end) = (place, low, high);
    }

    /// Computes the best hit if it is open. After it, the search has to measure anew.
    #[inline(always)]
    pub(super) fn close(&mut self, bvh: &Bvh8View, ray: &Ray) {
        if !self.is_open() {
            return;
        }
        let (id, place) = (self.best.id, self.place);
        let instance = &bvh.instances[id.instance as usize];
        let map = (id.instance != 0).then_some(&instance.object_from_world);
        let extent = bvh.geometries[instance.geometry as usize].extent;
        let triangle = bvh.blocks[(place >> 2) as usize].get((place & 3) as usize);
        // From so far away, single precision is never clear.
        let lengths = triangle.length1 + triangle.length2;
        let is_farthest = map.is_none() & (ray.origin.abs().max_component() - extent > NEVER_CLEAR * lengths);
        let hit = if is_farthest {
            intersect_precisely(&triangle, ray, None)
        } else {
            intersect_triangle(&triangle, ray, map, extent)
        };
        debug_assert!(hit.meets, "{id:?} {ray:?} {hit:?}");
        self.set(&Offer { bvh, ray, hit, id, place });
    }

    /// Takes a hit.
    #[inline(always)]
    pub(super) fn take(&mut self, hit: Hit, place: u32, low: f32, high: f32) {
        (self.best, self.place, self.before, self.end) = (hit, place, low, high);
        (self.low, self.high) = (low, high);
    }

    fn set(&mut self, offer: &Offer) {
        let h = &offer.hit;
        let (low, high) = h.bounds();
        self.take(Hit { t: h.t, t_rest: h.t_rest, u: h.u, v: h.v, id: offer.id }, offer.place, low, high);
    }

    /// Whether a hit comes after [`Found::after`].
    fn is_after(&self, offer: &Offer) -> bool {
        let (low, high) = offer.hit.bounds();
        let Some(after) = &self.after else { return true };
        let (after_low, after_high) = bounds_of_last(offer.ray, after);
        if (low > after_high) | (high < after_low) {
            return low > after_high;
        }
        // A triangle has one hit.
        if (offer.id == after.id) & (offer.place != NO_TRIANGLE) {
            return false;
        }
        let mut rest = after.t_rest;
        if rest == UNKNOWN_REST {
            rest = match find_triangle(offer.bvh, offer.ray, after) {
                Some(place) => rest_of(offer.bvh, offer.ray, after.t, after.id, place),
                None => 0.0,
            };
        }
        let after_t = f64::from(after.t) + f64::from(rest);
        let hit = &offer.hit;
        let t = t64(offer.bvh, offer.ray, (hit.t, hit.t_rest), offer.id, offer.place);
        (after_t < t) | ((after_t == t) & after.id.before(offer.id))
    }

    /// Offers a hit that counts; `true` ends the search.
    pub(super) fn offer<const QUERY: Query>(&mut self, offer: &Offer) -> bool {
        if QUERY == ANY {
            self.any = true;
            return true;
        }
        if QUERY == NEXT && !self.is_after(offer) {
            return false;
        }
        self.close(offer.bvh, offer.ray);
        let (low, high) = offer.hit.bounds();
        if self.best.is_miss() || high < self.low {
            self.set(offer);
        } else if low <= self.high {
            let Offer { bvh, ray, ref hit, id, place } = *offer;
            let best = t64(bvh, ray, (self.best.t, self.best.t_rest), self.best.id, self.place);
            let t = t64(bvh, ray, (hit.t, hit.t_rest), id, place);
            if (t < best) | ((t == best) & id.before(self.best.id)) {
                self.set(offer);
            }
        }
        if self.from.is_some() {
            self.measure_from(self.from);
        }
        false
    }

    /// Computes the rest of the best hit's `t`.
    #[inline(always)]
    pub(super) fn complete(&mut self, bvh: &Bvh8View, ray: &Ray) {
        let best = &mut self.best;
        if best.t_rest == UNKNOWN_REST {
            best.t_rest = rest_of(bvh, ray, best.t, best.id, self.place);
        }
    }
}
