//! AVX-512: 512-bit registers for packets; the rest as for AVX2, which is as fast there.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "all alike: the instruction set is there (see super), and who calls a function that takes a pointer sees to it"
)]

use super::avx2::{Avx2, X4, X8, X8Order};
use super::transpose::store_pair;
use super::{Float, Kernel, Mask, Simd};
use std::arch::x86_64::*;

/// AVX-512 F, VL, DQ and BW.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx512;

impl Simd for Avx512 {
    type F4 = X4;
    type F8 = X8;
    type F16 = X16;
    type Part = X16;
    const PART: usize = 16;
    const HAS_REGISTERS_OF_16: bool = true;
    type Order = X8Order;

    #[inline(always)]
    fn mask_part(mask: X16Mask, _: usize) -> X16Mask {
        mask
    }

    type Rows = X16Rows;

    #[inline(always)]
    fn rows(bits: u32) -> X16Rows {
        // SAFETY: instruction set: this is used below it.
        X16Rows(unsafe {
            let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            let fours = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
            _mm512_permutexvar_epi32(fours, _mm512_maskz_compress_epi32(bits as u16, lanes))
        })
    }

    #[inline(always)]
    fn pick(a: X16, rows: X16Rows) -> X16 {
        // SAFETY: instruction set: this is used below it.
        X16(unsafe { _mm512_permutexvar_ps(rows.0, a.0) })
    }

    #[inline(always)]
    fn repeat(a: &[f32; 4]) -> X16 {
        // SAFETY: instruction set: this is used below it. There are four floats.
        X16(unsafe { _mm512_broadcast_f32x4(_mm_loadu_ps(a.as_ptr())) })
    }

    #[inline(always)]
    unsafe fn fours(from: [*const f32; 4]) -> X16 {
        // SAFETY: instruction set: this is used below it. They can be read, as promised to this function.
        X16(unsafe {
            let a = _mm512_castps128_ps512(_mm_loadu_ps(from[0]));
            let a = _mm512_insertf32x4::<1>(a, _mm_loadu_ps(from[1]));
            let a = _mm512_insertf32x4::<2>(a, _mm_loadu_ps(from[2]));
            _mm512_insertf32x4::<3>(a, _mm_loadu_ps(from[3]))
        })
    }

    #[inline(always)]
    unsafe fn four_times(from: [*const f32; 4]) -> X16 {
        // SAFETY: instruction set: this is used below it. They can be read, as promised to this function.
        X16(unsafe {
            let a = _mm512_set1_ps(*from[0]);
            let a = _mm512_mask_broadcastss_ps(a, 0x00f0, _mm_load_ss(from[1]));
            let a = _mm512_mask_broadcastss_ps(a, 0x0f00, _mm_load_ss(from[2]));
            _mm512_mask_broadcastss_ps(a, 0xf000, _mm_load_ss(from[3]))
        })
    }

    #[inline(always)]
    fn lane_of_fours<const LANE: usize>(a: X16) -> X16 {
        // SAFETY: instruction set: this is used below it.
        X16(unsafe {
            match LANE {
                0 => _mm512_permute_ps::<0x00>(a.0),
                1 => _mm512_permute_ps::<0x55>(a.0),
                2 => _mm512_permute_ps::<0xaa>(a.0),
                _ => _mm512_permute_ps::<0xff>(a.0),
            }
        })
    }

    #[inline(always)]
    fn larger8(a: X8, b: X8) -> X8 {
        Avx2::larger8(a, b)
    }

    #[inline(always)]
    fn smaller8(a: X8, b: X8) -> X8 {
        Avx2::smaller8(a, b)
    }

    #[inline(always)]
    fn not_above8(a: X8, b: X8) -> u32 {
        Avx2::not_above8(a, b)
    }

    #[inline(always)]
    fn lane8(a: X8, lane: usize) -> f32 {
        Avx2::lane8(a, lane)
    }

    #[inline(always)]
    fn permute8(a: X8, order: X8Order) -> X8 {
        Avx2::permute8(a, order)
    }

    #[inline(always)]
    fn order8(bits: u32) -> X8Order {
        Avx2::order8(bits)
    }

    #[inline(always)]
    unsafe fn compress8(a: X8, bits: u32, to: *mut f32) {
        // To a register first: compressing to memory is slow on Zen 4.
        // SAFETY: instruction set: this is used below it. There is room for 8, as promised to this function.
        unsafe { _mm256_storeu_ps(to, _mm256_maskz_compress_ps(bits as u8, a.0)) }
    }

    #[inline(always)]
    unsafe fn run<K: Kernel>(kernel: K) -> K::Output {
        #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
        #[inline(never)]
        unsafe fn with_avx512<K: Kernel>(kernel: K) -> K::Output {
            // SAFETY: instruction set: it has been switched on here.
            unsafe { kernel.run::<Avx512>() }
        }
        // SAFETY: instruction set: the CPU has it, as promised to this function.
        unsafe { with_avx512(kernel) }
    }

    #[inline(always)]
    fn prefetch<T>(at: *const T) {
        Avx2::prefetch(at)
    }

    #[inline(always)]
    unsafe fn transpose16(rows: &[*const f32; 16]) -> [X16; 8] {
        let mut pairs = [X16::splat(0.0); 8];
        let (mut low, mut high, mut out) = ([pairs[0]; 4], [pairs[0]; 4], pairs);
        // SAFETY: instruction set: this is used below it. Rows can be read, as promised to this function.
        unsafe {
            // Rows 0 and 4, 1 and 5, ... 8 and 12, ...: the last step then finds its quarters where it can take them from.
            let mut k = 0;
            while k < 8 {
                let row = k / 4 * 8 + k % 4;
                let first = _mm512_castps256_ps512(_mm256_loadu_ps(rows[row]));
                pairs[k] = X16(_mm512_insertf32x8::<1>(first, _mm256_loadu_ps(rows[row + 4])));
                k += 1;
            }
            k = 0;
            while k < 2 {
                let [a, b, c, d] =
                    [pairs[4 * k].0, pairs[4 * k + 1].0, pairs[4 * k + 2].0, pairs[4 * k + 3].0];
                let (ab0, ab1) = (_mm512_unpacklo_ps(a, b), _mm512_unpackhi_ps(a, b));
                let (cd0, cd1) = (_mm512_unpacklo_ps(c, d), _mm512_unpackhi_ps(c, d));
                let quarters = [
                    X16(_mm512_shuffle_ps::<0x44>(ab0, cd0)),
                    X16(_mm512_shuffle_ps::<0xee>(ab0, cd0)),
                    X16(_mm512_shuffle_ps::<0x44>(ab1, cd1)),
                    X16(_mm512_shuffle_ps::<0xee>(ab1, cd1)),
                ];
                if k == 0 {
                    low = quarters;
                } else {
                    high = quarters;
                }
                k += 1;
            }
            k = 0;
            while k < 4 {
                out[k] = X16(_mm512_shuffle_f32x4::<0x88>(low[k].0, high[k].0));
                out[k + 4] = X16(_mm512_shuffle_f32x4::<0xdd>(low[k].0, high[k].0));
                k += 1;
            }
        }
        out
    }

    #[inline(always)]
    unsafe fn scatter16(columns: [X16; 4], rows: &[*mut f32; 16]) {
        let [a, b, c, d] = columns;
        // SAFETY: instruction set: this is used below it. Rows can be written, as promised to this function.
        unsafe {
            let (ab0, ab1) = (_mm512_unpacklo_ps(a.0, b.0), _mm512_unpackhi_ps(a.0, b.0));
            let (cd0, cd1) = (_mm512_unpacklo_ps(c.0, d.0), _mm512_unpackhi_ps(c.0, d.0));
            // Rows k, k + 4, k + 8 and k + 12 each.
            let four_rows = [
                _mm512_shuffle_ps::<0x44>(ab0, cd0),
                _mm512_shuffle_ps::<0xee>(ab0, cd0),
                _mm512_shuffle_ps::<0x44>(ab1, cd1),
                _mm512_shuffle_ps::<0xee>(ab1, cd1),
            ];
            let mut k = 0;
            while k < 4 {
                _mm_storeu_ps(rows[k], _mm512_castps512_ps128(four_rows[k]));
                _mm_storeu_ps(rows[k + 4], _mm512_extractf32x4_ps::<1>(four_rows[k]));
                _mm_storeu_ps(rows[k + 8], _mm512_extractf32x4_ps::<2>(four_rows[k]));
                _mm_storeu_ps(rows[k + 12], _mm512_extractf32x4_ps::<3>(four_rows[k]));
                k += 1;
            }
        }
    }

    #[inline(always)]
    unsafe fn scatter16_pairs(columns: [X16; 2], rows: &[*mut f32; 16]) {
        let [a, b] = columns;
        // SAFETY: instruction set: this is used below it. Rows can be written, as promised to this function.
        unsafe {
            // Rows k and k + 1, k + 4 and k + 5, and so on.
            let pairs = [_mm512_unpacklo_ps(a.0, b.0), _mm512_unpackhi_ps(a.0, b.0)];
            let mut k = 0;
            while k < 2 {
                store_pair(_mm512_castps512_ps128(pairs[k]), &rows[2 * k..]);
                store_pair(_mm512_extractf32x4_ps::<1>(pairs[k]), &rows[2 * k + 4..]);
                store_pair(_mm512_extractf32x4_ps::<2>(pairs[k]), &rows[2 * k + 8..]);
                store_pair(_mm512_extractf32x4_ps::<3>(pairs[k]), &rows[2 * k + 12..]);
                k += 1;
            }
        }
    }
}

/// Lanes, each four times.
#[derive(Clone, Copy)]
pub(crate) struct X16Rows(__m512i);

/// 16 floats.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct X16(__m512);

/// A bit for each lane.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct X16Mask(__mmask16);

// SAFETY of all unsafe blocks: instruction set: this is used below it; and memory is there, as promised to `load` and `store`.
impl Float for X16 {
    type Array = [f32; 16];
    type Mask = X16Mask;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(unsafe { _mm512_set1_ps(x) })
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        Self(unsafe { _mm512_loadu_ps(from) })
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        unsafe { _mm512_storeu_ps(to, self.0) }
    }
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(unsafe { _mm512_add_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(unsafe { _mm512_sub_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(unsafe { _mm512_mul_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        Self(unsafe { _mm512_div_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Self(unsafe { _mm512_min_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Self(unsafe { _mm512_max_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm512_fmadd_ps(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn fms(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm512_fmsub_ps(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self(unsafe { _mm512_and_ps(self.0, _mm512_set1_ps(-0.0)) })
    }
    #[inline(always)]
    fn xor(self, o: Self) -> Self {
        Self(unsafe { _mm512_xor_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_andnot_ps(_mm512_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn le(self, o: Self) -> X16Mask {
        X16Mask(unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, o.0) })
    }
    #[inline(always)]
    fn lt(self, o: Self) -> X16Mask {
        X16Mask(unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, o.0) })
    }
    #[inline(always)]
    fn same_bits(self, o: Self) -> X16Mask {
        X16Mask(unsafe { _mm512_cmpeq_epi32_mask(_mm512_castps_si512(self.0), _mm512_castps_si512(o.0)) })
    }
    #[inline(always)]
    fn or_else(self, mask: X16Mask, o: Self) -> Self {
        Self(unsafe { _mm512_mask_blend_ps(mask.0, o.0, self.0) })
    }
    #[inline(always)]
    fn smallest(self, mask: X16Mask) -> f32 {
        unsafe { _mm512_reduce_min_ps(self.or_else(mask, Self::splat(f32::INFINITY)).0) }
    }
    #[inline(always)]
    fn largest(self, mask: X16Mask) -> f32 {
        unsafe { _mm512_reduce_max_ps(self.or_else(mask, Self::splat(f32::NEG_INFINITY)).0) }
    }
}

impl Mask for X16Mask {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0 as u32
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits as u16)
    }
    #[inline(always)]
    fn and(self, o: Self) -> Self {
        Self(self.0 & o.0)
    }
    #[inline(always)]
    fn or(self, o: Self) -> Self {
        Self(self.0 | o.0)
    }
    #[inline(always)]
    fn without(self, o: Self) -> Self {
        Self(self.0 & !o.0)
    }
}
