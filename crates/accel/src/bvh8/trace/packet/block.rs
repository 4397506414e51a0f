//! Four triangles against sixteen rays.

use super::{Best, Leg, MaskOf, Query16};
use crate::bvh8::TriangleBlock;
use crate::bvh8::trace::lanes::{StepTriangles, StepV, first_step};
use crate::bvh8::trace::walk::{ANY, Found, Offer, Query};
use crate::bvh8::view::Bvh8View;
use crate::simd::{Float, Kernel, Mask, Simd, Vec3V, cross, dot, each, subtract};
use eosphor_core::intersect::{TriangleHit, UNDERFLOW_SLACK, intersect_precisely};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::{Hit, PrimitiveId, Ray, UNKNOWN_REST};

/// What is the same for all rays about the triangles of a block: a triangle a lane, in memory.
struct Shared {
    e1: [[f32; 4]; 3],
    e2: [[f32; 4]; 3],
    normal: [[f32; 4]; 3],
    /// Times the rays' [`EDGE_SLACK`], more than edge functions can be wrong by.
    slack: [f32; 4],
    /// For rays from one point, with C the first vertex as seen from there: C × e2 and C × e1 turned so that the edge
    /// functions are products with the direction.
    function_u: [[f32; 4]; 3],
    function_v: [[f32; 4]; 3],
}

/// By how much larger than core's the slack is here, where products are made in another order. It only lets more pass.
const LARGER: f32 = 2.0;

#[inline(always)]
fn load3<S: Simd>(v: &[[f32; 4]; 3]) -> Vec3V<S::F4> {
    each!(k => S::F4::from_array(&v[k]))
}

#[inline(always)]
fn store3<S: Simd>(v: &Vec3V<S::F4>) -> [[f32; 4]; 3] {
    each!(k => v[k].to_array())
}

#[inline(always)]
fn lane3<S: Simd>(v: &[[f32; 4]; 3], lane: usize) -> Vec3V<S::F16> {
    each!(k => S::F16::splat(v[k][lane]))
}

#[inline(always)]
fn sum4<S: Simd>(v: &Vec3V<S::F4>) -> S::F4 {
    v[0].abs().add(v[1].abs()).add(v[2].abs())
}

impl Shared {
    /// `farthest` is no less than what any of the rays' origins is away from 0, with the rounding of their space.
    #[inline(always)]
    fn new<S: Simd>(block: &TriangleBlock, origin: Option<[f32; 3]>, farthest: f32) -> Shared {
        let v0 = load3::<S>(&block.v0);
        let e1 = subtract(&load3::<S>(&block.v1), &v0);
        let e2 = subtract(&load3::<S>(&block.v2), &v0);
        let normal = cross(&e1, &e2);
        let lengths = S::F4::from_array(&block.length1).add(S::F4::from_array(&block.length2));
        let nothing = [[0.0; 4]; 3];
        let (mut function_u, mut function_v) = (nothing, nothing);
        let distance = sum4::<S>(&v0).add(S::F4::splat(farthest)).add(lengths.abs());
        if let Some(origin) = origin {
            let from_origin = subtract(&v0, &each!(k => S::F4::splat(origin[k])));
            function_u = store3::<S>(&cross(&e2, &from_origin));
            function_v = store3::<S>(&cross(&e1, &from_origin));
        }
        Shared {
            e1: store3::<S>(&e1),
            e2: store3::<S>(&e2),
            normal: store3::<S>(&normal),
            slack: S::F4::splat(LARGER).mul(distance).mul(lengths).to_array(),
            function_u,
            function_v,
        }
    }
}

impl<S: Simd> Best<S> {
    /// Tests up to four triangles; whether any ray has a new hit.
    ///
    /// First lets pass all rays that may meet a triangle: with edges a little further out than in core's first step. Few are
    /// left, and that is computed for these.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "what a walk keeps in registers")]
    pub(super) unsafe fn test_block<const QUERY: Query>(
        &mut self,
        query: &Query16<S>,
        number: u32,
        leg: &Leg<S>,
        active: MaskOf<S>,
        one_origin: Option<[f32; 3]>,
        farthest: f32,
        end: &mut S::F16,
    ) -> bool {
        // SAFETY: leaves name blocks that the builder made.
        let block = unsafe { query.bvh.blocks.get_unchecked(number as usize) };
        let ray = &leg.ray;
        let shared = Shared::new::<S>(block, one_origin, farthest);
        let one_point = one_origin.is_some();
        let mut changed = false;
        let mut lane = 0;
        // Unused lanes come last.
        let used = block.count::<S>();
        while lane < used {
            let normal = lane3::<S>(&shared.normal, lane);
            let determinant = dot(&normal, &ray.direction);
            let sign = determinant.sign();
            let size = determinant.xor(sign);
            let (u, v);
            if one_point {
                u = dot(&lane3::<S>(&shared.function_u, lane), &ray.direction);
                v = dot(&lane3::<S>(&shared.function_v, lane), &ray.direction);
            } else {
                let r = cross(&subtract(&lane3::<S>(&block.v0, lane), &ray.origin), &ray.direction);
                u = dot(&r, &lane3::<S>(&shared.e2, lane));
                v = dot(&r, &lane3::<S>(&shared.e1, lane));
            }
            let u = u.xor(sign);
            let v = v.xor(sign.negate());
            let least = u.min(v).min(size.sub(u).sub(v));
            let slack = ray.edge_slack.fma(S::F16::splat(shared.slack[lane]), S::F16::splat(UNDERFLOW_SLACK));
            let candidates = active.without(least.lt(slack.negate()));
            if candidates.any() {
                let (from_origin, distance) = ray.vertex_seen(&lane3::<S>(&block.v0, lane));
                let triangle = StepTriangles {
                    e1: lane3::<S>(&shared.e1, lane),
                    e2: lane3::<S>(&shared.e2, lane),
                    normal,
                    length1: S::F16::splat(block.length1[lane]),
                    length2: S::F16::splat(block.length2[lane]),
                    from_origin,
                    distance,
                };
                let step = first_step(&ray.step_rays(), &triangle);
                let place = number << 2 | lane as u32;
                // SAFETY: the caller's.
                changed |= unsafe { self.offer::<QUERY>(query, &step, candidates, leg, place, end) };
            }
            lane += 1;
        }
        changed
    }

    /// Takes what the first step says of a triangle; whether any ray has a new hit.
    #[inline(always)]
    unsafe fn offer<const QUERY: Query>(
        &mut self,
        query: &Query16<S>,
        step: &StepV<S::F16>,
        candidates: MaskOf<S>,
        leg: &Leg<S>,
        place: u32,
        end: &mut S::F16,
    ) -> bool {
        let block = &query.bvh.blocks[(place >> 2) as usize];
        let primitive = block.primitive[(place & 3) as usize];
        let beyond = step.high.lt(leg.ray.t_min).or((*end).lt(step.low)).and(step.is_steep);
        let mut mask = candidates.without(step.misses.or(beyond));
        if let Some(filters) = query.lane_filters {
            mask = filters.apply(mask, leg.instance, primitive, step.sign);
        }
        let clear = mask.and(step.is_clear);
        if QUERY == ANY {
            *end = S::F16::splat(f32::NEG_INFINITY).or_else(clear, *end);
            let unclear = mask.without(clear);
            let mut changed = clear.any();
            if unclear.any() {
                let bits = MaskOf::<S>::from_bits(0);
                let decide = Decide::<S, QUERY> {
                    query,
                    step,
                    leg,
                    place,
                    lanes: unclear,
                    clear: bits,
                    best: self,
                    end,
                };
                // SAFETY: the caller's.
                changed |= unsafe { S::run(decide) };
            }
            return changed;
        }
        let better = clear.and(step.high.lt(self.low));
        let mut changed = better.any();
        if changed {
            *end = step.high.or_else(better, *end);
            self.low = step.low.or_else(better, self.low);
            self.t = step.t.or_else(better, self.t);
            self.t_rest = S::F16::splat(UNKNOWN_REST).or_else(better, self.t_rest);
            self.u = step.u.or_else(better, self.u);
            self.v = step.v.or_else(better, self.v);
            self.place = S::F16::splat(f32::from_bits(place)).or_else(better, self.place);
            self.primitive = S::F16::splat(f32::from_bits(primitive)).or_else(better, self.primitive);
            self.instance = S::F16::splat(f32::from_bits(leg.instance)).or_else(better, self.instance);
        }
        // What is not beyond the best hit and not before it, or not clear.
        let lanes = mask.without(better);
        if lanes.any() {
            let decide = Decide::<S, QUERY> { query, step, leg, place, lanes, clear, best: self, end };
            // SAFETY: the caller's.
            changed |= unsafe { S::run(decide) };
        }
        changed
    }

    /// A ray's best hit and where it is.
    #[inline(always)]
    fn of_lane(&mut self, lane: usize) -> (Hit, u32) {
        // SAFETY: a vector is sixteen numbers of 32 bits; the lane is below 16.
        let read = |v: &S::F16| unsafe { *(&raw const *v).cast::<f32>().add(lane) };
        let id = PrimitiveId {
            instance: read(&self.instance).to_bits(),
            primitive: read(&self.primitive).to_bits(),
        };
        let (t, t_rest) = (read(&self.t), read(&self.t_rest));
        let hit = Hit { t, t_rest, u: read(&self.u), v: read(&self.v), id };
        (hit, read(&self.place).to_bits())
    }

    /// Replaces it.
    #[inline(always)]
    fn set_lane(&mut self, lane: usize, found: &Found) {
        // SAFETY: as above.
        let write = |v: &mut S::F16, x: f32| unsafe { *(&raw mut *v).cast::<f32>().add(lane) = x };
        let hit = &found.best;
        write(&mut self.low, found.before);
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
        // SAFETY: as above.
        let low = unsafe { *(&raw const self.low).cast::<f32>().add(lane) };
        let mut found = Found::nothing(best.t);
        found.take(best, place, low, end);
        found
    }

    /// Takes over what a search one by one has found.
    #[inline(always)]
    pub(super) fn take_over(&mut self, lane: usize, found: &Found, end: &mut f32) {
        *end = found.high;
        self.set_lane(lane, found);
    }
}

/// A ray of a leg, in the world.
#[inline(always)]
pub(super) fn world_ray<S: Simd>(leg: &Leg<S>, lane: usize) -> Ray {
    // SAFETY: as above.
    let read = |v: &S::F16| unsafe { *(&raw const *v).cast::<f32>().add(lane) };
    let vector = |v: &Vec3V<S::F16>| -> Vec3 { vec3(read(&v[0]), read(&v[1]), read(&v[2])) };
    Ray {
        origin: vector(&leg.world.origin),
        t_min: read(&leg.world.t_min),
        direction: vector(&leg.world.direction),
        t_max: read(&leg.world.t_max),
    }
}

/// Core decides about rays that are not clear, and orders hits that lie close together, one by one: a function of its own,
/// since it is rare and large.
struct Decide<'a, 'b, S: Simd, const QUERY: Query> {
    query: &'a Query16<'b, S>,
    step: &'a StepV<S::F16>,
    leg: &'a Leg<'a, S>,
    place: u32,
    lanes: MaskOf<S>,
    clear: MaskOf<S>,
    best: &'a mut Best<S>,
    end: &'a mut S::F16,
}

impl<S: Simd, const QUERY: Query> Kernel for Decide<'_, '_, S, QUERY> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<X: Simd>(self) -> bool {
        let Decide { query, step, leg, place, lanes, clear, best, end } = self;
        let bvh: &Bvh8View = query.bvh;
        let triangle = bvh.blocks[(place >> 2) as usize].get((place & 3) as usize);
        let id = PrimitiveId { instance: leg.instance, primitive: triangle.primitive };
        let map = (leg.instance != 0).then(|| &bvh.instances[leg.instance as usize].object_from_world);
        let (t, error) = (step.t.to_array(), step.error.to_array());
        let (u, v) = (step.u.to_array(), step.v.to_array());
        let (clear, mut left) = (clear.bits(), lanes.bits());
        let mut changed = false;
        while left != 0 {
            let lane = left.trailing_zeros() as usize & 15;
            left &= left - 1;
            let ray = world_ray(leg, lane);
            let (nearest, _) = best.of_lane(lane);
            // What has been cut is met again.
            if QUERY != ANY && nearest.id == id {
                continue;
            }
            let hit = if clear >> lane & 1 == 1 {
                let (t, t_error, u, v) =
                    (t.as_ref()[lane], error.as_ref()[lane], u.as_ref()[lane], v.as_ref()[lane]);
                TriangleHit { meets: true, is_clear: true, t, t_error, t_rest: UNKNOWN_REST, u, v }
            } else {
                intersect_precisely(&triangle, &ray, map)
            };
            if !hit.meets {
                continue;
            }
            // SAFETY: a vector is sixteen floats.
            let end = unsafe { &mut *(&raw mut *end).cast::<f32>().add(lane) };
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
