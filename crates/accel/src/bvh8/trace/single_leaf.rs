//! Leaves of triangles and spheres, for one ray at a time.

use super::found::{ANY, CLOSEST, Found, NEXT, NO_TRIANGLE, Offer, Query};
use super::lanes::{Determinant, EdgesV, StepPlanes, StepRays, distance};
use super::single::VisitLeaf;
use super::single_ray::SingleRay;
use crate::bvh8::node::held;
use crate::bvh8::view::Bvh8View;
use crate::bvh8::{Child, INSTANCE, LEAF, Node8, PLACE, SPHERE, TriangleBlock};
use crate::simd::{Float, Kernel, Mask, Simd, Vec3V, cross, dot, each, subtract};
use eosphor_core::hierarchy::{Work, widening};
use eosphor_core::intersect::{
    T_UNDERFLOW, TriangleHit, UNDERFLOW_SLACK, intersect_precisely, intersect_sphere, may_meet_sphere,
};
use eosphor_core::ray::{Hit, PrimitiveId, RayFilter, UNKNOWN_REST};

/// Leaves of triangles and spheres.
///
/// Most hits are clear, and by the bounds of their `t` nothing that was met before is near. Such a hit is taken as it is.
#[derive(Clone, Copy)]
pub(super) struct PrimitiveLeaves<'a> {
    pub(super) bvh: &'a Bvh8View<'a>,
    pub(super) ray: &'a SingleRay<'a>,
    pub(super) instance: u32,
    pub(super) filter: &'a RayFilter,
}

/// The same, with who is told of them.
pub(super) struct ToldLeaves<'a, W> {
    pub(super) leaves: PrimitiveLeaves<'a>,
    pub(super) work: W,
}

/// Says that a node or block, its first cache lines, will be looked at soon. `nodes` is where those of the tree begin.
#[inline(always)]
pub(super) fn prefetch<S: Simd, const LINES: usize>(bvh: &Bvh8View, nodes: *const u8, child: Child) {
    let place = (child & PLACE) as usize;
    let node = nodes.wrapping_add(place * size_of::<Node8>());
    let block = bvh.blocks.as_ptr().wrapping_add(place).cast::<u8>();
    let at = if child & LEAF == 0 { node } else { block };
    let mut line = 0;
    while line < LINES {
        S::prefetch(at.wrapping_add(64 * line));
        line += 1;
    }
}

impl<S: Simd, W: Work> VisitLeaf<S> for ToldLeaves<'_, W> {
    #[inline(always)]
    fn prefetch(&self, nodes: *const u8, child: Child) {
        prefetch::<S, 3>(self.leaves.bvh, nodes, child);
    }

    #[inline(always)]
    unsafe fn visit<const QUERY: Query>(&mut self, leaf: Child, found: &mut Found) -> bool {
        if W::COUNTS {
            self.work.primitives(held(self.leaves.bvh.blocks, leaf));
        }
        // SAFETY: instruction set and closed view: promised to this function.
        unsafe { self.leaves.visit::<S, QUERY>(leaf, found) }
    }
}

impl PrimitiveLeaves<'_> {
    /// # Safety
    /// As for [`VisitLeaf::visit`].
    #[inline(always)]
    pub(super) unsafe fn visit<S: Simd, const QUERY: Query>(
        &mut self,
        leaf: Child,
        found: &mut Found,
    ) -> bool {
        if leaf & SPHERE != 0 {
            let (leaves, number) = (*self, (leaf & PLACE) as usize);
            // SAFETY: instruction set: promised to this function.
            return unsafe { S::run(SphereTest::<QUERY> { leaves, number, found }) };
        }
        debug_assert!(leaf & INSTANCE == 0);
        self.test_block::<S, QUERY>(leaf & PLACE, found)
    }

    /// The first step for all triangles of the block. Few are left, and of these most are hit clearly.
    #[inline(always)]
    fn test_block<S: Simd, const QUERY: Query>(&mut self, number: u32, found: &mut Found) -> bool {
        // SAFETY: closed view: leaves name blocks.
        let block = unsafe { self.bvh.blocks.get_unchecked(number as usize) };
        let ray = self.ray;
        let v0 = load3::<S>(&block.v0);
        let e1 = subtract(&load3::<S>(&block.v1), &v0);
        let e2 = subtract(&load3::<S>(&block.v2), &v0);
        let direction = each!(k => S::F4::splat(ray.direction[k]));
        let from_origin = subtract(&v0, &each!(k => S::F4::splat(ray.origin[k])));
        let normal = cross(&e1, &e2);
        let determinant = Determinant::new(&normal, &direction);
        let edges = EdgesV::new(&from_origin, &e1, &e2, &direction, &determinant);
        let lengths = S::F4::from_array(&block.lengths);
        let outside = S::F4::splat(ray.outside).fma(lengths, S::F4::splat(-UNDERFLOW_SLACK));
        // Most leaves end here.
        let near = !edges.least.lt(outside).bits() & 0xf;
        if near == 0 {
            return false;
        }
        let backs = determinant.sign.same_bits(S::F4::splat(0.0)).bits();
        if QUERY == ANY {
            let numerator = dot(&normal, &from_origin);
            let (least, product) = (edges.least, S::F4::from_array(&block.product));
            let plain =
                Plain { from_origin, determinant, numerator, least, outside, product, lengths, backs };
            return self.meet::<S, QUERY>(number, near, &plain, found);
        }
        let rays = StepRays {
            direction,
            t_min: S::F4::splat(ray.origin[3]),
            t_max: S::F4::splat(ray.t_max),
            length: S::F4::splat(ray.direction[3]),
            edge_slack: S::F4::splat(ray.edge_slack),
            scale: S::F4::splat(ray.scale),
        };
        let distance = distance(&from_origin, S::F4::splat(ray.reach), lengths);
        let plane = StepPlanes {
            product: S::F4::from_array(&block.product),
            lengths,
            distance,
            distance_with_lengths: distance.add(lengths.abs()),
            numerator: dot(&normal, &from_origin),
        };
        let slack = plane.slack(rays.edge_slack);
        let planes = plane.meet(rays.length, &determinant, slack);
        let beyond = planes.is_beyond(rays.t_min, S::F4::splat(found.end));
        let lanes = !edges.least.lt(slack.negate()).or(beyond).bits() & 0xf;
        if lanes == 0 {
            return false;
        }
        if QUERY == CLOSEST && ray.from.is_some() {
            let between = rays.t_min.lt(planes.low).and(planes.high.le(rays.t_max));
            let certain = slack.le(edges.least).and(planes.is_steep).and(between).bits();
            let bounds = [planes.low.to_array(), planes.high.to_array()];
            let lane = lanes.trailing_zeros() as usize & 3;
            let (low, high) = (bounds[0][lane], bounds[1][lane]);
            let low = low - widening(low, ray.lost);
            let high = high + widening(high, ray.lost);
            let is_alone = lanes & (lanes - 1) == 0;
            if is_alone & (certain & lanes != 0) & (high < found.before) {
                let id = PrimitiveId { instance: self.instance, primitive: block.primitive[lane] };
                if !(self.filter.skips(id) | (self.filter.cull_back_faces & (backs >> lane & 1 == 1))) {
                    found.take_open(id, number << 2 | lane as u32, low, high);
                }
                return false;
            }
            // SAFETY: instruction set: this runs below a kernel's.
            return unsafe {
                S::run(CompareMoved { leaves: *self, number, lanes, certain, bounds, backs, found })
            };
        }
        let is_clear = planes.is_clear(&rays, &edges, slack, determinant.size);
        let lane = lanes.trailing_zeros() as usize & 3;
        let nearer = is_clear.and(planes.high.lt(S::F4::splat(found.before)));
        let is_alone = lanes & (lanes - 1) == 0;
        let taken = lanes & nearer.bits() != 0;
        if QUERY != NEXT && is_alone & taken & ray.from.is_none() {
            let id = PrimitiveId { instance: self.instance, primitive: block.primitive[lane] };
            if self.filter.skips(id) | (self.filter.cull_back_faces & (backs >> lane & 1 == 1)) {
                return false;
            }
            let (u, v) =
                (edges.u.mul(planes.inverse).to_array()[lane], edges.v.mul(planes.inverse).to_array()[lane]);
            let t = planes.t.to_array()[lane];
            let (low, high) = (planes.low.to_array()[lane], planes.high.to_array()[lane]);
            found.take(Hit { t, t_rest: UNKNOWN_REST, u, v, id }, number << 2 | lane as u32, low, high);
            return false;
        }
        if QUERY == CLOSEST && is_alone {
            // What has been cut is met again.
            let id = PrimitiveId { instance: self.instance, primitive: block.primitive[lane] };
            if found.best.id == id {
                return false;
            }
        }
        let clear = if ray.from.is_some() { 0 } else { is_clear.bits() };
        let hits = Clear {
            bits: clear,
            t: planes.t.to_array(),
            error: planes.error.to_array(),
            u: edges.u.mul(planes.inverse).to_array(),
            v: edges.v.mul(planes.inverse).to_array(),
        };
        // SAFETY: instruction set: this runs below a kernel's.
        unsafe { S::run(Compare::<QUERY> { leaves: *self, number, lanes, hits: &hits, backs, found }) }
    }

    /// Whether there is any hit. Most are certain by bounds that hold for all triangles, or by core's, which follow from how far
    /// the ray starts from each: double precision would say the same, since its errors are nothing beside them.
    #[inline(always)]
    fn meet<S: Simd, const QUERY: Query>(
        &mut self,
        number: u32,
        near: u32,
        plain: &Plain<S::F4>,
        found: &mut Found,
    ) -> bool {
        let Plain { from_origin, determinant, numerator, least, outside, product, lengths, backs } = *plain;
        let ray = self.ray;
        let inverse = S::F4::splat(1.0).div(determinant.size);
        let t = numerator.xor(determinant.sign).mul(inverse);
        // (By a slack of the whole ray: what follows waits for `t` alone.)
        let error = S::F4::splat(ray.t_slack).fma(product, S::F4::splat(T_UNDERFLOW)).mul(inverse);
        let (low, high, t_min) = (t.sub(error), t.add(error), S::F4::splat(ray.origin[3]));
        // Within the edges for certain: the determinant is three times what edge functions may be wrong by.
        let inside = outside.negate().le(least);
        let beyond = inside.and(high.lt(t_min).or(S::F4::splat(found.end).lt(low)));
        let mut lanes = near & !beyond.bits();
        if lanes == 0 {
            return false;
        }
        let t_max = S::F4::splat(ray.t_max);
        let mut meets = inside.and(t_min.lt(low)).and(high.le(t_max)).bits() & lanes;
        if meets == 0 {
            let distance = distance(&from_origin, S::F4::splat(ray.reach), lengths);
            let distance_with_lengths = distance.add(lengths.abs());
            let plane = StepPlanes { product, lengths, distance, distance_with_lengths, numerator };
            let slack = plane.slack(S::F4::splat(ray.edge_slack));
            let planes = plane.meet(S::F4::splat(ray.direction[3]), &determinant, slack);
            let beyond = planes.is_beyond(t_min, S::F4::splat(found.end));
            lanes &= !least.lt(slack.negate()).or(beyond).bits();
            if lanes == 0 {
                return false;
            }
            let between = t_min.lt(planes.low).and(planes.high.le(t_max));
            meets = slack.le(least).and(planes.is_steep).and(between).bits() & lanes;
        }
        let lane = lanes.trailing_zeros() as usize & 3;
        if meets >> lane & 1 == 1 {
            // SAFETY: closed view: leaves name blocks.
            let block = unsafe { self.bvh.blocks.get_unchecked(number as usize) };
            let id = PrimitiveId { instance: self.instance, primitive: block.primitive[lane] };
            if !(self.filter.skips(id) | (self.filter.cull_back_faces & (backs >> lane & 1 == 1))) {
                found.any = true;
                return true;
            }
            if lanes & (lanes - 1) == 0 {
                return false;
            }
        }
        // SAFETY: instruction set: this runs below a kernel's.
        unsafe { S::run(Compare::<QUERY> { leaves: *self, number, lanes, hits: &Clear::NONE, backs, found }) }
    }

    #[inline(always)]
    fn test_sphere<const QUERY: Query>(&self, number: usize, found: &mut Found) -> bool {
        let (bvh, ray) = (self.bvh, self.ray);
        let sphere = &bvh.spheres[number];
        if ray.origin[3].is_nan() || !may_meet_sphere(&ray.local(), sphere) {
            return false;
        }
        let id = PrimitiveId { instance: self.instance, primitive: bvh.sphere_primitives[number] };
        for crossing in intersect_sphere(sphere, &ray.world, ray.map) {
            // Roots that are not hits are NaN.
            if crossing.t.is_nan() {
                continue;
            }
            let hit = TriangleHit::of_sphere(&crossing);
            if found.offer::<QUERY>(&Offer { bvh, ray: &ray.world, hit, id, place: NO_TRIANGLE }) {
                return true;
            }
            // The second one is farther.
            if QUERY == CLOSEST {
                break;
            }
        }
        false
    }
}

/// A sphere: a function of its own, since it is rare and large.
struct SphereTest<'a, const QUERY: Query> {
    leaves: PrimitiveLeaves<'a>,
    number: usize,
    found: &'a mut Found,
}

impl<const QUERY: Query> Kernel for SphereTest<'_, QUERY> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> bool {
        self.leaves.test_sphere::<QUERY>(self.number, self.found)
    }
}

/// What tells about a block of triangles whether a ray meets one, a triangle a lane.
struct Plain<F> {
    /// First vertex minus the origin.
    from_origin: Vec3V<F>,
    determinant: Determinant<F>,
    numerator: F,
    /// The least edge function, and what that is below only where the ray passes by.
    least: F,
    outside: F,
    /// Lengths of the two edges, multiplied.
    product: F,
    /// And added up.
    lengths: F,
    /// Bits of those that are met from behind.
    backs: u32,
}

/// What the first step says of the triangles of a block, and for which of them that is enough.
pub(super) struct Clear {
    pub(super) bits: u32,
    pub(super) t: [f32; 4],
    pub(super) error: [f32; 4],
    pub(super) u: [f32; 4],
    pub(super) v: [f32; 4],
}

impl Clear {
    /// Nothing.
    pub(super) const NONE: Clear = Clear { bits: 0, t: [0.0; 4], error: [0.0; 4], u: [0.0; 4], v: [0.0; 4] };
}

/// Candidates of a closest hit for a ray that is looked at from elsewhere. Most are certain from there, and which of them are
/// nearer than others: a function of its own, since it is rare.
struct CompareMoved<'a> {
    leaves: PrimitiveLeaves<'a>,
    number: u32,
    lanes: u32,
    /// Those that are hits for certain,
    certain: u32,
    /// and no earlier and no later than this.
    bounds: [[f32; 4]; 2],
    /// Those that are met from behind.
    backs: u32,
    found: &'a mut Found,
}

impl Kernel for CompareMoved<'_> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> bool {
        let CompareMoved { leaves, number, mut lanes, certain, bounds: [low, high], backs, found } = self;
        let (bvh, ray) = (leaves.bvh, leaves.ray);
        if leaves.filter.cull_back_faces {
            lanes &= !backs;
        }
        let block = &bvh.blocks[number as usize];
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 3;
            lanes &= lanes - 1;
            let id = PrimitiveId { instance: leaves.instance, primitive: block.primitive[lane] };
            // What has been cut is met again.
            if leaves.filter.skips(id) | (found.best.id == id) {
                continue;
            }
            let place = number << 2 | lane as u32;
            let low = low[lane] - widening(low[lane], ray.lost);
            let high = high[lane] + widening(high[lane], ray.lost);
            if (certain >> lane & 1 == 1) & (high < found.before) {
                found.take_open(id, place, low, high);
                continue;
            }
            let hit = moved_test(block, lane, bvh, ray, leaves.instance);
            if hit.meets {
                found.offer::<CLOSEST>(&Offer { bvh, ray: &ray.world, hit, id, place });
            }
        }
        false
    }
}

/// Candidates that are not clear, or close to others: a function of its own, since it is rare and large.
pub(super) struct Compare<'a, const QUERY: Query> {
    pub(super) leaves: PrimitiveLeaves<'a>,
    pub(super) number: u32,
    pub(super) lanes: u32,
    pub(super) hits: &'a Clear,
    /// Those that are met from behind.
    pub(super) backs: u32,
    pub(super) found: &'a mut Found,
}

impl<const QUERY: Query> Kernel for Compare<'_, QUERY> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> bool {
        let Compare { leaves, number, mut lanes, hits, backs, found } = self;
        let (bvh, ray) = (leaves.bvh, leaves.ray);
        if leaves.filter.cull_back_faces {
            lanes &= !backs;
        }
        let block = &bvh.blocks[number as usize];
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 3;
            lanes &= lanes - 1;
            let id = PrimitiveId { instance: leaves.instance, primitive: block.primitive[lane] };
            // What has been cut is met again.
            let again = QUERY != ANY && found.best.id == id;
            if leaves.filter.skips(id) | again {
                continue;
            }
            let hit = if hits.bits >> lane & 1 == 1 {
                let (t, t_error, u, v) = (hits.t[lane], hits.error[lane], hits.u[lane], hits.v[lane]);
                TriangleHit { meets: true, is_clear: true, t, t_error, t_rest: UNKNOWN_REST, u, v }
            } else if ray.from.is_some() {
                moved_test(block, lane, bvh, ray, leaves.instance)
            } else {
                precise_test(block, lane, ray)
            };
            let place = number << 2 | lane as u32;
            if hit.meets && found.offer::<QUERY>(&Offer { bvh, ray: &ray.world, hit, id, place }) {
                return true;
            }
        }
        false
    }
}

#[inline(always)]
fn precise_test(block: &TriangleBlock, lane: usize, ray: &SingleRay) -> TriangleHit {
    if ray.origin[3].is_nan() {
        return TriangleHit::NOWHERE;
    }
    intersect_precisely(&block.get(lane), &ray.world, ray.map)
}

/// The whole test, for rays that are looked at from elsewhere.
#[inline(always)]
pub(super) fn moved_test(
    block: &TriangleBlock,
    lane: usize,
    bvh: &Bvh8View,
    ray: &SingleRay,
    instance: u32,
) -> TriangleHit {
    let geometry = bvh.instances[instance as usize].geometry;
    let extent = bvh.geometries[geometry as usize].extent;
    eosphor_core::intersect::intersect_triangle(&block.get(lane), &ray.world, ray.map, extent)
}

#[inline(always)]
pub(super) fn load3<S: Simd>(v: &[[f32; 4]; 3]) -> Vec3V<S::F4> {
    each!(k => S::F4::from_array(&v[k]))
}
