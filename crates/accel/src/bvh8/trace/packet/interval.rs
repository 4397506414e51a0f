//! Bounds of rays, to test boxes against all of them at a time.

use super::{Leg, MaskOf};
use crate::bvh8::trace::single_ray::FARTHEST_VERTEX;
use crate::simd::{Float, Mask, Simd, Vec3V, cross, each};
use eosphor_core::intersect::{EXTENT_SLACK, ORIGIN_SLACK};
use std::mem::MaybeUninit;

/// Bounds of the rays of a group, for boxes: `plane * scale + offset` is no later than any ray enters, no earlier than
/// any leaves.
pub(super) struct Interval<S: Simd> {
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
    pub(super) moment: MaybeUninit<Vec3V<S::F16>>,
    /// At least the distance from there to the first vertex of any triangle of the geometry, with the lengths of two edges
    /// and the rays' reach.
    pub(super) most_distance: f32,
    /// The largest of the rays' edge slacks.
    pub(super) most_slack: f32,
}

/// The interval is widened by so many times what each ray's own test is: over the rounding of both that comes from origins.
const WIDER: f32 = 4.0;

/// And its far end is moved out by this: over the rounding of both that comes from planes, which is some 8 times 2^-24 of
/// where they are met, and of the origin.
const FARTHER: f32 = 1.0 + 1.0 / 1_048_576.0;

impl<S: Simd> Interval<S> {
    /// Of rays that all go into one octant and whose `t_min` is not below 0: what lies behind an origin then fails by
    /// its sign, whatever the bounds make of it.
    #[inline(always)]
    pub(super) fn new(leg: &Leg<S>, extent: f32, group: MaskOf<S>, octant: usize) -> Interval<S> {
        let (origin, local) = (&leg.own.origin, leg.local);
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
            moment: MaybeUninit::uninit(),
            most_distance: 0.0,
            most_slack: 0.0,
        };
        let first = group.bits().trailing_zeros() as usize & 15;
        let mut low = each!(k => origin[k].to_array().as_ref()[first]);
        let mut high = low;
        // Most groups start at one point.
        let same = each!(k => origin[k].same_bits(S::F16::splat(low[k])));
        let one_origin = !group.without(same[0].and(same[1]).and(same[2])).any();
        let mut k = 0;
        if !one_origin {
            while k < 3 {
                low[k] = origin[k].smallest(group);
                high[k] = origin[k].largest(group);
                k += 1;
            }
        }
        let reach = each!(k => low[k].abs().max(high[k].abs()));
        let everywhere = EXTENT_SLACK * (extent + reach[0].max(reach[1]).max(reach[2]));
        k = 0;
        while k < 3 {
            let inverse = local.slab.inverse[k];
            let (i0, i1) = (inverse.smallest(group), inverse.largest(group));
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
        // The first look then multiplies in another order, which for unusual numbers overflows where core's does not.
        let is_usual = local.length.lt(S::F16::splat(f32::INFINITY));
        if one_origin && !group.without(is_usual).any() {
            let own_reach = if leg.instance == 0 { 0.0 } else { local.reach.to_array().as_ref()[first] };
            interval.is_one_origin = true;
            interval.origin = [low[0], low[1], low[2], own_reach];
        } else {
            interval.moment.write(cross(origin, &leg.own.direction));
            // Where an instance placed it, a ray's reach is as much as its origin.
            interval.most_distance = FARTHEST_VERTEX * leg.extent + 2.0 * (reach[0] + reach[1] + reach[2]);
            interval.most_slack = local.edge_slack.largest(group);
        }
        interval
    }
}
