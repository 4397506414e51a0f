//! What each of sixteen rays leaves out.

use super::{MaskOf, PartMask};
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

    /// The lanes of `mask`, which is that of a part, that see a triangle which they meet with this determinant.
    #[inline(always)]
    pub(super) fn apply(
        &self,
        part: usize,
        mask: PartMask<S>,
        instance: u32,
        primitive: u32,
        determinant: S::Part,
    ) -> PartMask<S> {
        let (i, p) = (S::Part::splat(f32::from_bits(instance)), S::Part::splat(f32::from_bits(primitive)));
        let [start, target] = [&self.start, &self.target];
        let start = S::part(&start[0], part).same_bits(p).and(S::part(&start[1], part).same_bits(i));
        let target = S::part(&target[0], part).same_bits(p).and(S::part(&target[1], part).same_bits(i));
        // The front is where the ray goes against the normal; minus 0 counts as that.
        let back = determinant.sign().same_bits(S::Part::splat(0.0)).and(S::mask_part(self.cull, part));
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
        // SAFETY: sixteen numbers of 32 bits are sixteen floats.
        unsafe {
            LaneFilters {
                start: [S::F16::load(bits[0].as_ptr().cast()), S::F16::load(bits[1].as_ptr().cast())],
                target: [S::F16::load(bits[2].as_ptr().cast()), S::F16::load(bits[3].as_ptr().cast())],
                cull: MaskOf::<S>::from_bits(cull),
            }
        }
    }
}
