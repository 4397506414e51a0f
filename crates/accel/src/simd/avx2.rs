//! AVX2 and FMA: 128- and 256-bit registers.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "all alike: the instruction set is there (see super), and who calls a function that takes a pointer sees to it"
)]

use super::transpose::{scatter8, scatter8_pairs, transpose8};
use super::{Float, Kernel, Mask, Simd, compress::COMPRESS};
use std::arch::x86_64::*;

/// AVX2 and FMA.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2;

/// Lane numbers that bring the lanes with set bits to the front.
#[inline(always)]
pub(super) fn compress_order(bits: u32) -> __m256i {
    let bytes = &COMPRESS.0[bits as usize & 255];
    // SAFETY: instruction set: this is used below it. There are 8 bytes.
    unsafe { _mm256_cvtepu8_epi32(_mm_loadl_epi64(bytes.as_ptr().cast())) }
}

impl Simd for Avx2 {
    type F4 = X4;
    type F8 = X8;
    type F16 = Pair8;
    type Part = X8;
    const PART: usize = 8;
    const HAS_REGISTERS_OF_16: bool = false;
    type Order = X8Order;

    #[inline(always)]
    fn mask_part(mask: Pair8Mask, number: usize) -> X8Mask {
        if number == 0 { mask.0 } else { mask.1 }
    }

    type Rows = X8Order;

    #[inline(always)]
    fn rows(bits: u32) -> X8Order {
        // SAFETY: instruction set: this is used below it.
        X8Order(unsafe {
            let fours = _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1);
            _mm256_permutevar8x32_epi32(compress_order(bits), fours)
        })
    }

    #[inline(always)]
    fn pick(a: X8, rows: X8Order) -> X8 {
        // SAFETY: instruction set: this is used below it.
        X8(unsafe { _mm256_permutevar8x32_ps(a.0, rows.0) })
    }

    #[inline(always)]
    fn repeat(a: &[f32; 4]) -> X8 {
        // SAFETY: instruction set: this is used below it. There are four floats.
        X8(unsafe { _mm256_broadcast_ps(&*a.as_ptr().cast()) })
    }

    #[inline(always)]
    unsafe fn fours(from: [*const f32; 4]) -> X8 {
        // SAFETY: instruction set: this is used below it. They can be read, as promised to this function.
        X8(unsafe {
            let a = _mm256_castps128_ps256(_mm_loadu_ps(from[0]));
            _mm256_insertf128_ps::<1>(a, _mm_loadu_ps(from[1]))
        })
    }

    #[inline(always)]
    unsafe fn four_times(from: [*const f32; 4]) -> X8 {
        // SAFETY: instruction set: this is used below it. They can be read, as promised to this function.
        X8(unsafe {
            let a = _mm256_castps128_ps256(_mm_broadcast_ss(&*from[0]));
            _mm256_insertf128_ps::<1>(a, _mm_broadcast_ss(&*from[1]))
        })
    }

    #[inline(always)]
    fn lane_of_fours<const LANE: usize>(a: X8) -> X8 {
        // SAFETY: instruction set: this is used below it.
        X8(unsafe {
            match LANE {
                0 => _mm256_permute_ps::<0x00>(a.0),
                1 => _mm256_permute_ps::<0x55>(a.0),
                2 => _mm256_permute_ps::<0xaa>(a.0),
                _ => _mm256_permute_ps::<0xff>(a.0),
            }
        })
    }

    #[inline(always)]
    fn larger8(a: X8, b: X8) -> X8 {
        // SAFETY: instruction set: this is used below it.
        X8(unsafe {
            _mm256_castsi256_ps(_mm256_max_epi32(_mm256_castps_si256(a.0), _mm256_castps_si256(b.0)))
        })
    }

    #[inline(always)]
    fn smaller8(a: X8, b: X8) -> X8 {
        // SAFETY: instruction set: this is used below it.
        X8(unsafe {
            _mm256_castsi256_ps(_mm256_min_epi32(_mm256_castps_si256(a.0), _mm256_castps_si256(b.0)))
        })
    }

    #[inline(always)]
    fn not_above8(a: X8, b: X8) -> u32 {
        // SAFETY: instruction set: this is used below it.
        unsafe {
            let above = _mm256_cmpgt_epi32(_mm256_castps_si256(a.0), _mm256_castps_si256(b.0));
            _mm256_movemask_ps(_mm256_castsi256_ps(above)) as u32 ^ 0xff
        }
    }

    #[inline(always)]
    fn lane8(a: X8, lane: usize) -> f32 {
        // SAFETY: instruction set: this is used below it.
        unsafe {
            let lane = _mm256_castsi128_si256(_mm_cvtsi32_si128(lane as i32));
            _mm256_cvtss_f32(_mm256_permutevar8x32_ps(a.0, lane))
        }
    }

    #[inline(always)]
    fn permute8(a: X8, order: X8Order) -> X8 {
        // SAFETY: instruction set: this is used below it.
        X8(unsafe { _mm256_permutevar8x32_ps(a.0, order.0) })
    }

    #[inline(always)]
    fn order8(bits: u32) -> X8Order {
        // SAFETY: instruction set: this is used below it. The permutation reads three bits a lane only.
        X8Order(unsafe {
            _mm256_srlv_epi32(_mm256_set1_epi32(bits as i32), _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21))
        })
    }

    #[inline(always)]
    unsafe fn compress8(a: X8, bits: u32, to: *mut f32) {
        // SAFETY: instruction set: this is used below it. There is room for 8, as promised to this function.
        unsafe { _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(a.0, compress_order(bits))) }
    }

    #[inline(always)]
    unsafe fn run<K: Kernel>(kernel: K) -> K::Output {
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
        #[inline(never)]
        unsafe fn with_avx2<K: Kernel>(kernel: K) -> K::Output {
            // SAFETY: instruction set: it has been switched on here.
            unsafe { kernel.run::<Avx2>() }
        }
        // SAFETY: instruction set: the CPU has it, as promised to this function.
        unsafe { with_avx2(kernel) }
    }

    #[inline(always)]
    fn prefetch<T>(at: *const T) {
        // SAFETY: a prefetch reads nothing that the program could see.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(at.cast()) }
    }

    #[inline(always)]
    unsafe fn transpose16(rows: &[*const f32; 16]) -> [Pair8; 8] {
        // SAFETY: instruction set: this is used below it. Rows can be read, as promised to this function.
        let (a, b) = unsafe { (transpose8(&rows[..8]), transpose8(&rows[8..])) };
        let mut out = [Pair8::splat(0.0); 8];
        let mut k = 0;
        while k < 8 {
            out[k] = Pair8(a[k], b[k]);
            k += 1;
        }
        out
    }

    #[inline(always)]
    unsafe fn scatter16(columns: [Pair8; 4], rows: &[*mut f32; 16]) {
        let [a, b, c, d] = columns;
        // SAFETY: instruction set: this is used below it. Rows can be written, as promised to this function.
        unsafe {
            scatter8([a.0, b.0, c.0, d.0], &rows[..8]);
            scatter8([a.1, b.1, c.1, d.1], &rows[8..]);
        }
    }

    #[inline(always)]
    unsafe fn scatter16_pairs(columns: [Pair8; 2], rows: &[*mut f32; 16]) {
        let [a, b] = columns;
        // SAFETY: instruction set: this is used below it. Rows can be written, as promised to this function.
        unsafe {
            scatter8_pairs(a.0, b.0, &rows[..8]);
            scatter8_pairs(a.1, b.1, &rows[8..]);
        }
    }
}

/// An order of the lanes.
#[derive(Clone, Copy)]
pub(crate) struct X8Order(__m256i);

/// 4 floats.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct X4(pub(super) __m128);

/// All bits of a lane set or none.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct X4Mask(pub(super) __m128);

// SAFETY of all unsafe blocks: instruction set: this is used below it; and memory is there, as promised to `load` and `store`.
impl Float for X4 {
    type Array = [f32; 4];
    type Mask = X4Mask;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(unsafe { _mm_set1_ps(x) })
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        Self(unsafe { _mm_loadu_ps(from) })
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        unsafe { _mm_storeu_ps(to, self.0) }
    }
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(unsafe { _mm_add_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(unsafe { _mm_sub_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(unsafe { _mm_mul_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        Self(unsafe { _mm_div_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm_fmadd_ps(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn fms(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm_fmsub_ps(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Self(unsafe { _mm_min_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Self(unsafe { _mm_max_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self(unsafe { _mm_and_ps(self.0, _mm_set1_ps(-0.0)) })
    }
    #[inline(always)]
    fn xor(self, o: Self) -> Self {
        Self(unsafe { _mm_xor_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm_andnot_ps(_mm_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn le(self, o: Self) -> X4Mask {
        X4Mask(unsafe { _mm_cmp_ps::<_CMP_LE_OQ>(self.0, o.0) })
    }
    #[inline(always)]
    fn lt(self, o: Self) -> X4Mask {
        X4Mask(unsafe { _mm_cmp_ps::<_CMP_LT_OQ>(self.0, o.0) })
    }
    #[inline(always)]
    fn same_bits(self, o: Self) -> X4Mask {
        X4Mask(unsafe { _mm_castsi128_ps(_mm_cmpeq_epi32(_mm_castps_si128(self.0), _mm_castps_si128(o.0))) })
    }
    #[inline(always)]
    fn or_else(self, mask: X4Mask, o: Self) -> Self {
        Self(unsafe { _mm_blendv_ps(o.0, self.0, mask.0) })
    }
}

impl Mask for X4Mask {
    #[inline(always)]
    fn bits(self) -> u32 {
        unsafe { _mm_movemask_ps(self.0) as u32 }
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(unsafe {
            let lanes = _mm_setr_epi32(1, 2, 4, 8);
            let set = _mm_and_si128(_mm_set1_epi32(bits as i32), lanes);
            _mm_castsi128_ps(_mm_cmpeq_epi32(set, lanes))
        })
    }
    #[inline(always)]
    fn and(self, o: Self) -> Self {
        Self(unsafe { _mm_and_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn or(self, o: Self) -> Self {
        Self(unsafe { _mm_or_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn without(self, o: Self) -> Self {
        Self(unsafe { _mm_andnot_ps(o.0, self.0) })
    }
}

/// 8 floats.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct X8(pub(super) __m256);

/// All bits of a lane set or none.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct X8Mask(pub(super) __m256);

// SAFETY of all unsafe blocks: instruction set: this is used below it; and memory is there, as promised to `load` and `store`.
impl Float for X8 {
    type Array = [f32; 8];
    type Mask = X8Mask;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(unsafe { _mm256_set1_ps(x) })
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        Self(unsafe { _mm256_loadu_ps(from) })
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        unsafe { _mm256_storeu_ps(to, self.0) }
    }
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(unsafe { _mm256_add_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(unsafe { _mm256_sub_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(unsafe { _mm256_mul_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        Self(unsafe { _mm256_div_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm256_fmadd_ps(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn fms(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm256_fmsub_ps(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Self(unsafe { _mm256_min_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Self(unsafe { _mm256_max_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self(unsafe { _mm256_and_ps(self.0, _mm256_set1_ps(-0.0)) })
    }
    #[inline(always)]
    fn xor(self, o: Self) -> Self {
        Self(unsafe { _mm256_xor_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn le(self, o: Self) -> X8Mask {
        X8Mask(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, o.0) })
    }
    #[inline(always)]
    fn lt(self, o: Self) -> X8Mask {
        X8Mask(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, o.0) })
    }
    #[inline(always)]
    fn same_bits(self, o: Self) -> X8Mask {
        X8Mask(unsafe {
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_castps_si256(self.0), _mm256_castps_si256(o.0)))
        })
    }
    #[inline(always)]
    fn or_else(self, mask: X8Mask, o: Self) -> Self {
        Self(unsafe { _mm256_blendv_ps(o.0, self.0, mask.0) })
    }
    #[inline(always)]
    fn replace(&mut self, mask: X8Mask, o: Self) {
        // Volatile, or the compiler makes it one store with a mask, which takes AMD's CPUs (Zen 3) twenty times as long.
        let old = unsafe { (&raw const *self).read_volatile() };
        *self = o.or_else(mask, old);
    }
    #[inline(always)]
    fn smallest(self, mask: X8Mask) -> f32 {
        let all = self.or_else(mask, Self::splat(f32::INFINITY));
        unsafe {
            let four = _mm_min_ps(_mm256_castps256_ps128(all.0), _mm256_extractf128_ps::<1>(all.0));
            let two = _mm_min_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)))
        }
    }
    #[inline(always)]
    fn largest(self, mask: X8Mask) -> f32 {
        let all = self.or_else(mask, Self::splat(f32::NEG_INFINITY));
        unsafe {
            let four = _mm_max_ps(_mm256_castps256_ps128(all.0), _mm256_extractf128_ps::<1>(all.0));
            let two = _mm_max_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_max_ss(two, _mm_movehdup_ps(two)))
        }
    }
}

impl Mask for X8Mask {
    #[inline(always)]
    fn bits(self) -> u32 {
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(unsafe {
            let lanes = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let set = _mm256_and_si256(_mm256_set1_epi32(bits as i32), lanes);
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, lanes))
        })
    }
    #[inline(always)]
    fn and(self, o: Self) -> Self {
        Self(unsafe { _mm256_and_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn or(self, o: Self) -> Self {
        Self(unsafe { _mm256_or_ps(self.0, o.0) })
    }
    #[inline(always)]
    fn without(self, o: Self) -> Self {
        Self(unsafe { _mm256_andnot_ps(o.0, self.0) })
    }
}

/// 16 floats in two registers.
#[derive(Clone, Copy)]
#[repr(C)]
pub(crate) struct Pair8(X8, X8);

/// Its truth values.
#[derive(Clone, Copy)]
pub(crate) struct Pair8Mask(X8Mask, X8Mask);

impl Float for Pair8 {
    type Array = [f32; 16];
    type Mask = Pair8Mask;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        let half = X8::splat(x);
        Self(half, half)
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        unsafe { Self(X8::load(from), X8::load(from.add(8))) }
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        unsafe {
            self.0.store(to);
            self.1.store(to.add(8));
        }
    }
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(self.0.add(o.0), self.1.add(o.1))
    }
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(self.0.sub(o.0), self.1.sub(o.1))
    }
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(self.0.mul(o.0), self.1.mul(o.1))
    }
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        Self(self.0.div(o.0), self.1.div(o.1))
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        Self(self.0.fma(b.0, c.0), self.1.fma(b.1, c.1))
    }
    #[inline(always)]
    fn fms(self, b: Self, c: Self) -> Self {
        Self(self.0.fms(b.0, c.0), self.1.fms(b.1, c.1))
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Self(self.0.min(o.0), self.1.min(o.1))
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Self(self.0.max(o.0), self.1.max(o.1))
    }
    #[inline(always)]
    fn xor(self, o: Self) -> Self {
        Self(self.0.xor(o.0), self.1.xor(o.1))
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self(self.0.sign(), self.1.sign())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }
    #[inline(always)]
    fn le(self, o: Self) -> Pair8Mask {
        Pair8Mask(self.0.le(o.0), self.1.le(o.1))
    }
    #[inline(always)]
    fn lt(self, o: Self) -> Pair8Mask {
        Pair8Mask(self.0.lt(o.0), self.1.lt(o.1))
    }
    #[inline(always)]
    fn same_bits(self, o: Self) -> Pair8Mask {
        Pair8Mask(self.0.same_bits(o.0), self.1.same_bits(o.1))
    }
    #[inline(always)]
    fn or_else(self, mask: Pair8Mask, o: Self) -> Self {
        Self(self.0.or_else(mask.0, o.0), self.1.or_else(mask.1, o.1))
    }
    #[inline(always)]
    fn replace(&mut self, mask: Pair8Mask, o: Self) {
        self.0.replace(mask.0, o.0);
        self.1.replace(mask.1, o.1);
    }
    #[inline(always)]
    fn smallest(self, mask: Pair8Mask) -> f32 {
        let infinite = X8::splat(f32::INFINITY);
        let eight = self.0.or_else(mask.0, infinite).min(self.1.or_else(mask.1, infinite));
        eight.smallest(X8Mask::from_bits(0xff))
    }
    #[inline(always)]
    fn largest(self, mask: Pair8Mask) -> f32 {
        let infinite = X8::splat(f32::NEG_INFINITY);
        let eight = self.0.or_else(mask.0, infinite).max(self.1.or_else(mask.1, infinite));
        eight.largest(X8Mask::from_bits(0xff))
    }
}

impl Mask for Pair8Mask {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.bits() | self.1.bits() << 8
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.or(self.1).bits() != 0
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(X8Mask::from_bits(bits), X8Mask::from_bits(bits >> 8))
    }
    #[inline(always)]
    fn and(self, o: Self) -> Self {
        Self(self.0.and(o.0), self.1.and(o.1))
    }
    #[inline(always)]
    fn or(self, o: Self) -> Self {
        Self(self.0.or(o.0), self.1.or(o.1))
    }
    #[inline(always)]
    fn without(self, o: Self) -> Self {
        Self(self.0.without(o.0), self.1.without(o.1))
    }
}
