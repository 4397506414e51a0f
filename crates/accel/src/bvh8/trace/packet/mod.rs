//! Sixteen rays at a time, and several such packets that walk together.
//!
//! Rays of one octant walk together: a node's eight boxes are first tested against the interval that holds all rays, the
//! ones that pass against each ray (Wald et al. 2001, "Interactive Rendering with Coherent Ray Tracing"; Boulos et al.
//! 2006, "Geometric and Arithmetic Culling Methods for Entire Ray Packets"). Where only a few rays are left in a
//! subtree, they go on alone.

mod alone;
mod block;
mod decide;
mod few;
mod filters;
mod instance;
mod interval;
mod look;
mod sphere;
mod walk;

pub(super) use filters::LaneFilters;

use super::found::{ANY, NEXT, Query};
use super::lanes::{LocalV, RaysV, StepRays};
use crate::bvh8::view::Bvh8View;
use crate::bvh8::{Child, EMPTY};
use crate::simd::{Float, Mask, Simd, each, splat3};
use alone::SingleRays;
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::{FAR, ShadowBatch};
use eosphor_core::intersect::T_ROUNDING;
use eosphor_core::ray::{RayFilter, UNKNOWN_REST};
use std::mem::MaybeUninit;
pub(super) use walk::Room;
use walk::{Walk, WalkLarge};

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
    /// What all rays leave out, where that is the same.
    pub(super) shared_filter: Option<&'a RayFilter>,
    /// What the rays leave out, in lanes and one by one; `None` where they leave out nothing but triangles of the shared filter.
    pub(super) lane_filters: Option<&'a LaneFilters<S>>,
    pub(super) filters: &'a [&'a RayFilter; 16],
    /// Where at most so many rays are left in a subtree, they go on alone.
    pub(super) alone: u32,
    /// Whether the bounds of all rays are enough to tell whether they enter a leaf.
    pub(super) leaves_by_bounds: bool,
}

/// The rays in the space of one instance.
#[derive(Clone, Copy)]
struct LocalPacket<'a, S: Simd> {
    own: &'a RaysV<S::F16>,
    local: &'a LocalV<S::F16>,
    extent: f32,
    instance: u32,
    world: &'a RaysV<S::F16>,
}

impl<S: Simd> LocalPacket<'_, S> {
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
    // SAFETY: whole batch: the pointers are to rays, as promised to this function; a ray is eight floats.
    let [ox, oy, oz, t_min, dx, dy, dz, t_max] = unsafe { S::transpose16(rays) };
    RaysV { origin: [ox, oy, oz], direction: [dx, dy, dz], t_min, t_max }
}

/// Sixteen rays that start at one point, from lane `first` on; those past the last are the first ray of all.
#[inline(always)]
pub(super) fn rays_from_one_point<S: Simd, const W: usize>(
    batch: &ShadowBatch<W>,
    first: usize,
) -> RaysV<S::F16> {
    if first + 16 <= W {
        // SAFETY: lanes: there are sixteen floats of each.
        return unsafe {
            let direction = [
                S::F16::load(batch.x.as_ptr().add(first)),
                S::F16::load(batch.y.as_ptr().add(first)),
                S::F16::load(batch.z.as_ptr().add(first)),
            ];
            let t_max = S::F16::load(batch.t_max.as_ptr().add(first));
            RaysV { origin: splat3(batch.origin), direction, t_min: S::F16::splat(0.0), t_max }
        };
    }
    rays_from_one_point::<S, 16>(&batch.sixteen(first), 0)
}

impl<S: Simd> Packet<S> {
    /// Nothing, for rays with these ends.
    #[inline(always)]
    pub(super) fn new(t_max: S::F16) -> Packet<S> {
        let end = t_max.abs().fma(S::F16::splat(T_ROUNDING), t_max);
        Packet { end, best: Best::none(t_max) }
    }
}

/// Traces the lanes of `active` of packets that walk together.
///
/// # Safety
/// The CPU has the instruction set.
#[inline(always)]
pub(super) unsafe fn trace<S: Simd, const QUERY: Query, const N: usize>(
    packets: &mut [Packet<S>; N],
    rays: &[RaysV<S::F16>; N],
    active: [u32; N],
    queries: &[Query16<S>; N],
    room: &mut Room<S, N>,
) {
    debug_assert!(QUERY != NEXT);
    let bvh = queries[0].bvh;
    let zero = S::F16::splat(0.0);
    let extent = bvh.world.extent;
    let mut locals = MaybeUninit::<[LocalV<S::F16>; N]>::uninit();
    let first = locals.as_mut_ptr().cast::<LocalV<S::F16>>();
    let mut k = 0;
    while k < N {
        let (local, usual) = LocalV::of_world(&rays[k], extent);
        // SAFETY: written places: there is room for N.
        let local = unsafe {
            first.add(k).write(local);
            &mut *first.add(k)
        };
        usual.mend_others::<S>(&rays[k], local);
        k += 1;
    }
    // SAFETY: written places: the loop has written all N.
    let locals = unsafe { locals.assume_init_ref() };
    let mut legs =
        [LocalPacket::<S> { own: &rays[0], local: &locals[0], extent, instance: 0, world: &rays[0] }; N];
    let none = MaskOf::<S>::from_bits(0);
    let (mut near, mut near_instances, mut alone, mut alone_instances) =
        ([none; N], [none; N], [0; N], [0; N]);
    let has_instances = bvh.instance_root != EMPTY;
    k = 0;
    while k < N {
        let leg = LocalPacket::<S> { own: &rays[k], local: &locals[k], world: &rays[k], ..legs[0] };
        legs[k] = leg;
        let active = MaskOf::<S>::from_bits(active[k]);
        let live = active.and(zero.le(leg.local.t_min)).and(leg.local.t_min.le(packets[k].end));
        // What starts before its origin goes alone too: the bounds of a group do not hold there.
        let before = active.and(leg.local.t_min.lt(zero));
        let far = S::F16::splat(bvh.near).lt(rays[k].largest());
        (near[k], alone[k]) = (live.without(far), before.or(live.and(far)).bits());
        if has_instances {
            let far = leg.far_from(&bvh.instance_bounds);
            (near_instances[k], alone_instances[k]) = (live.without(far), before.or(live.and(far)).bits());
        }
        k += 1;
    }
    let mut singles = MaybeUninit::uninit();
    let singles = SingleRays::none::<N>(&mut singles);
    // SAFETY: instruction set: promised to this function. Closed view: the roots are those of the scene.
    unsafe {
        walk_octants::<S, QUERY, false, N>(packets, queries, bvh.world_root, &legs, singles, near, room);
        k = 0;
        while k < N {
            if alone[k] != 0 && bvh.world_root != EMPTY {
                let (query, singles) = (&queries[k], &mut singles[k]);
                packets[k].go_on_alone::<QUERY, false>(query, bvh.world_root, &legs[k], singles, alone[k]);
            }
            k += 1;
        }
        if !has_instances {
            return;
        }
        let root = bvh.instance_root;
        walk_octants::<S, QUERY, true, N>(packets, queries, root, &legs, singles, near_instances, room);
        k = 0;
        while k < N {
            if alone_instances[k] != 0 {
                let (query, singles) = (&queries[k], &mut singles[k]);
                packets[k].go_on_alone::<QUERY, true>(query, root, &legs[k], singles, alone_instances[k]);
            }
            k += 1;
        }
    }
}

/// Walks for each octant that rays go into.
///
/// # Safety
/// Instruction set: the CPU has it. Closed view: `root` is a child of the tree.
#[inline(always)]
unsafe fn walk_octants<'a, S: Simd, const QUERY: Query, const INSTANCES: bool, const N: usize>(
    packets: &mut [Packet<S>; N],
    queries: &[Query16<'a, S>; N],
    root: Child,
    legs: &[LocalPacket<S>; N],
    singles: &mut [SingleRays<'a>; N],
    active: [MaskOf<S>; N],
    room: &mut Room<S, N>,
) {
    let zero = S::F16::splat(0.0);
    let (mut backward, mut left) = ([[0; 3]; N], [0; N]);
    let mut member = 0;
    while member < N {
        backward[member] = each!(k => legs[member].local.slab.inverse[k].lt(zero).bits());
        left[member] = active[member].bits();
        member += 1;
    }
    if root == EMPTY {
        return;
    }
    loop {
        member = 0;
        while member < N && left[member] == 0 {
            member += 1;
        }
        if member == N {
            return;
        }
        let (first, lane) = (backward[member], left[member].trailing_zeros());
        let (mut octant, mut groups) = (0, active);
        let mut k = 0;
        while k < 3 {
            octant |= ((first[k] >> lane & 1) as usize) << k;
            k += 1;
        }
        member = 0;
        while member < N {
            // Rays that go the other way along an axis.
            let [x, y, z] = each!(k => backward[member][k] ^ ((octant >> k & 1) as u32).wrapping_neg());
            let group = left[member] & !(x | y | z);
            left[member] &= !group;
            groups[member] = MaskOf::<S>::from_bits(group);
            member += 1;
        }
        let is_large = QUERY == ANY && !INSTANCES && queries[0].bvh.blocks.len() > few::LARGE;
        let walk = Walk::<S, QUERY, INSTANCES, N> {
            packets: &mut *packets,
            queries,
            root,
            legs,
            singles: &mut *singles,
            groups,
            octant,
            room: &mut *room,
        };
        // SAFETY: instruction set: promised to this function. Closed view: so is the root.
        unsafe {
            if is_large {
                S::run(WalkLarge(walk));
            } else {
                S::run(walk);
            }
        }
    }
}
