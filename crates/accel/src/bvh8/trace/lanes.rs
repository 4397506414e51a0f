//! The first step of the triangle test of `eosphor_core::intersect`, operation by operation, for lanes of rays.

use crate::bvh8::TriangleBlock;
use crate::simd::{Float, Kernel, Mask, Simd, Vec3V, cross, dot, each, subtract};
use eosphor_core::intersect::{
    EDGE_REACH, EDGE_SLACK, EXTENT_SLACK, LARGEST_NUMBER, ORIGIN_SLACK, SHORT, SHORTEST_DIRECTION,
    SMALLEST_DIRECTION, T_ERROR, T_SLACK, T_UNDERFLOW, UNDERFLOW_SLACK, USUAL_LENGTH, USUAL_REACH, UV_ERROR,
    WORLD_FROM_OBJECT_ROUNDING,
};
use eosphor_core::math::Affine;

/// What the slab test needs of a ray a lane: as `Slab`.
#[derive(Clone, Copy)]
pub(super) struct SlabV<F> {
    pub(super) inverse: Vec3V<F>,
    pub(super) near_offset: Vec3V<F>,
    pub(super) far_offset: Vec3V<F>,
}

/// Rays of some space, a ray a lane.
#[derive(Clone, Copy)]
pub(super) struct RaysV<F> {
    pub(super) origin: Vec3V<F>,
    pub(super) direction: Vec3V<F>,
    pub(super) t_min: F,
    pub(super) t_max: F,
}

/// What the tests need beside them: as `LocalRay`.
#[derive(Clone, Copy)]
pub(super) struct LocalV<F> {
    /// NaN where a ray has numbers out of range.
    pub(super) t_min: F,
    pub(super) slab: SlabV<F>,
    pub(super) length: F,
    /// [`EDGE_SLACK`] of it.
    pub(super) edge_slack: F,
    pub(super) reach: F,
    pub(super) scale: F,
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

impl<F: Float> RaysV<F> {
    /// The largest coordinates of their origins.
    #[inline(always)]
    pub(super) fn largest(&self) -> F {
        largest_component(&self.origin)
    }

    /// Mapped in double precision: as in `LocalRay::mapped`.
    #[inline(always)]
    pub(super) fn mapped(&self, map: &Affine) -> RaysV<F> {
        let world_o = each!(k => self.origin[k].to_array());
        let world_d = each!(k => self.direction[k].to_array());
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
        RaysV {
            origin: each!(k => F::from_array(&own_o[k])),
            direction: each!(k => F::from_array(&own_d[k])),
            ..*self
        }
    }
}

impl<F: Float> LocalV<F> {
    /// As `LocalRay::new`.
    #[inline(always)]
    pub(super) fn of_world(rays: &RaysV<F>, extent: f32) -> (LocalV<F>, Usual<F>) {
        let (length, scale) = (sum(&rays.direction), sum(&rays.origin));
        let (own, usual) = LocalV::in_space(rays, extent, length, F::splat(0.0), scale);
        (LocalV { reach: F::splat(EDGE_REACH).mul(scale), ..own }, usual)
    }

    /// As `LocalRay::mapped`, of rays of the world that are these in an object's space.
    #[inline(always)]
    pub(super) fn of_object(world: &RaysV<F>, own: &RaysV<F>, extent: f32) -> (LocalV<F>, Usual<F>) {
        let length = F::splat(WORLD_FROM_OBJECT_ROUNDING).mul(sum(&own.direction));
        let scale = sum(&world.origin).mul(length.div(sum(&world.direction)));
        LocalV::in_space(own, extent, length, sum(&own.origin), scale)
    }

    #[inline(always)]
    fn in_space(rays: &RaysV<F>, extent: f32, length: F, reach: F, scale: F) -> (LocalV<F>, Usual<F>) {
        let largest = rays.largest();
        let d = each!(k => rays.direction[k].abs());
        let own = sum(&rays.direction);
        let [shortest, longest] = USUAL_LENGTH;
        let is_usual = largest.add(reach).le(F::splat(USUAL_REACH));
        let is_usual = is_usual.and(F::splat(shortest).le(own)).and(length.le(F::splat(longest)));
        let is_plain = is_usual.and(F::splat(SMALLEST_DIRECTION).lt(d[0].min(d[1]).min(d[2])));
        let one = F::splat(1.0);
        let everywhere = F::splat(EXTENT_SLACK).mul(F::splat(extent).add(largest));
        let local = LocalV {
            t_min: rays.t_min,
            slab: SlabV::new(&rays.origin, each!(k => one.div(rays.direction[k])), everywhere),
            length,
            edge_slack: F::splat(EDGE_SLACK).mul(length),
            reach,
            scale,
        };
        (local, Usual { is_usual, is_plain, everywhere })
    }
}

/// Which rays are usual.
pub(super) struct Usual<F: Float> {
    is_usual: F::Mask,
    is_plain: F::Mask,
    everywhere: F,
}

impl<F: Float> Usual<F> {
    /// Makes up for the others.
    #[inline(always)]
    pub(super) fn mend_others<S: Simd<F16 = F>>(&self, rays: &RaysV<F>, local: &mut LocalV<F>) {
        let Usual { is_usual, is_plain, everywhere } = *self;
        if is_plain.bits() != 0xffff {
            // SAFETY: instruction set: this runs below a kernel's.
            unsafe { S::run(Unusual { rays, local, is_usual, everywhere }) };
        }
    }
}

/// Makes up for rays that are not usual: a function of its own, since it is rare.
struct Unusual<'a, F: Float> {
    rays: &'a RaysV<F>,
    local: &'a mut LocalV<F>,
    is_usual: F::Mask,
    everywhere: F,
}

impl<F: Float> Kernel for Unusual<'_, F> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Simd>(self) {
        let Unusual { rays, local, is_usual, everywhere } = self;
        let d = &rays.direction;
        let smallest = F::splat(SMALLEST_DIRECTION);
        let safe = each!(k => d[k].or_else(smallest.lt(d[k].abs()), smallest.xor(d[k].sign())));
        let inverse = each!(k => F::splat(1.0).div(safe[k]));
        let largest = F::splat(LARGEST_NUMBER);
        let everywhere = everywhere.or_else(F::splat(SHORT).le(largest_component(d)), largest);
        let own = sum(d);
        let in_range = sum(&rays.origin).add(own).le(F::splat(LARGEST_NUMBER));
        let in_range = in_range.and(F::splat(SHORTEST_DIRECTION).le(own));
        local.t_min = rays.t_min.or_else(in_range, F::splat(f32::NAN));
        local.slab = SlabV::new(&rays.origin, inverse, everywhere);
        local.length = local.length.or_else(is_usual, F::splat(f32::INFINITY));
        local.edge_slack = F::splat(EDGE_SLACK).mul(local.length);
    }
}

impl TriangleBlock {
    /// How many lanes are used.
    #[inline(always)]
    pub(super) fn count<S: Simd>(&self) -> usize {
        // SAFETY: lanes: four numbers of 32 bits are four floats.
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
    /// First vertex minus the origin.
    pub(super) from_origin: Vec3V<F>,
    pub(super) plane: StepPlanes<F>,
}

/// Triangles of blocks as they are there, a triangle a lane.
pub(super) struct BlockV<F> {
    pub(super) v0: Vec3V<F>,
    pub(super) v1: Vec3V<F>,
    pub(super) v2: Vec3V<F>,
    pub(super) lengths: F,
    pub(super) product: F,
}

/// What the first step says of a ray and a triangle a lane.
pub(super) struct Look<F: Float> {
    pub(super) determinant: Determinant<F>,
    pub(super) edges: EdgesV<F>,
    pub(super) planes: PlanesV<F>,
    pub(super) slack: F,
}

impl<F: Float> Look<F> {
    /// Of rays with these origins and this reach.
    #[inline(always)]
    pub(super) fn new(rays: &StepRays<F>, origin: &Vec3V<F>, reach: F, block: &BlockV<F>) -> Look<F> {
        let (e1, e2) = (subtract(&block.v1, &block.v0), subtract(&block.v2, &block.v0));
        let from_origin = subtract(&block.v0, origin);
        let normal = cross(&e1, &e2);
        let determinant = Determinant::new(&normal, &rays.direction);
        let edges = EdgesV::new(&from_origin, &e1, &e2, &rays.direction, &determinant);
        let lengths = block.lengths;
        let distance = distance(&from_origin, reach, lengths);
        let plane = StepPlanes {
            product: block.product,
            lengths,
            distance,
            distance_with_lengths: distance.add(lengths.abs()),
            numerator: dot(&normal, &from_origin),
        };
        let slack = plane.slack(rays.edge_slack);
        Look { determinant, edges, planes: plane.meet(rays.length, &determinant, slack), slack }
    }

    /// Bits of the lanes that may be a hit no later than this end.
    #[inline(always)]
    pub(super) fn may_meet(&self, rays: &StepRays<F>, end: F) -> u32 {
        let beyond = self.planes.is_beyond(rays.t_min, end);
        // (What it is not, since NaN is no reason to leave out a triangle.)
        !self.edges.least.lt(self.slack.negate()).or(beyond).bits()
    }

    /// Bits of the lanes that are a hit for certain.
    #[inline(always)]
    pub(super) fn is_certain(&self, rays: &StepRays<F>) -> u32 {
        let between = rays.t_min.lt(self.planes.low).and(self.planes.high.le(rays.t_max));
        self.slack.le(self.edges.least).and(self.planes.is_steep).and(between).bits()
    }

    /// Bits of the lanes that are met from behind.
    #[inline(always)]
    pub(super) fn backs(&self) -> u32 {
        self.determinant.sign.same_bits(F::splat(0.0)).bits()
    }
}

/// What the first step needs of their planes.
#[derive(Clone, Copy)]
pub(super) struct StepPlanes<F> {
    /// Lengths of the two edges, multiplied.
    pub(super) product: F,
    /// And added up.
    pub(super) lengths: F,
    /// At least the length from the origin to the first vertex, with the ray's reach.
    pub(super) distance: F,
    /// That with the lengths.
    pub(super) distance_with_lengths: F,
    /// First vertex minus the origin, dot the normal.
    pub(super) numerator: F,
}

/// Direction dot normal, taken apart.
#[derive(Clone, Copy)]
pub(super) struct Determinant<F> {
    /// It is set where a ray meets the front.
    pub(super) sign: F,
    pub(super) size: F,
}

impl<F: Float> Determinant<F> {
    #[inline(always)]
    pub(super) fn new(normal: &Vec3V<F>, direction: &Vec3V<F>) -> Determinant<F> {
        let determinant = dot(normal, direction);
        let sign = determinant.sign();
        Determinant { sign, size: determinant.xor(sign) }
    }
}

/// Edge functions: as in `FirstStep`.
#[derive(Clone, Copy)]
pub(super) struct EdgesV<F> {
    pub(super) u: F,
    pub(super) v: F,
    /// The smallest of three.
    pub(super) least: F,
}

/// When rays meet the planes of triangles: as in `Meeting`.
#[derive(Clone, Copy)]
pub(super) struct PlanesV<F: Float> {
    pub(super) t: F,
    pub(super) error: F,
    pub(super) low: F,
    pub(super) high: F,
    /// One over the determinant.
    pub(super) inverse: F,
    pub(super) is_steep: F::Mask,
}

/// Distances from the origins of rays with this reach to the first vertices of triangles whose edges have these lengths.
#[inline(always)]
pub(super) fn distance<F: Float>(from_origin: &Vec3V<F>, reach: F, lengths: F) -> F {
    let c = each!(k => from_origin[k].abs());
    F::splat(EDGE_REACH).fma(lengths, c[0].add(c[1]).add(c[2].add(reach)))
}

impl<F: Float> EdgesV<F> {
    /// Of triangles with these edges, whose first vertex is here.
    #[inline(always)]
    pub(super) fn new(
        from_origin: &Vec3V<F>,
        e1: &Vec3V<F>,
        e2: &Vec3V<F>,
        direction: &Vec3V<F>,
        determinant: &Determinant<F>,
    ) -> EdgesV<F> {
        let Determinant { sign, size } = *determinant;
        let r = cross(from_origin, direction);
        let u = dot(&r, e2).xor(sign);
        let v = dot(&r, e1).xor(sign.xor(F::splat(0.0).negate()));
        EdgesV { u, v, least: u.min(v).min(size.sub(u).sub(v)) }
    }
}

impl<F: Float> StepPlanes<F> {
    /// By how much edge functions may be wrong, for rays with this edge slack.
    #[inline(always)]
    pub(super) fn slack(&self, edge_slack: F) -> F {
        edge_slack.mul(self.distance_with_lengths).fma(self.lengths, F::splat(UNDERFLOW_SLACK))
    }

    /// When rays with directions of this length meet them.
    #[inline(always)]
    pub(super) fn meet(&self, length: F, determinant: &Determinant<F>, slack: F) -> PlanesV<F> {
        let Determinant { sign, size } = *determinant;
        let inverse = F::splat(1.0).div(size);
        let t = self.numerator.xor(sign).mul(inverse);
        let product = self.product;
        let distances = t.abs().fma(length, self.distance);
        let underflow = F::splat(T_UNDERFLOW).mul(inverse);
        let error = F::splat(T_SLACK).mul(product.mul(inverse)).fma(distances, underflow);
        PlanesV { t, error, low: t.sub(error), high: t.add(error), inverse, is_steep: slack.le(size) }
    }
}

impl<F: Float> PlanesV<F> {
    /// Whether a hit lies beyond an end for certain.
    #[inline(always)]
    pub(super) fn is_beyond(&self, t_min: F, end: F) -> F::Mask {
        self.high.lt(t_min).or(end.lt(self.low)).and(self.is_steep)
    }

    /// Whether there is a clear hit: a certain one whose `t`, `u` and `v` can be reported. As in `Meeting`.
    #[inline(always)]
    pub(super) fn is_clear(&self, ray: &StepRays<F>, edges: &EdgesV<F>, slack: F, size: F) -> F::Mask {
        let bound = F::splat(T_ERROR).mul(self.t.abs().fma(ray.length, ray.scale));
        let is_exact = self.error.mul(ray.length).le(bound).and(slack.le(F::splat(UV_ERROR).mul(size)));
        let is_between = ray.t_min.lt(self.low).and(self.high.le(ray.t_max));
        slack.le(edges.least).and(is_exact).and(is_between)
    }
}
