//! The first step of the triangle test of `eosphor_core::intersect`, operation by operation, for lanes of rays.

use crate::bvh8::TriangleBlock;
use crate::simd::{Float, Kernel, Mask, Simd, Vec3V, cross, dot, each, subtract};
use eosphor_core::intersect::{
    EDGE_SLACK, EXTENT_SLACK, LARGEST_NUMBER, ORIGIN_SLACK, SHORT, SHORTEST_DIRECTION, SMALLEST_DETERMINANT,
    SMALLEST_DIRECTION, STEEP, T_ERROR, T_SLACK, T_UNDERFLOW, UNDERFLOW_SLACK, USUAL_LENGTH, USUAL_REACH,
    UV_ERROR, WORLD_FROM_OBJECT_ROUNDING,
};
use eosphor_core::math::Affine;

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
    pub(super) t_max: F,
    pub(super) slab: SlabV<F>,
    pub(super) length: F,
    /// [`EDGE_SLACK`] of it.
    pub(super) edge_slack: F,
    pub(super) reach: F,
    pub(super) scale: F,
    /// Of the origin.
    pub(super) largest: F,
}

impl<F: Float> SlabV<F> {
    /// From one over the direction.
    #[inline(always)]
    fn new(origin: &Vec3V<F>, inverse: Vec3V<F>, everywhere: F) -> SlabV<F> {
        let near = F::splat(ORIGIN_SLACK);
        let offset = each!(k => origin[k].mul(inverse[k]).negate());
        let slack = each!(k => inverse[k].abs().mul(origin[k].abs().mul(near).add(everywhere)));
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

#[inline(always)]
fn sum<F: Float>(v: &Vec3V<F>) -> F {
    v[0].abs().add(v[1].abs()).add(v[2].abs())
}

/// The ends of rays.
#[derive(Clone, Copy)]
pub(super) struct Ends<F> {
    pub(super) t_min: F,
    pub(super) t_max: F,
}

impl<F: Float> RayV<F> {
    /// As `LocalRay::new`.
    #[inline(always)]
    pub(super) fn new<S: Simd<F16 = F>>(
        origin: Vec3V<F>,
        direction: Vec3V<F>,
        ends: Ends<F>,
        extent: f32,
    ) -> RayV<F> {
        let (length, scale) = (sum(&direction), sum(&origin));
        RayV::in_space::<S>(origin, direction, ends, extent, length, F::splat(0.0), scale)
    }

    /// As `LocalRay::mapped`, of rays in the world.
    #[inline(always)]
    pub(super) fn mapped<S: Simd<F16 = F>>(
        o: &Vec3V<F>,
        d: &Vec3V<F>,
        map: &Affine,
        ends: Ends<F>,
        extent: f32,
    ) -> RayV<F> {
        let (world_o, world_d) = (each!(k => o[k].to_array()), each!(k => d[k].to_array()));
        let (mut own_o, mut own_d) = (world_o, world_d);
        let mut lane = 0;
        while lane < 16 {
            let at = |v: &[F::Array; 3], k: usize| f64::from(v[k].as_ref()[lane]);
            let point = map.point64([at(&world_o, 0), at(&world_o, 1), at(&world_o, 2)]);
            let way = map.direction64([at(&world_d, 0), at(&world_d, 1), at(&world_d, 2)]);
            let mut k = 0;
            while k < 3 {
                own_o[k].as_mut()[lane] = point[k] as f32;
                own_d[k].as_mut()[lane] = way[k] as f32;
                k += 1;
            }
            lane += 1;
        }
        let (origin, direction) =
            (each!(k => F::from_array(&own_o[k])), each!(k => F::from_array(&own_d[k])));
        let length = F::splat(WORLD_FROM_OBJECT_ROUNDING).mul(sum(&direction));
        let scale = sum(o).mul(length.div(sum(d)));
        RayV::in_space::<S>(origin, direction, ends, extent, length, sum(&origin), scale)
    }

    #[inline(always)]
    fn in_space<S: Simd<F16 = F>>(
        origin: Vec3V<F>,
        direction: Vec3V<F>,
        ends: Ends<F>,
        extent: f32,
        length: F,
        reach: F,
        scale: F,
    ) -> RayV<F> {
        let largest = largest_component(&origin);
        let d = each!(k => direction[k].abs());
        let own = sum(&direction);
        let [shortest, longest] = USUAL_LENGTH;
        let is_usual = largest.add(reach).le(F::splat(USUAL_REACH));
        let is_usual = is_usual.and(F::splat(shortest).le(own)).and(length.le(F::splat(longest)));
        let is_plain = is_usual.and(F::splat(SMALLEST_DIRECTION).lt(d[0].min(d[1]).min(d[2])));
        let one = F::splat(1.0);
        let everywhere = F::splat(EXTENT_SLACK).mul(F::splat(extent).add(largest));
        let ray = RayV {
            origin,
            direction,
            t_min: ends.t_min,
            t_max: ends.t_max,
            slab: SlabV::new(&origin, each!(k => one.div(direction[k])), everywhere),
            length,
            edge_slack: F::splat(EDGE_SLACK).mul(length),
            reach,
            scale,
            largest,
        };
        if is_plain.bits() == 0xffff {
            ray
        } else {
            // SAFETY: the caller's.
            unsafe { S::run(Unusual { ray, is_usual, everywhere }) }
        }
    }
}

/// Makes up for rays that are not usual: a function of its own, since it is rare.
struct Unusual<F: Float> {
    ray: RayV<F>,
    is_usual: F::Mask,
    everywhere: F,
}

impl<F: Float> Kernel for Unusual<F> {
    type Output = RayV<F>;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> RayV<F> {
        let Unusual { ray, is_usual, everywhere } = self;
        let d = &ray.direction;
        let smallest = F::splat(SMALLEST_DIRECTION);
        let safe = each!(k => d[k].or_else(smallest.lt(d[k].abs()), smallest.xor(d[k].sign())));
        let inverse = each!(k => F::splat(1.0).div(safe[k]));
        let infinity = F::splat(f32::INFINITY);
        let largest = F::splat(LARGEST_NUMBER);
        let everywhere = everywhere.or_else(F::splat(SHORT).le(largest_component(d)), largest);
        let own = sum(d);
        let in_range = sum(&ray.origin).add(own).le(F::splat(LARGEST_NUMBER));
        let in_range = in_range.and(F::splat(SHORTEST_DIRECTION).le(own));
        let length = ray.length.or_else(is_usual, infinity);
        RayV {
            t_min: ray.t_min.or_else(in_range, F::splat(f32::NAN)),
            slab: SlabV::new(&ray.origin, inverse, everywhere),
            length,
            edge_slack: F::splat(EDGE_SLACK).mul(length),
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

/// What the first step needs of rays, a ray a lane.
#[derive(Clone, Copy)]
pub(super) struct StepRays<F> {
    pub(super) direction: Vec3V<F>,
    pub(super) t_min: F,
    pub(super) t_max: F,
    pub(super) length: F,
    pub(super) edge_slack: F,
    pub(super) scale: F,
}

/// A triangle a lane, as seen from the rays' origins.
#[derive(Clone, Copy)]
pub(super) struct StepTriangles<F> {
    pub(super) e1: Vec3V<F>,
    pub(super) e2: Vec3V<F>,
    pub(super) normal: Vec3V<F>,
    pub(super) length1: F,
    pub(super) length2: F,
    /// First vertex minus the origin.
    pub(super) from_origin: Vec3V<F>,
    /// At least its length, with the ray's reach.
    pub(super) distance: F,
}

/// As `FirstStep` and `Meeting`.
#[derive(Clone, Copy)]
pub(super) struct StepV<F: Float> {
    pub(super) t: F,
    pub(super) error: F,
    pub(super) low: F,
    pub(super) high: F,
    pub(super) u: F,
    pub(super) v: F,
    /// The sign of the determinant: it is set where a ray meets the front.
    pub(super) sign: F,
    /// The first step says that they do not meet.
    pub(super) misses: F::Mask,
    pub(super) is_steep: F::Mask,
    pub(super) is_clear: F::Mask,
}

/// As `from_origin.abs()`, added up with the rays' reach.
#[inline(always)]
pub(super) fn distance<F: Float>(from_origin: &Vec3V<F>, reach: F) -> F {
    let c = each!(k => from_origin[k].abs());
    c[0].add(c[1]).add(c[2].add(reach))
}

/// As `PackedTriangle::first_step` and `FirstStep::meeting`.
#[inline(always)]
pub(super) fn first_step<F: Float>(ray: &StepRays<F>, triangle: &StepTriangles<F>) -> StepV<F> {
    let StepTriangles { e1, e2, normal, length1, length2, from_origin, distance } = triangle;
    let zero = F::splat(0.0);
    let r = cross(from_origin, &ray.direction);
    let determinant = dot(normal, &ray.direction);
    let sign = determinant.sign();
    let size = determinant.xor(sign);
    let u = dot(&r, e2).xor(sign);
    let v = dot(&r, e1).xor(sign.xor(zero.negate()));
    let least = u.min(v).min(size.sub(u).sub(v));
    let lengths = length1.add(*length2);
    let slack = ray.edge_slack.mul(distance.add(lengths.abs()));
    let slack = slack.fma(lengths, F::splat(UNDERFLOW_SLACK));
    let inverse = F::splat(1.0).div(size);
    let t = dot(normal, from_origin).xor(sign).mul(inverse);
    let product = length1.mul(*length2);
    let path = t.abs();
    let distances = path.fma(ray.length, *distance);
    let underflow = F::splat(T_UNDERFLOW).mul(inverse);
    let error = F::splat(T_SLACK).mul(product.mul(inverse)).fma(distances, underflow);
    let is_steep = F::splat(STEEP).mul(ray.length).fma(product, F::splat(SMALLEST_DETERMINANT)).le(size);
    let bound = F::splat(T_ERROR).mul(path.fma(ray.length, ray.scale));
    let is_exact = error.mul(ray.length).le(bound).and(slack.le(F::splat(UV_ERROR).mul(size)));
    let (low, high) = (t.sub(error), t.add(error));
    let is_between = ray.t_min.lt(low).and(high.le(ray.t_max));
    StepV {
        t,
        error,
        low,
        high,
        u: u.mul(inverse),
        v: v.mul(inverse),
        sign,
        misses: least.lt(slack.negate()),
        is_steep,
        is_clear: slack.le(least).and(is_steep).and(is_exact).and(is_between),
    }
}

impl<F: Float> RayV<F> {
    /// For the first step.
    #[inline(always)]
    pub(super) fn step_rays(&self) -> StepRays<F> {
        let RayV { direction, t_min, t_max, length, edge_slack, scale, .. } = *self;
        StepRays { direction, t_min, t_max, length, edge_slack, scale }
    }

    /// A triangle, as seen from the origins.
    #[inline(always)]
    pub(super) fn vertex_seen(&self, v0: &Vec3V<F>) -> (Vec3V<F>, F) {
        let from_origin = subtract(v0, &self.origin);
        (from_origin, distance(&from_origin, self.reach))
    }
}
