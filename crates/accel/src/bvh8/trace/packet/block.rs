//! Four triangles against sixteen rays.

use super::{Best, Leg, MaskOf, PartMask, Query16};
use crate::bvh8::TriangleBlock;
use crate::bvh8::trace::lanes::{Determinant, EdgesV, StepRays, StepTriangles, distance as distance_of};
use crate::bvh8::trace::walk::{ANY, Found, Offer, Query};
use crate::bvh8::view::Bvh8View;
use crate::simd::{Float, Kernel, Mask, Simd, Vec3V, cross, dot, each, subtract};
use eosphor_core::intersect::{TriangleHit, UNDERFLOW_SLACK, intersect_precisely};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::{Hit, PrimitiveId, Ray, UNKNOWN_REST};

/// The best hit is no earlier than its `t` less this times what it may be later. The upper bound lies 4 · 2^-24 of `t` beyond
/// it at least, and is rounded by 2^-24 of that; 2^-24 is also the most that a precise `t` was rounded by.
const TO_LOW: f32 = 1.25;

/// What is the same for all rays about the triangles of a block: a triangle a lane, in memory.
struct Shared {
    normal: [[f32; 4]; 3],
    product: [f32; 4],
    lengths: [f32; 4],
    /// What only rays from one point share.
    seen: Seen,
}

/// Triangles as seen from one point.
struct Seen {
    /// With C the first vertex as seen from there: C × e2 and C × e1, turned so that the edge functions are products with
    /// the direction, but for rounding.
    function_u: [[f32; 4]; 3],
    function_v: [[f32; 4]; 3],
    /// Times the rays' [`EDGE_SLACK`] and the lengths, more than both that rounding and core's can change edge functions by.
    both_slacks: [f32; 4],
    /// As in [`StepTriangles`].
    from_origin: [[f32; 4]; 3],
    distance: [f32; 4],
    distance_with_lengths: [f32; 4],
    numerator: [f32; 4],
}

#[inline(always)]
fn load3<S: Simd>(v: &[[f32; 4]; 3]) -> Vec3V<S::F4> {
    each!(k => S::F4::from_array(&v[k]))
}

#[inline(always)]
fn store3<S: Simd>(v: &Vec3V<S::F4>) -> [[f32; 4]; 3] {
    each!(k => v[k].to_array())
}

#[inline(always)]
fn lane3<S: Simd>(v: &[[f32; 4]; 3], lane: usize) -> Vec3V<S::Part> {
    each!(k => S::Part::splat(v[k][lane]))
}

impl Shared {
    /// With the point where all rays start, and their reach.
    #[inline(always)]
    fn new<S: Simd>(block: &TriangleBlock, one_origin: Option<[f32; 4]>) -> Shared {
        let v0 = load3::<S>(&block.v0);
        let (e1, e2) = (load3::<S>(&block.e1), load3::<S>(&block.e2));
        let normal = cross(&e1, &e2);
        let (length1, length2) = (S::F4::from_array(&block.length1), S::F4::from_array(&block.length2));
        let lengths = length1.add(length2);
        let nothing = [0.0; 4];
        let seen = if let Some(origin) = one_origin {
            let from_origin = subtract(&v0, &each!(k => S::F4::splat(origin[k])));
            let distance = distance_of(&from_origin, S::F4::splat(origin[3]));
            let distance_with_lengths = distance.add(lengths.abs());
            Seen {
                function_u: store3::<S>(&cross(&e2, &from_origin)),
                function_v: store3::<S>(&cross(&e1, &from_origin)),
                both_slacks: S::F4::splat(2.0).mul(distance_with_lengths).mul(lengths).to_array(),
                from_origin: store3::<S>(&from_origin),
                distance: distance.to_array(),
                distance_with_lengths: distance_with_lengths.to_array(),
                numerator: dot(&normal, &from_origin).to_array(),
            }
        } else {
            Seen {
                function_u: [nothing; 3],
                function_v: [nothing; 3],
                both_slacks: nothing,
                from_origin: [nothing; 3],
                distance: nothing,
                distance_with_lengths: nothing,
                numerator: nothing,
            }
        };
        Shared {
            normal: store3::<S>(&normal),
            product: length1.mul(length2).to_array(),
            lengths: lengths.to_array(),
            seen,
        }
    }

    /// One of the triangles, as seen from the origin of each ray of a part.
    #[inline(always)]
    fn triangle<S: Simd>(
        &self,
        block: &TriangleBlock,
        lane: usize,
        leg: &Leg<S>,
        part: usize,
        is_one_origin: bool,
    ) -> StepTriangles<S::Part> {
        let lengths = S::Part::splat(self.lengths[lane]);
        let (from_origin, distance, distance_with_lengths, numerator);
        if is_one_origin {
            from_origin = lane3::<S>(&self.seen.from_origin, lane);
            distance = S::Part::splat(self.seen.distance[lane]);
            distance_with_lengths = S::Part::splat(self.seen.distance_with_lengths[lane]);
            numerator = S::Part::splat(self.seen.numerator[lane]);
        } else {
            from_origin =
                subtract(&lane3::<S>(&block.v0, lane), &each!(k => S::part(&leg.own.origin[k], part)));
            distance = distance_of(&from_origin, S::part(&leg.local.reach, part));
            distance_with_lengths = distance.add(lengths.abs());
            numerator = dot(&lane3::<S>(&self.normal, lane), &from_origin);
        }
        StepTriangles {
            e1: lane3::<S>(&block.e1, lane),
            e2: lane3::<S>(&block.e2, lane),
            product: S::Part::splat(self.product[lane]),
            lengths,
            from_origin,
            distance,
            distance_with_lengths,
            numerator,
        }
    }
}

impl Seen {
    /// Rays that may meet one of the triangles, of these.
    #[inline(always)]
    fn look<S: Simd>(
        &self,
        lane: usize,
        rays: &StepRays<S::Part>,
        determinant: &Determinant<S::Part>,
        active: PartMask<S>,
    ) -> PartMask<S> {
        let Determinant { sign, size } = *determinant;
        let u = dot(&lane3::<S>(&self.function_u, lane), &rays.direction).xor(sign);
        let v = dot(&lane3::<S>(&self.function_v, lane), &rays.direction).xor(sign.negate());
        let least = u.min(v).min(size.sub(u).sub(v));
        let slack =
            rays.edge_slack.fma(S::Part::splat(self.both_slacks[lane]), S::Part::splat(UNDERFLOW_SLACK));
        active.without(least.lt(slack.negate()))
    }
}

impl<S: Simd> Best<S> {
    /// Tests up to four triangles by core's first step; whether any ray has a new hit. Rays from one point have a first look,
    /// with edges a little further out.
    #[inline(always)]
    pub(super) unsafe fn test_block<const QUERY: Query>(
        &mut self,
        query: &Query16<S>,
        number: u32,
        leg: &Leg<S>,
        active: MaskOf<S>,
        one_origin: Option<[f32; 4]>,
        end: &mut S::F16,
    ) -> bool {
        // SAFETY: leaves name blocks that the builder made.
        let block = unsafe { query.bvh.blocks.get_unchecked(number as usize) };
        let shared = Shared::new::<S>(block, one_origin);
        // Unused lanes come last.
        let used = block.count::<S>();
        let block = Tested { number, block, shared: &shared, is_one_origin: one_origin.is_some(), used };
        // SAFETY: the caller's.
        unsafe {
            let mut changed = self.test_part::<QUERY, 0>(query, leg, &block, active, end);
            if S::PART == 8 {
                changed |= self.test_part::<QUERY, 1>(query, leg, &block, active, end);
            }
            changed
        }
    }

    #[inline(always)]
    unsafe fn test_part<const QUERY: Query, const PART: usize>(
        &mut self,
        query: &Query16<S>,
        leg: &Leg<S>,
        tested: &Tested,
        active: MaskOf<S>,
        end: &mut S::F16,
    ) -> bool {
        let Tested { number, block, shared, is_one_origin, used } = *tested;
        let active = S::mask_part(active, PART);
        if S::PART < 16 && !active.any() {
            return false;
        }
        let rays = leg.step_rays(PART);
        let mut changed = false;
        let mut lane = 0;
        while lane < used {
            let determinant = Determinant::new(&lane3::<S>(&shared.normal, lane), &rays.direction);
            let mut lanes = active;
            if is_one_origin {
                lanes = shared.seen.look::<S>(lane, &rays, &determinant, active);
            }
            if lanes.any() {
                let triangle = shared.triangle(block, lane, leg, PART, is_one_origin);
                let StepTriangles { from_origin, e1, e2, .. } = &triangle;
                let edges = EdgesV::new(from_origin, e1, e2, &rays.direction, &determinant);
                let slack = triangle.slack(&rays);
                lanes = lanes.without(edges.least.lt(slack.negate()));
                if lanes.any() {
                    let place = number << 2 | lane as u32;
                    let candidates =
                        Candidates { part: PART, triangle, determinant, edges, slack, place, lanes };
                    // SAFETY: the caller's.
                    changed |= unsafe { self.offer::<QUERY>(query, &rays, &candidates, leg, end) };
                }
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
        rays: &StepRays<S::Part>,
        candidates: &Candidates<S>,
        leg: &Leg<S>,
        ends: &mut S::F16,
    ) -> bool {
        let Candidates { part, triangle, determinant, edges, slack, place, lanes } = candidates;
        let (part, place) = (*part, *place);
        let end = S::part(ends, part);
        let planes = triangle.meet_planes(rays, determinant);
        let mut mask = lanes.without(planes.is_beyond(rays.t_min, end));
        if !mask.any() {
            return false;
        }
        let block = &query.bvh.blocks[(place >> 2) as usize];
        let primitive = block.primitive[(place & 3) as usize];
        if let Some(filters) = query.lane_filters {
            mask = filters.apply(part, mask, leg.instance, primitive, determinant.sign);
        }
        let clear = mask.and(planes.is_clear(rays, edges, *slack, determinant.size));
        if QUERY == ANY {
            *S::part_mut(ends, part) = S::Part::splat(f32::NEG_INFINITY).or_else(clear, end);
            let unclear = mask.without(clear);
            let mut changed = clear.any();
            if unclear.any() {
                let nothing = S::Part::splat(0.0);
                let mut own_ends = *ends;
                let decide = Decide::<S, QUERY> {
                    query,
                    leg,
                    place,
                    first: part * S::PART,
                    lanes: unclear.bits(),
                    clear: 0,
                    t: nothing,
                    error: nothing,
                    u: nothing,
                    v: nothing,
                    best: self,
                    ends: &mut own_ends,
                };
                // SAFETY: the caller's.
                changed |= unsafe { S::run(decide) };
                *ends = own_ends;
            }
            return changed;
        }
        let (u, v) = (edges.u.mul(planes.inverse), edges.v.mul(planes.inverse));
        let best_t = S::part(&self.t, part);
        let low = best_t.sub(S::Part::splat(TO_LOW).mul(end.sub(best_t)));
        // NaN where nothing was met so far, without an end.
        let better = clear.without(low.le(planes.high));
        let mut changed = better.any();
        let (place_v, primitive_v) =
            (S::Part::splat(f32::from_bits(place)), S::Part::splat(f32::from_bits(primitive)));
        let instance_v = S::Part::splat(f32::from_bits(leg.instance));
        if changed {
            *S::part_mut(ends, part) = planes.high.or_else(better, end);
            self.take(part, better, [planes.t, u, v, place_v, primitive_v]);
            // The world comes first.
            if leg.instance != 0 {
                let best = S::part_mut(&mut self.instance, part);
                *best = instance_v.or_else(better, *best);
            }
            self.precise &= !(better.bits() << (part * S::PART));
        }
        // What is not beyond the best hit and not before it, or not clear.
        let mut lanes = mask.without(better);
        if lanes.any() {
            // What has been cut is met again.
            let is_primitive = S::part(&self.primitive, part).same_bits(primitive_v);
            let is_instance = S::part(&self.instance, part).same_bits(instance_v);
            lanes = lanes.without(is_primitive.and(is_instance));
        }
        if lanes.any() {
            let (t, error, mut own_ends) = (planes.t, planes.error, *ends);
            let decide = Decide::<S, QUERY> {
                query,
                leg,
                place,
                first: part * S::PART,
                lanes: lanes.bits(),
                clear: clear.bits(),
                t,
                error,
                u,
                v,
                best: self,
                ends: &mut own_ends,
            };
            // SAFETY: the caller's.
            changed |= unsafe { S::run(decide) };
            *ends = own_ends;
        }
        changed
    }

    /// Takes better hits: t, u, v, place and primitive.
    #[inline(always)]
    fn take(&mut self, part: usize, better: PartMask<S>, hits: [S::Part; 5]) {
        let [t, u, v, place, primitive] = hits;
        let best = S::part_mut(&mut self.t, part);
        *best = t.or_else(better, *best);
        let best = S::part_mut(&mut self.u, part);
        *best = u.or_else(better, *best);
        let best = S::part_mut(&mut self.v, part);
        *best = v.or_else(better, *best);
        let best = S::part_mut(&mut self.place, part);
        *best = place.or_else(better, *best);
        let best = S::part_mut(&mut self.primitive, part);
        *best = primitive.or_else(better, *best);
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
        let t = read(&self.t);
        let t_rest = if self.precise >> lane & 1 == 1 { read(&self.t_rest) } else { UNKNOWN_REST };
        let hit = Hit { t, t_rest, u: read(&self.u), v: read(&self.v), id };
        (hit, read(&self.place).to_bits())
    }

    /// Replaces it.
    #[inline(always)]
    fn set_lane(&mut self, lane: usize, found: &Found) {
        // SAFETY: as above.
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
        let mut found = Found::nothing(best.t);
        found.take(best, place, if low.is_nan() { best.t } else { low }, end);
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

/// A block that is tested.
#[derive(Clone, Copy)]
struct Tested<'a> {
    number: u32,
    block: &'a TriangleBlock,
    shared: &'a Shared,
    is_one_origin: bool,
    used: usize,
}

/// Rays of a part that may meet a triangle.
struct Candidates<S: Simd> {
    part: usize,
    triangle: StepTriangles<S::Part>,
    determinant: Determinant<S::Part>,
    edges: EdgesV<S::Part>,
    slack: S::Part,
    /// As [`Found::place`].
    place: u32,
    lanes: PartMask<S>,
}

/// Core decides about rays that are not clear, and orders hits that lie close together, one by one: a function of its own,
/// since it is rare and large. What it needs is copied for it: what it had a reference to would always be written to memory.
struct Decide<'a, 'b, S: Simd, const QUERY: Query> {
    query: &'a Query16<'b, S>,
    leg: &'a Leg<'a, S>,
    place: u32,
    /// Lane of the first ray of the part.
    first: usize,
    /// Bits of lanes of the part.
    lanes: u32,
    clear: u32,
    /// What the first step says of those that are clear.
    t: S::Part,
    error: S::Part,
    u: S::Part,
    v: S::Part,
    best: &'a mut Best<S>,
    /// A copy, so that the walk's own stays in registers.
    ends: &'a mut S::F16,
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
            } else {
                intersect_precisely(&triangle, &ray, map)
            };
            if !hit.meets {
                continue;
            }
            // SAFETY: a vector is sixteen floats.
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
