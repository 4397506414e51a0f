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

use super::lanes::RayV;
use super::walk::{ANY, NEXT, Query};
use crate::bvh8::view::Bvh8View;
use crate::bvh8::{Child, EMPTY};
use crate::simd::{Float, Mask, Simd, Vec3V, each, splat3};
use alone::SingleRays;
use eosphor_core::hierarchy::ShadowBatch;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::RayFilter;
use walk::Walk;

type MaskOf<S> = <<S as Simd>::F16 as Float>::Mask;

/// Sixteen rays in world space and what they have found.
pub(super) struct Packet<S: Simd> {
    pub(super) origin: Vec3V<S::F16>,
    pub(super) direction: Vec3V<S::F16>,
    pub(super) t_min: S::F16,
    /// Largest `t` that counts: the best hit's. For [`ANY`], minus infinity where there is a hit.
    pub(super) t_max: S::F16,
    pub(super) best: Best<S>,
}

/// The best hits but their `t`: in memory, since they change seldom.
pub(super) struct Best<S: Simd> {
    pub(super) u: S::F16,
    pub(super) v: S::F16,
    /// As bits.
    pub(super) primitive: S::F16,
    pub(super) instance: S::F16,
}

impl<S: Simd> Best<S> {
    #[inline(always)]
    fn none() -> Best<S> {
        let none = S::F16::splat(f32::from_bits(u32::MAX));
        let zero = S::F16::splat(0.0);
        Best { u: zero, v: zero, primitive: none, instance: none }
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
struct Leg<S: Simd> {
    ray: RayV<S::F16>,
    extent: f32,
    instance: u32,
    /// Where the rays are in the instance's world box; for the world itself, everywhere.
    world_interval: Option<(S::F16, S::F16)>,
    /// Hits are later than this where they count.
    after: S::F16,
}

impl<S: Simd> Packet<S> {
    /// From sixteen rays.
    ///
    /// # Safety
    /// The pointers point to rays, and the CPU has the instruction set.
    #[inline(always)]
    pub(super) unsafe fn load(rays: &[*const f32; 16]) -> Packet<S> {
        // SAFETY: a ray is eight floats.
        let [ox, oy, oz, t_min, dx, dy, dz, t_max] = unsafe { S::transpose16(rays) };
        Packet { origin: [ox, oy, oz], direction: [dx, dy, dz], t_min, t_max, best: Best::none() }
    }

    /// From rays that start at one point.
    #[inline(always)]
    pub(super) fn from_one_point(batch: &ShadowBatch<16>) -> Packet<S> {
        // SAFETY: sixteen floats each.
        unsafe {
            Packet {
                origin: splat3(batch.origin),
                direction: [
                    S::F16::load(batch.x.as_ptr()),
                    S::F16::load(batch.y.as_ptr()),
                    S::F16::load(batch.z.as_ptr()),
                ],
                t_min: S::F16::splat(0.0),
                t_max: S::F16::load(batch.t_max.as_ptr()),
                best: Best::none(),
            }
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
        if QUERY == ANY {
            // That end marks rays with a hit. One that comes with it has none, as with any end that is no number.
            let marked = self.t_max.same_bits(S::F16::splat(f32::NEG_INFINITY));
            self.t_max = S::F16::splat(f32::NAN).or_else(marked, self.t_max);
        }
        let extent = bvh.geometries[0].extent;
        let ray = RayV::new::<S>(self.origin, self.direction, self.t_min, extent);
        let leg = Leg::<S> { ray, extent, instance: 0, world_interval: None, after: ray.t_min };
        let mut singles = SingleRays::none();
        let together = active.and(zero.le(leg.ray.t_min)).and(leg.ray.t_min.le(self.t_max));
        // SAFETY: the caller's.
        unsafe {
            self.walk_octants::<QUERY, false>(query, bvh.roots[0], &leg, &mut singles, together);
            if bvh.instance_root != EMPTY {
                self.walk_octants::<QUERY, true>(query, bvh.instance_root, &leg, &mut singles, together);
            }
        }
        // What starts before its origin: the bounds of a group do not hold there.
        let rest = active.and(leg.ray.t_min.lt(zero)).bits();
        if rest != 0 {
            // SAFETY: the caller's.
            unsafe {
                self.go_on_alone::<QUERY, false>(query, bvh.roots[0], &leg, &mut singles, rest);
                if bvh.instance_root != EMPTY {
                    self.go_on_alone::<QUERY, true>(query, bvh.instance_root, &leg, &mut singles, rest);
                }
            }
        }
    }

    /// Walks for each octant that rays go into.
    #[inline(always)]
    unsafe fn walk_octants<const QUERY: Query, const INSTANCES: bool>(
        &mut self,
        query: &Query16<S>,
        root: Child,
        leg: &Leg<S>,
        singles: &mut SingleRays,
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

type Array16<S> = <<S as Simd>::F16 as Float>::Array;

#[inline(always)]
fn arrays<S: Simd>(v: &Vec3V<S::F16>) -> [Array16<S>; 3] {
    each!(k => v[k].to_array())
}

#[inline(always)]
fn lane_of<A: AsRef<[f32]>>(v: &[A; 3], lane: usize) -> Vec3 {
    vec3(v[0].as_ref()[lane], v[1].as_ref()[lane], v[2].as_ref()[lane])
}
