//! The ray-triangle test of `eosphor_core::intersect`, operation by operation, for lanes of rays and triangles.

use crate::bvh8::TriangleBlock;
use crate::simd::{Float, Kernel, Mask, Simd, Vec3V, along, cross, dot, each, subtract};
use eosphor_core::intersect::{
    EDGE_SLACK, EDGE_TOLERANCE, HIT_TOLERANCE, LARGEST_NUMBER, SHORTEST_DIRECTION, SLAB_SLACK,
    SMALLEST_DIRECTION, STEEP, T_SLACK, USUAL_LENGTH, USUAL_REACH,
};

/// What the slab test needs of a ray a lane: as `Slab`.
#[derive(Clone, Copy)]
pub(super) struct SlabV<F> {
    pub(super) inverse: Vec3V<F>,
    pub(super) near_offset: Vec3V<F>,
    pub(super) far_offset: Vec3V<F>,
}

/// A ray a lane: as `LocalRay`.
#[derive(Clone, Copy)]
pub(super) struct RayV<F> {
    pub(super) origin: Vec3V<F>,
    pub(super) direction: Vec3V<F>,
    pub(super) t_min: F,
    pub(super) slab: SlabV<F>,
    /// [`EDGE_SLACK`] of them.
    pub(super) edge_slack: F,
    pub(super) hit_tolerance_squared: f32,
    pub(super) steep: F,
    /// As in [`T_SLACK`]. Infinite where products may leave the range of normal numbers, which shifts `t` by more than
    /// rounding.
    pub(super) t_slack: F,
}

/// More than underflow can make of products of lengths, the longest direction among them.
pub(super) const UNDERFLOW_SLACK: f32 = 1e-26;

#[inline(always)]
fn within<F: Float>(x: F, [low, high]: [f32; 2]) -> F::Mask {
    F::splat(low).le(x).and(x.le(F::splat(high)))
}

impl<F: Float> SlabV<F> {
    /// From one over the direction, and the largest component of the origin.
    #[inline(always)]
    fn new(origin: &Vec3V<F>, inverse: Vec3V<F>, largest: F) -> SlabV<F> {
        let slack = F::splat(SLAB_SLACK).mul(largest);
        let offset = each!(k => origin[k].mul(inverse[k]).negate());
        let slack = each!(k => inverse[k].abs().mul(slack));
        SlabV {
            inverse,
            near_offset: each!(k => offset[k].sub(slack[k])),
            far_offset: each!(k => offset[k].add(slack[k])),
        }
    }

    /// As `Slab::interval`, of a box a lane.
    #[inline(always)]
    pub(super) fn interval(&self, low: &Vec3V<F>, high: &Vec3V<F>, t_min: F) -> (F, F) {
        let zero = F::splat(0.0);
        let i = &self.inverse;
        let [x0, y0, z0] = each!(k => high[k].or_else(i[k].lt(zero), low[k]).fma(i[k], self.near_offset[k]));
        let [x1, y1, z1] = each!(k => low[k].or_else(i[k].lt(zero), high[k]).fma(i[k], self.far_offset[k]));
        (x0.max(y0).max(z0.max(t_min)), x1.min(y1).min(z1))
    }
}

/// As `v.abs().max_component()`.
#[inline(always)]
fn largest_component<F: Float>(v: &Vec3V<F>) -> F {
    v[0].abs().max(v[1].abs().max(v[2].abs()))
}

impl<F: Float> RayV<F> {
    /// As `LocalRay::new`.
    #[inline(always)]
    pub(super) fn new<S: Simd<F16 = F>>(
        origin: Vec3V<F>,
        direction: Vec3V<F>,
        t_min: F,
        extent: f32,
    ) -> RayV<F> {
        let largest = largest_component(&origin);
        let reach = F::splat(extent).add(largest);
        let (o, d) = (each!(k => origin[k].abs()), each!(k => direction[k].abs()));
        let length = d[0].add(d[1]).add(d[2]);
        // NaN makes it NaN.
        let sum = o[0].add(o[1]).add(o[2]);
        let [low, high] = USUAL_REACH;
        let is_usual = sum.le(F::splat(0.5 * high)).and(within(length, USUAL_LENGTH));
        let is_usual = is_usual.and(F::splat(SMALLEST_DIRECTION).lt(d[0].min(d[1]).min(d[2])));
        let one = F::splat(1.0);
        let ray = RayV {
            origin,
            direction,
            t_min,
            slab: SlabV::new(&origin, each!(k => one.div(direction[k])), largest),
            edge_slack: F::splat(EDGE_SLACK * EDGE_TOLERANCE).mul(reach).mul(length),
            hit_tolerance_squared: (HIT_TOLERANCE * extent) * (HIT_TOLERANCE * extent),
            steep: F::splat(STEEP).mul(length),
            t_slack: F::splat(T_SLACK).mul(reach),
        };
        if (low <= extent) & (extent <= 0.5 * high) & (is_usual.bits() == 0xffff) {
            ray
        } else {
            // SAFETY: the caller's.
            unsafe { S::run(Unusual { ray, reach, length, sum, largest }) }
        }
    }
}

/// Makes up for rays that are not usual: a function of its own, since it is rare.
struct Unusual<F> {
    ray: RayV<F>,
    reach: F,
    length: F,
    sum: F,
    largest: F,
}

impl<F: Float> Kernel for Unusual<F> {
    type Output = RayV<F>;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> RayV<F> {
        let Unusual { ray, reach, length, sum, largest } = self;
        let d = &ray.direction;
        let smallest = F::splat(SMALLEST_DIRECTION);
        let safe = each!(k => d[k].or_else(smallest.lt(d[k].abs()), smallest.xor(d[k].sign())));
        let inverse = each!(k => F::splat(1.0).div(safe[k]));
        let in_range = sum.add(length).le(F::splat(LARGEST_NUMBER));
        let in_range = in_range.and(F::splat(SHORTEST_DIRECTION).le(length));
        let is_usual = within(reach, USUAL_REACH).and(within(length, USUAL_LENGTH));
        RayV {
            t_min: ray.t_min.or_else(in_range, F::splat(f32::NAN)),
            slab: SlabV::new(&ray.origin, inverse, largest),
            t_slack: ray.t_slack.or_else(is_usual, F::splat(f32::INFINITY)),
            ..ray
        }
    }
}

impl TriangleBlock {
    /// How many lanes are used.
    #[inline(always)]
    pub(super) fn count<S: Simd>(&self) -> usize {
        // SAFETY: four numbers of 32 bits are four floats.
        let primitives = unsafe { S::F4::load(self.primitive.as_ptr().cast()) };
        let unused = primitives.same_bits(S::F4::splat(f32::from_bits(u32::MAX)));
        4 - unused.bits().count_ones() as usize
    }
}

/// A triangle a lane: as `PackedTriangle`.
#[derive(Clone, Copy)]
pub(super) struct TriangleV<F> {
    pub(super) v0: Vec3V<F>,
    pub(super) e1: Vec3V<F>,
    pub(super) e2: Vec3V<F>,
    pub(super) normal: Vec3V<F>,
}

/// What the second step says.
pub(super) struct ConfirmedV<F: Float> {
    /// Hits.
    pub(super) counts: F::Mask,
    /// Rays about which `PackedTriangle::test` has to decide.
    pub(super) unsure: F::Mask,
    pub(super) t: F,
    pub(super) u: F,
    pub(super) v: F,
}

impl<F: Float> TriangleV<F> {
    /// As `PackedTriangle::confirm`, for the lanes in `mask`; those in `sure` are clear of the edges. `inverse` is one over the
    /// determinant, `t_near` where the plane is, from the origin.
    #[inline(always)]
    pub(super) fn confirm(
        &self,
        ray: &RayV<F>,
        inverse: F,
        t_near: F,
        mask: F::Mask,
        sure: F::Mask,
    ) -> ConfirmedV<F> {
        let d = &ray.direction;
        let from_near = subtract(&self.v0, &along(&ray.origin, d, t_near));
        let t_rest = dot(&self.normal, &from_near).mul(inverse);
        let r = cross(&from_near, d);
        let (u, v) = (dot(&r, &self.e2).mul(inverse), dot(&r, &self.e1).negate().mul(inverse));
        let apart = along(&along(&along(&from_near, &self.e1, u), &self.e2, v), d, t_rest.negate());
        let (zero, one) = (F::splat(0.0), F::splat(1.0));
        let inside = zero.le(u).and(zero.le(v)).and(u.add(v).le(one));
        let meets = inside.and(dot(&apart, &apart).le(F::splat(ray.hit_tolerance_squared)));
        let sure = mask.and(meets).and(sure);
        let t = t_near.add(t_rest);
        let counts = sure.and(ray.t_min.lt(t)).and(t.lt(F::splat(f32::INFINITY)));
        ConfirmedV { counts, unsure: mask.without(sure), t, u, v }
    }
}
