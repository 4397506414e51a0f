//! Rows into columns and back, with AVX2.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "all alike: the instruction set is there (see super), and who calls a function that takes a pointer sees to it"
)]

use super::avx2::X8;
use std::arch::x86_64::*;

/// 8 rows of 8 floats into 8 columns.
///
/// # Safety
/// Instruction set: it is used below it. Each row can be read.
#[inline(always)]
pub(super) unsafe fn transpose8(rows: &[*const f32]) -> [X8; 8] {
    // SAFETY: instruction set: this is used below it. Rows can be read, as promised to this function.
    unsafe {
        let (a, b) = (_mm256_loadu_ps(rows[0]), _mm256_loadu_ps(rows[1]));
        let (c, d) = (_mm256_loadu_ps(rows[2]), _mm256_loadu_ps(rows[3]));
        let (e, f) = (_mm256_loadu_ps(rows[4]), _mm256_loadu_ps(rows[5]));
        let (g, h) = (_mm256_loadu_ps(rows[6]), _mm256_loadu_ps(rows[7]));
        let (ab0, ab1) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
        let (cd0, cd1) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
        let (ef0, ef1) = (_mm256_unpacklo_ps(e, f), _mm256_unpackhi_ps(e, f));
        let (gh0, gh1) = (_mm256_unpacklo_ps(g, h), _mm256_unpackhi_ps(g, h));
        let low = [
            _mm256_shuffle_ps::<0x44>(ab0, cd0),
            _mm256_shuffle_ps::<0xee>(ab0, cd0),
            _mm256_shuffle_ps::<0x44>(ab1, cd1),
            _mm256_shuffle_ps::<0xee>(ab1, cd1),
        ];
        let high = [
            _mm256_shuffle_ps::<0x44>(ef0, gh0),
            _mm256_shuffle_ps::<0xee>(ef0, gh0),
            _mm256_shuffle_ps::<0x44>(ef1, gh1),
            _mm256_shuffle_ps::<0xee>(ef1, gh1),
        ];
        let mut out = [X8(a); 8];
        let mut k = 0;
        while k < 4 {
            out[k] = X8(_mm256_permute2f128_ps::<0x20>(low[k], high[k]));
            out[k + 4] = X8(_mm256_permute2f128_ps::<0x31>(low[k], high[k]));
            k += 1;
        }
        out
    }
}

/// 4 columns of 8 floats into 8 rows of 4.
///
/// # Safety
/// Instruction set: it is used below it. Each row can be written.
#[inline(always)]
pub(super) unsafe fn scatter8(columns: [X8; 4], rows: &[*mut f32]) {
    let [a, b, c, d] = columns;
    // SAFETY: instruction set: this is used below it. Rows can be written, as promised to this function.
    unsafe {
        let (ab0, ab1) = (_mm256_unpacklo_ps(a.0, b.0), _mm256_unpackhi_ps(a.0, b.0));
        let (cd0, cd1) = (_mm256_unpacklo_ps(c.0, d.0), _mm256_unpackhi_ps(c.0, d.0));
        let pairs = [
            _mm256_shuffle_ps::<0x44>(ab0, cd0),
            _mm256_shuffle_ps::<0xee>(ab0, cd0),
            _mm256_shuffle_ps::<0x44>(ab1, cd1),
            _mm256_shuffle_ps::<0xee>(ab1, cd1),
        ];
        let mut k = 0;
        while k < 4 {
            _mm_storeu_ps(rows[k], _mm256_castps256_ps128(pairs[k]));
            _mm_storeu_ps(rows[k + 4], _mm256_extractf128_ps::<1>(pairs[k]));
            k += 1;
        }
    }
}

/// 2 columns of 8 floats into 8 rows of 2.
///
/// # Safety
/// Instruction set: it is used below it. Each row can be written.
#[inline(always)]
pub(super) unsafe fn scatter8_pairs(a: X8, b: X8, rows: &[*mut f32]) {
    // SAFETY: instruction set: this is used below it. Rows can be written, as promised to this function.
    unsafe {
        // Rows 0, 1, 4 and 5; the others.
        let (low, high) = (_mm256_unpacklo_ps(a.0, b.0), _mm256_unpackhi_ps(a.0, b.0));
        store_pair(_mm256_castps256_ps128(low), rows);
        store_pair(_mm256_castps256_ps128(high), &rows[2..]);
        store_pair(_mm256_extractf128_ps::<1>(low), &rows[4..]);
        store_pair(_mm256_extractf128_ps::<1>(high), &rows[6..]);
    }
}

/// The lower and the upper half of four floats into two rows of 2.
///
/// # Safety
/// Instruction set: it is used below it. The first two rows can be written.
#[inline(always)]
pub(super) unsafe fn store_pair(halves: __m128, rows: &[*mut f32]) {
    // SAFETY: instruction set: this is used below it. Rows can be written, as promised to this function.
    unsafe {
        let halves = _mm_castps_pd(halves);
        rows[0].cast::<f64>().write_unaligned(_mm_cvtsd_f64(halves));
        rows[1].cast::<f64>().write_unaligned(_mm_cvtsd_f64(_mm_unpackhi_pd(halves, halves)));
    }
}
