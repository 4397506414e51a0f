//! Sixteen rays at a time.
//!
//! Rays of one octant walk together: a node's eight boxes are first tested against the interval that holds all rays, the
//! ones that pass against each ray (Wald et al. 2001, "Interactive Rendering with Coherent Ray Tracing"; Boulos et al.
//! 2006, "Geometric and Arithmetic Culling Methods for Entire Ray Packets"). Where only a few rays are left in a
//! subtree, they go on alone.

mod alone;
mod block;
mod filters;
mod instance;
mod interval;
mod sphere;
mod walk;

pub(super) use filters::LaneFilters;

use super::lanes::{Ends, RayV};
use super::walk::{NEXT, Query};
use crate::bvh8::view::Bvh8View;
use crate::bvh8::{Child, EMPTY};
use crate::simd::{Float, Mask, Simd, Vec3V, each, splat3};
use alone::SingleRays;
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::{FAR, ShadowBatch};
use eosphor_core::intersect::T_ROUNDING;
use eosphor_core::ray::RayFilter;
use walk::Walk;

type MaskOf<S> = <<S as Simd>::F16 as Float>::Mask;

/// Sixteen rays in world space.
#[derive(Clone, Copy)]
pub(super) struct WorldRays<S: Simd> {
    origin: Vec3V<S::F16>,
    direction: Vec3V<S::F16>,
    t_min: S::F16,
    t_max: S::F16,
}

/// Sixteen rays and what they have found.
pub(super) struct Packet<S: Simd> {
    rays: WorldRays<S>,
    /// Hits beyond this cannot matter any more. For [`ANY`], minus infinity where there is a hit.
    pub(super) end: S::F16,
    pub(super) best: Best<S>,
}

/// The best hits: in memory, since they change seldom.
pub(super) struct Best<S: Simd> {
    /// The `t` of double precision is no less than this.
    low: S::F16,
    pub(super) t: S::F16,
    pub(super) t_rest: S::F16,
    pub(super) u: S::F16,
    pub(super) v: S::F16,
    /// As bits, like the next two: as `Found::place`.
    place: S::F16,
    pub(super) primitive: S::F16,
    pub(super) instance: S::F16,
}

impl<S: Simd> Best<S> {
    #[inline(always)]
    fn none(t_max: S::F16) -> Best<S> {
        let none = S::F16::splat(f32::from_bits(u32::MAX));
        let zero = S::F16::splat(0.0);
        Best {
            low: t_max,
            t: t_max,
            t_rest: zero,
            u: zero,
            v: zero,
            place: none,
            primitive: none,
            instance: none,
        }
    }
}

/// What does not change while a packet is traced.
#[derive(Clone, Copy)]
pub(super) struct Query16<'a, S: Simd> {
    pub(super) bvh: &'a Bvh8View<'a>,
    /// What the rays leave out, in lanes and one by one; `None` where they leave out nothing.
    pub(super) lane_filters: Option<&'a LaneFilters<S>>,
    pub(super) filters: &'a [&'a RayFilter; 16],
    /// Where at most so many rays are left in a subtree, they go on alone.
    pub(super) alone: u32,
}

/// The rays in the space of one instance.
struct Leg<'a, S: Simd> {
    ray: RayV<S::F16>,
    extent: f32,
    instance: u32,
    world: &'a WorldRays<S>,
}

impl<S: Simd> WorldRays<S> {
    #[inline(always)]
    fn ends(&self) -> Ends<S::F16> {
        Ends { t_min: self.t_min, t_max: self.t_max }
    }
}

impl<S: Simd> Leg<'_, S> {
    /// Lanes that start far from the box around a tree.
    #[inline(always)]
    fn far_from(&self, bounds: &Bounds) -> MaskOf<S> {
        let extent = bounds.extent();
        if extent > 0.0 {
            S::F16::splat(FAR * extent).lt(self.ray.largest)
        } else {
            MaskOf::<S>::from_bits(0)
        }
    }
}

impl<S: Simd> Packet<S> {
    #[inline(always)]
    fn new(rays: WorldRays<S>) -> Packet<S> {
        let t_max = rays.t_max;
        let end = t_max.abs().fma(S::F16::splat(T_ROUNDING), t_max);
        Packet { rays, end, best: Best::none(t_max) }
    }

    /// From sixteen rays.
    ///
    /// # Safety
    /// The pointers point to rays, and the CPU has the instruction set.
    #[inline(always)]
    pub(super) unsafe fn load(rays: &[*const f32; 16]) -> Packet<S> {
        // SAFETY: a ray is eight floats.
        let [ox, oy, oz, t_min, dx, dy, dz, t_max] = unsafe { S::transpose16(rays) };
        Packet::new(WorldRays { origin: [ox, oy, oz], direction: [dx, dy, dz], t_min, t_max })
    }

    /// From rays that start at one point.
    #[inline(always)]
    pub(super) fn from_one_point(batch: &ShadowBatch<16>) -> Packet<S> {
        // SAFETY: sixteen floats each.
        unsafe {
            Packet::new(WorldRays {
                origin: splat3(batch.origin),
                direction: [
                    S::F16::load(batch.x.as_ptr()),
                    S::F16::load(batch.y.as_ptr()),
                    S::F16::load(batch.z.as_ptr()),
                ],
                t_min: S::F16::splat(0.0),
                t_max: S::F16::load(batch.t_max.as_ptr()),
            })
        }
    }

    /// Traces the lanes of `active`.
    ///
    /// # Safety
    /// The CPU has the instruction set.
    #[inline(always)]
    pub(super) unsafe fn trace<const QUERY: Query>(&mut self, active: u32, query: &Query16<S>) {
        debug_assert!(QUERY != NEXT);
        let bvh = query.bvh;
        let zero = S::F16::splat(0.0);
        let active = MaskOf::<S>::from_bits(active);
        let rays = self.rays;
        let extent = bvh.geometries[0].extent;
        let ray = RayV::new::<S>(rays.origin, rays.direction, rays.ends(), extent);
        let leg = Leg::<S> { ray, extent, instance: 0, world: &rays };
        let mut singles = SingleRays::none();
        let live = active.and(zero.le(leg.ray.t_min)).and(leg.ray.t_min.le(self.end));
        let far = leg.far_from(&bvh.bounds[0]);
        // What starts before its origin goes alone too: the bounds of a group do not hold there.
        let before = active.and(leg.ray.t_min.lt(zero));
        // SAFETY: the caller's.
        unsafe {
            self.walk_octants::<QUERY, false>(query, bvh.roots[0], &leg, &mut singles, live.without(far));
            let alone = before.or(live.and(far)).bits();
            if alone != 0 && bvh.roots[0] != EMPTY {
                self.go_on_alone::<QUERY, false>(query, bvh.roots[0], &leg, &mut singles, alone);
            }
            if bvh.instance_root != EMPTY {
                let far = leg.far_from(&bvh.instance_bounds);
                let root = bvh.instance_root;
                self.walk_octants::<QUERY, true>(query, root, &leg, &mut singles, live.without(far));
                let alone = before.or(live.and(far)).bits();
                if alone != 0 {
                    self.go_on_alone::<QUERY, true>(query, root, &leg, &mut singles, alone);
                }
            }
        }
    }

    /// Walks for each octant that rays go into.
    #[inline(always)]
    unsafe fn walk_octants<'a, const QUERY: Query, const INSTANCES: bool>(
        &mut self,
        query: &Query16<'a, S>,
        root: Child,
        leg: &Leg<S>,
        singles: &mut SingleRays<'a>,
        active: MaskOf<S>,
    ) {
        let zero = S::F16::splat(0.0);
        let backward = each!(k => leg.ray.slab.inverse[k].lt(zero).bits());
        let mut left = active.bits();
        if root == EMPTY {
            return;
        }
        while left != 0 {
            let lane = left.trailing_zeros();
            let (mut group, mut octant, mut k) = (left, 0, 0);
            while k < 3 {
                if backward[k] >> lane & 1 == 1 {
                    group &= backward[k];
                    octant |= 1 << k;
                } else {
                    group &= !backward[k];
                }
                k += 1;
            }
            left &= !group;
            let group = MaskOf::<S>::from_bits(group);
            let walk = Walk::<S, QUERY, INSTANCES> {
                packet: &mut *self,
                query,
                root,
                leg,
                singles: &mut *singles,
                group,
                octant,
            };
            // SAFETY: the caller's.
            unsafe { S::run(walk) };
        }
    }
}
