//! What is decided about rays of a packet one by one.

use super::{Best, LocalPacket, Query16, TO_LOW};
use crate::bvh8::trace::found::{ANY, Found, Offer, Query};
use crate::bvh8::view::Bvh8View;
use crate::simd::{Float, Kernel, Simd, Vec3V, each};
use eosphor_core::intersect::precise::{PreciseHit, PreciseRay};
use eosphor_core::intersect::{PackedTriangle, TriangleHit, intersect_precisely};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::{Hit, PrimitiveId, Ray, UNKNOWN_REST};

/// A ray of a leg, in the world.
#[inline(always)]
pub(super) fn world_ray<S: Simd>(leg: &LocalPacket<S>, lane: usize) -> Ray {
    // SAFETY: lanes: a vector is sixteen numbers of 32 bits; the lane is below 16.
    let read = |v: &S::F16| unsafe { *(&raw const *v).cast::<f32>().add(lane) };
    let vector = |v: &Vec3V<S::F16>| -> Vec3 { vec3(read(&v[0]), read(&v[1]), read(&v[2])) };
    Ray {
        origin: vector(&leg.world.origin),
        t_min: read(&leg.world.t_min),
        direction: vector(&leg.world.direction),
        t_max: read(&leg.world.t_max),
    }
}

impl<S: Simd> Best<S> {
    /// A ray's best hit and where it is.
    #[inline(always)]
    fn of_lane(&mut self, lane: usize) -> (Hit, u32) {
        // SAFETY: lanes: a vector is sixteen numbers of 32 bits; the lane is below 16.
        let read = |v: &S::F16| unsafe { *(&raw const *v).cast::<f32>().add(lane) };
        let id = PrimitiveId {
            instance: read(&self.instance).to_bits(),
            primitive: read(&self.primitive).to_bits(),
        };
        let t = read(&self.t);
        let t_rest = if self.precise >> lane & 1 == 1 { read(&self.t_rest) } else { UNKNOWN_REST };
        let hit = Hit { t, t_rest, u: read(&self.u), v: read(&self.v), id };
        (hit, read(&self.place).to_bits())
    }

    /// Replaces it.
    #[inline(always)]
    fn set_lane(&mut self, lane: usize, found: &Found) {
        // SAFETY: lanes: a vector is sixteen numbers of 32 bits; the lane is below 16.
        let write = |v: &mut S::F16, x: f32| unsafe { *(&raw mut *v).cast::<f32>().add(lane) = x };
        let hit = &found.best;
        self.precise = self.precise & !(1 << lane) | u32::from(hit.t_rest != UNKNOWN_REST) << lane;
        write(&mut self.t, hit.t);
        write(&mut self.t_rest, hit.t_rest);
        write(&mut self.u, hit.u);
        write(&mut self.v, hit.v);
        write(&mut self.place, f32::from_bits(found.place));
        write(&mut self.primitive, f32::from_bits(hit.id.primitive));
        write(&mut self.instance, f32::from_bits(hit.id.instance));
    }

    /// A ray's search, as one by one; its end is that of its best hit.
    #[inline(always)]
    pub(super) fn found(&mut self, lane: usize, end: f32) -> Found {
        let (best, place) = self.of_lane(lane);
        let low = best.t - TO_LOW * (end - best.t);
        Found::with(best, place, if low.is_nan() { best.t } else { low }, end)
    }

    /// Takes over what a search one by one has found.
    #[inline(always)]
    pub(super) fn take_over(&mut self, lane: usize, found: &Found, end: &mut f32) {
        *end = found.high;
        self.set_lane(lane, found);
    }
}

/// Core decides about rays that are not clear, and orders hits that lie close together, one by one: a function of its own,
/// since it is rare and large. What it needs is copied for it: what it had a reference to would always be written to memory.
pub(super) struct Decide<'a, 'b, S: Simd, const QUERY: Query> {
    pub(super) query: &'a Query16<'b, S>,
    pub(super) leg: &'a LocalPacket<'a, S>,
    pub(super) place: u32,
    /// Lane of the first ray of the part.
    pub(super) first: usize,
    /// Bits of lanes of the part.
    pub(super) lanes: u32,
    pub(super) clear: u32,
    /// What the first step says of those that are clear.
    pub(super) t: S::Part,
    pub(super) error: S::Part,
    pub(super) u: S::Part,
    pub(super) v: S::Part,
    pub(super) best: &'a mut Best<S>,
    /// A copy, so that the walk's own stays in registers.
    pub(super) ends: &'a mut S::F16,
}

impl<S: Simd, const QUERY: Query> Kernel for Decide<'_, '_, S, QUERY> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<X: Simd>(self) -> bool {
        let Decide { query, leg, place, first, lanes: mut left, clear, t, error, u, v, best, ends } = self;
        let bvh: &Bvh8View = query.bvh;
        let triangle = bvh.blocks[(place >> 2) as usize].get((place & 3) as usize);
        let id = PrimitiveId { instance: leg.instance, primitive: triangle.primitive };
        let map = (leg.instance != 0).then(|| &bvh.instances[leg.instance as usize].object_from_world);
        let (t, error, u, v) = (t.to_array(), error.to_array(), u.to_array(), v.to_array());
        let mut changed = false;
        let unclear = left & !clear;
        let in_lanes = (leg.instance == 0) & (triangle.length1 >= 0.0) & (unclear.count_ones() >= FEW_LANES);
        let precise = if in_lanes { PreciseHits::new(leg, first, &triangle) } else { PreciseHits::NONE };
        left &= clear | !precise.beside;
        while left != 0 {
            let own = left.trailing_zeros() as usize & 15;
            left &= left - 1;
            let lane = first + own;
            let ray = world_ray(leg, lane);
            let (nearest, _) = best.of_lane(lane);
            // What has been cut is met again.
            if QUERY != ANY && nearest.id == id {
                continue;
            }
            let hit = if clear >> own & 1 == 1 {
                let (t, t_error, u, v) =
                    (t.as_ref()[own], error.as_ref()[own], u.as_ref()[own], v.as_ref()[own]);
                TriangleHit { meets: true, is_clear: true, t, t_error, t_rest: UNKNOWN_REST, u, v }
            } else if precise.within >> own & 1 == 1 {
                TriangleHit::precise(&precise.hit(own), &ray)
            } else {
                intersect_precisely(&triangle, &ray, map)
            };
            if !hit.meets {
                continue;
            }
            // SAFETY: lanes: a vector is sixteen floats; the lane is below 16.
            let end = unsafe { &mut *(&raw mut *ends).cast::<f32>().add(lane) };
            if QUERY == ANY {
                *end = f32::NEG_INFINITY;
                changed = true;
                continue;
            }
            let mut found = best.found(lane, *end);
            found.offer::<QUERY>(&Offer { bvh, ray: &ray, hit, id, place });
            if found.best.id == id {
                best.take_over(lane, &found, end);
                changed = true;
            }
        }
        changed
    }
}

/// From so many lanes on, double precision is computed for all lanes of a part at once.
const FEW_LANES: u32 = 3;

/// Where rays of the world meet a triangle, in double precision.
struct PreciseHits {
    t: [f64; 16],
    u: [f64; 16],
    v: [f64; 16],
    /// Bits of those that meet it for certain, and of those that pass by. Of others this says nothing.
    within: u32,
    beside: u32,
}

impl PreciseHits {
    const NONE: PreciseHits = PreciseHits { t: [0.0; 16], u: [0.0; 16], v: [0.0; 16], within: 0, beside: 0 };

    /// Of the rays of a part, whose first has this lane.
    #[inline(always)]
    fn new<S: Simd>(leg: &LocalPacket<S>, first: usize, triangle: &PackedTriangle) -> PreciseHits {
        let [o, d] = [&leg.world.origin, &leg.world.direction].map(|v| each!(k => v[k].to_array()));
        let mut hits = PreciseHits::NONE;
        let (mut within, mut beside) = ([0u32; 16], [0u32; 16]);
        // A loop that becomes SIMD code.
        let mut own = 0;
        while own < S::PART {
            let at =
                |v: &[<S::F16 as Float>::Array; 3], k: usize| f64::from(v[k].as_ref()[(first + own) & 15]);
            let origin = [at(&o, 0), at(&o, 1), at(&o, 2)];
            let direction = [at(&d, 0), at(&d, 1), at(&d, 2)];
            let ray = PreciseRay { origin, direction };
            let passage = ray.passage(triangle);
            let hit = passage.hit();
            (hits.t[own], hits.u[own], hits.v[own]) = (hit.t, hit.u, hit.v);
            within[own] = u32::from(passage.is_within());
            beside[own] = u32::from(passage.is_beside(&ray));
            own += 1;
        }
        for own in 0..16 {
            hits.within |= within[own] << own;
            hits.beside |= beside[own] << own;
        }
        hits
    }

    #[inline(always)]
    fn hit(&self, own: usize) -> PreciseHit {
        PreciseHit { t: self.t[own], u: self.u[own], v: self.v[own] }
    }
}
