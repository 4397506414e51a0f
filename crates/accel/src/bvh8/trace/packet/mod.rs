//! Sixteen rays at a time.
//!
//! Rays of one octant walk together: a node's eight boxes are first tested against the interval that holds all rays, the
//! ones that pass against each ray (Wald et al. 2001, "Interactive Rendering with Coherent Ray Tracing"; Boulos et al.
//! 2006, "Geometric and Arithmetic Culling Methods for Entire Ray Packets"). Where only a few rays are left in a
//! subtree, they go on alone.

mod alone;
mod block;
mod decide;
mod filters;
mod instance;
mod interval;
mod look;
mod sphere;
mod walk;

pub(super) use filters::LaneFilters;

use super::lanes::{LocalV, RaysV, StepRays};
use super::walk::{NEXT, Query};
use crate::bvh8::view::Bvh8View;
use crate::bvh8::{Child, EMPTY};
use crate::simd::{Float, Mask, Simd, each, splat3};
use alone::SingleRays;
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::{FAR, ShadowBatch};
use eosphor_core::intersect::T_ROUNDING;
use eosphor_core::ray::{RayFilter, UNKNOWN_REST};
use walk::Walk;

/// The best hit is no earlier than its `t` less this times what it may be later. The upper bound lies 4 · 2^-24 of `t` beyond
/// it at least, and is rounded by 2^-24 of that; 2^-24 is also the most that a precise `t` was rounded by.
const TO_LOW: f32 = 1.25;

type MaskOf<S> = <<S as Simd>::F16 as Float>::Mask;
type PartMask<S> = <<S as Simd>::Part as Float>::Mask;

/// What sixteen rays have found.
pub(super) struct Packet<S: Simd> {
    /// Hits beyond this cannot matter any more. For [`ANY`], minus infinity where there is a hit.
    pub(super) end: S::F16,
    pub(super) best: Best<S>,
}

/// The best hits: in memory, since they change seldom.
pub(super) struct Best<S: Simd> {
    pub(super) t: S::F16,
    /// Where it has been computed.
    t_rest: S::F16,
    pub(super) u: S::F16,
    pub(super) v: S::F16,
    /// As bits, like the next two: as `Found::place`.
    place: S::F16,
    pub(super) primitive: S::F16,
    /// 0 where nothing was hit, too.
    instance: S::F16,
    /// Bits of the lanes whose `t_rest` has been computed.
    precise: u32,
}

impl<S: Simd> Best<S> {
    #[inline(always)]
    fn none(t_max: S::F16) -> Best<S> {
        let none = S::F16::splat(f32::from_bits(u32::MAX));
        let zero = S::F16::splat(0.0);
        Best {
            t: t_max,
            t_rest: zero,
            u: zero,
            v: zero,
            place: none,
            primitive: none,
            instance: zero,
            precise: 0,
        }
    }

    /// What rounding took from `t`, and the instances that were hit, as bits.
    #[inline(always)]
    pub(super) fn rest_and_instance(&self) -> (S::F16, S::F16) {
        let none = S::F16::splat(f32::from_bits(u32::MAX));
        let missed = self.primitive.same_bits(none);
        let mut rest = S::F16::splat(0.0).or_else(missed, S::F16::splat(UNKNOWN_REST));
        if self.precise != 0 {
            rest = self.t_rest.or_else(MaskOf::<S>::from_bits(self.precise), rest);
        }
        (rest, none.or_else(missed, self.instance))
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
    own: &'a RaysV<S::F16>,
    local: &'a LocalV<S::F16>,
    extent: f32,
    instance: u32,
    world: &'a RaysV<S::F16>,
}

impl<S: Simd> Leg<'_, S> {
    /// A part of the rays, for the first step.
    #[inline(always)]
    fn step_rays(&self, part: usize) -> StepRays<S::Part> {
        let (own, local) = (self.own, self.local);
        StepRays {
            direction: each!(k => S::part(&own.direction[k], part)),
            t_min: S::part(&local.t_min, part),
            t_max: S::part(&own.t_max, part),
            length: S::part(&local.length, part),
            edge_slack: S::part(&local.edge_slack, part),
            scale: S::part(&local.scale, part),
        }
    }

    /// Lanes that start far from the box around a tree.
    #[inline(always)]
    fn far_from(&self, bounds: &Bounds) -> MaskOf<S> {
        let extent = bounds.extent();
        if extent > 0.0 {
            S::F16::splat(FAR * extent).lt(self.own.largest())
        } else {
            MaskOf::<S>::from_bits(0)
        }
    }
}

/// Sixteen rays.
///
/// # Safety
/// The pointers point to rays, and the CPU has the instruction set.
#[inline(always)]
pub(super) unsafe fn load_rays<S: Simd>(rays: &[*const f32; 16]) -> RaysV<S::F16> {
    // SAFETY: a ray is eight floats.
    let [ox, oy, oz, t_min, dx, dy, dz, t_max] = unsafe { S::transpose16(rays) };
    RaysV { origin: [ox, oy, oz], direction: [dx, dy, dz], t_min, t_max }
}

/// Rays that start at one point.
#[inline(always)]
pub(super) fn rays_from_one_point<S: Simd>(batch: &ShadowBatch<16>) -> RaysV<S::F16> {
    // SAFETY: sixteen floats each.
    unsafe {
        let direction =
            [S::F16::load(batch.x.as_ptr()), S::F16::load(batch.y.as_ptr()), S::F16::load(batch.z.as_ptr())];
        let t_max = S::F16::load(batch.t_max.as_ptr());
        RaysV { origin: splat3(batch.origin), direction, t_min: S::F16::splat(0.0), t_max }
    }
}

impl<S: Simd> Packet<S> {
    /// Nothing, for rays with these ends.
    #[inline(always)]
    pub(super) fn new(t_max: S::F16) -> Packet<S> {
        let end = t_max.abs().fma(S::F16::splat(T_ROUNDING), t_max);
        Packet { end, best: Best::none(t_max) }
    }

    /// Traces the lanes of `active`.
    ///
    /// # Safety
    /// The CPU has the instruction set.
    #[inline(always)]
    pub(super) unsafe fn trace<const QUERY: Query>(
        &mut self,
        rays: &RaysV<S::F16>,
        active: u32,
        query: &Query16<S>,
    ) {
        debug_assert!(QUERY != NEXT);
        let bvh = query.bvh;
        let zero = S::F16::splat(0.0);
        let active = MaskOf::<S>::from_bits(active);
        let extent = bvh.geometries[0].extent;
        let (mut local, usual) = LocalV::of_world(rays, extent);
        usual.mend_others::<S>(rays, &mut local);
        let leg = Leg::<S> { own: rays, local: &local, extent, instance: 0, world: rays };
        let mut singles = SingleRays::none();
        let live = active.and(zero.le(leg.local.t_min)).and(leg.local.t_min.le(self.end));
        let far = S::F16::splat(bvh.near).lt(rays.largest());
        // What starts before its origin goes alone too: the bounds of a group do not hold there.
        let before = active.and(leg.local.t_min.lt(zero));
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
        let backward = each!(k => leg.local.slab.inverse[k].lt(zero).bits());
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
