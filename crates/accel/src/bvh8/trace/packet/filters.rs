//! What each of sixteen rays leaves out.

use super::MaskOf;
use crate::simd::{Float, Mask, Simd};
use eosphor_core::ray::RayFilter;

/// What the rays leave out.
pub(in super::super) struct LaneFilters<S: Simd> {
    /// Bits of the triangles' numbers and instances.
    start: [S::F16; 2],
    target: [S::F16; 2],
    /// Lanes that see no backs.
    cull: MaskOf<S>,
}

impl<S: Simd> LaneFilters<S> {
    /// The same for all lanes.
    #[inline(always)]
    pub(in super::super) fn shared(filter: &RayFilter) -> LaneFilters<S> {
        let splat = |bits: u32| S::F16::splat(f32::from_bits(bits));
        let (start, target) = (filter.start, filter.target);
        LaneFilters {
            start: [splat(start.primitive), splat(start.instance)],
            target: [splat(target.primitive), splat(target.instance)],
            cull: MaskOf::<S>::from_bits(if filter.cull_back_faces { 0xffff } else { 0 }),
        }
    }

    /// The lanes of `mask` that see a triangle whose front is met where this sign is set.
    #[inline(always)]
    pub(super) fn apply(&self, mask: MaskOf<S>, instance: u32, primitive: u32, sign: S::F16) -> MaskOf<S> {
        let (i, p) = (S::F16::splat(f32::from_bits(instance)), S::F16::splat(f32::from_bits(primitive)));
        let [start, target] = [&self.start, &self.target];
        let start = start[0].same_bits(p).and(start[1].same_bits(i));
        let target = target[0].same_bits(p).and(target[1].same_bits(i));
        let back = sign.same_bits(S::F16::splat(0.0)).and(self.cull);
        mask.without(start.or(target).or(back))
    }

    #[inline(always)]
    pub(in super::super) fn new(filters: &[&RayFilter; 16]) -> LaneFilters<S> {
        let mut bits = [[0u32; 16]; 4];
        let mut cull = 0;
        let mut lane = 0;
        while lane < 16 {
            let f = filters[lane];
            bits[0][lane] = f.start.primitive;
            bits[1][lane] = f.start.instance;
            bits[2][lane] = f.target.primitive;
            bits[3][lane] = f.target.instance;
            cull |= (f.cull_back_faces as u32) << lane;
            lane += 1;
        }
        // SAFETY: lanes: sixteen numbers of 32 bits are sixteen floats.
        unsafe {
            LaneFilters {
                start: [S::F16::load(bits[0].as_ptr().cast()), S::F16::load(bits[1].as_ptr().cast())],
                target: [S::F16::load(bits[2].as_ptr().cast()), S::F16::load(bits[3].as_ptr().cast())],
                cull: MaskOf::<S>::from_bits(cull),
            }
        }
    }
}
