//! Bounds of rays, to test boxes against all of them at a time.

use super::{LocalPacket, MaskOf};
use crate::simd::{Float, Mask, Simd, Vec3V, cross, each};
use eosphor_core::intersect::{EXTENT_SLACK, LARGEST_NUMBER, ORIGIN_SLACK, SHORT};
use std::mem::MaybeUninit;

/// Bounds of the rays of a group, for boxes: `plane * scale + offset` is no later than any ray enters, no earlier than
/// any leaves.
pub(super) struct Interval<S: Simd, const N: usize> {
    pub(super) near_scale: Vec3V<S::F8>,
    pub(super) near_offset: Vec3V<S::F8>,
    pub(super) far_scale: Vec3V<S::F8>,
    pub(super) far_offset: Vec3V<S::F8>,
    pub(super) t_min: S::F8,
    /// Whether all rays start at one point, and their numbers are usual.
    pub(super) is_one_origin: bool,
    /// That point, and their reach.
    pub(super) origin: [f32; 4],
    /// Unless they start at one point: origin cross direction.
    pub(super) moments: MaybeUninit<[Vec3V<S::F16>; N]>,
    /// At least the distance from 0 to any of the origins, with the rays' reach.
    pub(super) origin_distance: f32,
    /// The largest of the rays' edge slacks.
    pub(super) most_slack: f32,
}

/// The interval is widened by so many times what each ray's own test is: over the rounding of both that comes from origins.
const WIDER: f32 = 4.0;

/// And its far end is moved out by this: over the rounding of both that comes from planes, which is some 8 times 2^-24 of
/// where they are met, and of the origin.
const FARTHER: f32 = 1.0 + 1.0 / 1_048_576.0;

/// The smallest or the largest number among the rays of groups.
macro_rules! extreme {
    ($groups:expr, $better:ident, $whole:ident, $none:expr, $k:ident => $of:expr) => {{
        let none = S::F16::splat($none);
        let mut best = none;
        let mut $k = 1;
        while $k < N {
            best = best.$better($of.or_else($groups[$k], none));
            $k += 1;
        }
        $k = 0;
        best.$better($of.or_else($groups[$k], none)).$whole(MaskOf::<S>::from_bits(0xffff))
    }};
}

/// Whether some rays meet every box ([`SHORT`]).
#[inline(always)]
fn has_short_rays<S: Simd, const N: usize>(legs: &[LocalPacket<S>; N], groups: &[MaskOf<S>; N]) -> bool {
    let mut any = false;
    let mut member = 0;
    while member < N {
        let [x, y, z] = &legs[member].own.direction;
        let is_long = S::F16::splat(SHORT).le(x.abs().max(y.abs()).max(z.abs()));
        any |= groups[member].without(is_long).any();
        member += 1;
    }
    any
}

impl<S: Simd, const N: usize> Interval<S, N> {
    /// Of rays that all go into one octant and whose `t_min` is not below 0: what lies behind an origin then fails by
    /// its sign, whatever the bounds make of it. There is at least one.
    #[inline(always)]
    pub(super) fn new(
        legs: &[LocalPacket<S>; N],
        extent: f32,
        groups: &[MaskOf<S>; N],
        octant: usize,
    ) -> Interval<S, N> {
        let zero = S::F8::splat(0.0);
        let none = [zero, zero, zero];
        let mut interval = Interval {
            near_scale: none,
            near_offset: none,
            far_scale: none,
            far_offset: none,
            t_min: zero,
            is_one_origin: false,
            origin: [0.0; 4],
            moments: MaybeUninit::uninit(),
            origin_distance: 0.0,
            most_slack: 0.0,
        };
        let mut member = 0;
        while member + 1 < N && !groups[member].any() {
            member += 1;
        }
        let leg = &legs[member];
        let first = groups[member].bits().trailing_zeros() as usize & 15;
        let mut low = each!(k => leg.own.origin[k].to_array().as_ref()[first]);
        let mut high = each!(k => leg.own.origin[k].to_array().as_ref()[first]);
        // Most groups start at one point. The first look then multiplies in another order, which for unusual numbers overflows
        // where core's does not.
        let (mut one_origin, mut is_usual) = (true, true);
        member = 0;
        while member < N {
            let LocalPacket { own, local, .. } = &legs[member];
            let same = each!(k => own.origin[k].same_bits(S::F16::splat(low[k])));
            one_origin &= !groups[member].without(same[0].and(same[1]).and(same[2])).any();
            let usual = local.length.lt(S::F16::splat(f32::INFINITY));
            is_usual &= !groups[member].without(usual).any();
            member += 1;
        }
        let mut k = 0;
        if !one_origin {
            while k < 3 {
                low[k] = extreme!(groups, min, smallest, f32::INFINITY, m => legs[m].own.origin[k]);
                high[k] = extreme!(groups, max, largest, f32::NEG_INFINITY, m => legs[m].own.origin[k]);
                k += 1;
            }
        }
        let reach = each!(k => low[k].abs().max(high[k].abs()));
        let mut everywhere = EXTENT_SLACK * (extent + reach[0].max(reach[1]).max(reach[2]));
        if !is_usual && has_short_rays(legs, groups) {
            everywhere = LARGEST_NUMBER;
        }
        k = 0;
        while k < 3 {
            let i0 = extreme!(groups, min, smallest, f32::INFINITY, m => legs[m].local.slab.inverse[k]);
            let i1 = extreme!(groups, max, largest, f32::NEG_INFINITY, m => legs[m].local.slab.inverse[k]);
            let backward = octant >> k & 1 == 1;
            let (near, near_origin) = if backward { (i1, low[k]) } else { (i0, high[k]) };
            let (far, far_origin) = if backward { (i0, high[k]) } else { (i1, low[k]) };
            let slack = WIDER * (ORIGIN_SLACK * reach[k] + everywhere) * i0.abs().max(i1.abs());
            interval.near_scale[k] = S::F8::splat(near);
            interval.near_offset[k] = S::F8::splat(-(near * near_origin) - slack);
            interval.far_scale[k] = S::F8::splat(FARTHER * far);
            interval.far_offset[k] = S::F8::splat(FARTHER * (slack - far * far_origin));
            k += 1;
        }
        if one_origin & is_usual {
            interval.is_one_origin = true;
            interval.origin = [low[0], low[1], low[2], leg.local.reach.to_array().as_ref()[first]];
        } else {
            let moments = interval.moments.as_mut_ptr().cast::<Vec3V<S::F16>>();
            member = 0;
            while member < N {
                let own = legs[member].own;
                // SAFETY: written places: there is room for N moments, and members are fewer.
                unsafe { moments.add(member).write(cross(&own.origin, &own.direction)) };
                member += 1;
            }
            // Where an instance placed it, a ray's reach is as much as its origin.
            interval.origin_distance = 2.0 * (reach[0] + reach[1] + reach[2]);
            interval.most_slack =
                extreme!(groups, max, largest, f32::NEG_INFINITY, m => legs[m].local.edge_slack);
        }
        interval
    }
}
