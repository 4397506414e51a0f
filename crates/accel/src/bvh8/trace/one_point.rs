//! Rays from one point.

use super::batch::ALONE_COHERENT;
use super::found::{ANY, Found};
use super::packet::{LaneFilters, Packet, Query16, rays_from_one_point, trace};
use super::single;
use crate::bvh8::view::Bvh8View;
use crate::simd::{Float, Kernel, Mask, Simd};
use eosphor_core::hierarchy::{IgnoreWork, ShadowBatch};
use eosphor_core::ray::RayFilter;
use std::mem::MaybeUninit;

/// In so small a hierarchy most of the rays that walk together from one point enter the same leaves. (800 blocks: a picture took
/// 0.97 times as long. 25,000 blocks: 1.12 times.)
const FEW_BLOCKS: usize = 2000;

/// Rays from one point, towards a light: N packets that walk together.
pub(super) struct FromOnePoint<'a, const W: usize, const N: usize> {
    pub(super) bvh: &'a Bvh8View<'a>,
    pub(super) batch: &'a ShadowBatch<W>,
    pub(super) filter: &'a RayFilter,
    /// The lanes that are asked for.
    pub(super) active: &'a [bool; W],
}

/// Bits of sixteen lanes, or as many as there are.
#[inline(always)]
fn bits_of(lanes: &[bool]) -> u32 {
    let mut bits = 0;
    let mut lane = 0;
    while lane < lanes.len() && lane < 16 {
        bits |= u32::from(lanes[lane]) << lane;
        lane += 1;
    }
    bits
}

impl<const W: usize, const N: usize> Kernel for FromOnePoint<'_, W, N> {
    /// The lanes that something hides; those that are not asked for are hidden.
    type Output = [bool; W];

    // (All of it here, where loops over lanes are compiled for the instruction set.)
    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> [bool; W] {
        let FromOnePoint { bvh, batch, filter, active } = self;
        let (mut hidden, mut bits, mut count) = ([true; W], [0; N], 0);
        let mut k = 0;
        while k < N && 16 * k < W {
            bits[k] = bits_of(&active[16 * k..]);
            count += bits[k].count_ones();
            k += 1;
        }
        // Two rays are faster alone.
        if count <= 2 || !cfg!(feature = "packets") {
            for lane in 0..W {
                if active[lane] {
                    let ray = batch.ray(lane);
                    let mut found = Found::nothing(ray.t_max);
                    // SAFETY: instruction set: a kernel is run below its own.
                    unsafe { single::trace::<S, _, ANY>(bvh, &ray, filter, IgnoreWork, &mut found) };
                    hidden[lane] = found.any;
                }
            }
            return hidden;
        }
        let filters = [filter; 16];
        let lanes = if filter.cull_back_faces { Some(LaneFilters::<S>::shared(filter)) } else { None };
        let first = rays_from_one_point::<S, W>(batch, 0);
        let mut rays = [first; N];
        let mut packets = [const { MaybeUninit::<Packet<S>>::uninit() }; N];
        k = 0;
        while k < N {
            if k > 0 {
                rays[k] = rays_from_one_point::<S, W>(batch, 16 * k);
            }
            packets[k].write(Packet::new(rays[k].t_max));
            k += 1;
        }
        let mut room = MaybeUninit::uninit();
        let lane_filters = lanes.as_ref();
        let query = Query16 {
            bvh,
            shared_filter: Some(filter),
            lane_filters,
            filters: &filters,
            alone: ALONE_COHERENT,
            leaves_by_bounds: bvh.blocks.len() <= FEW_BLOCKS,
        };
        // SAFETY: written places: all packets are. Instruction set: a kernel is run below its own.
        unsafe {
            let packets = &mut *(&raw mut packets).cast::<[Packet<S>; N]>();
            trace::<S, ANY, N>(packets, &rays, bits, &[query; N], &mut room);
            k = 0;
            while k < N {
                bits[k] = !bits[k] | packets[k].end.same_bits(S::F16::splat(f32::NEG_INFINITY)).bits();
                k += 1;
            }
        }
        for lane in 0..W {
            hidden[lane] = bits[lane / 16] >> (lane % 16) & 1 == 1;
        }
        hidden
    }
}
