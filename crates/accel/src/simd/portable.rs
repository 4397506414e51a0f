//! Arrays: for any CPU. What the compiler makes of the loops is up to the target (NEON, SSE2, plain code).

use super::{Float, Kernel, Mask, Simd};
use eosphor_core::math::{fma, max, min};

/// Any CPU.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

impl Simd for Portable {
    type F4 = Lanes<4>;
    type F8 = Lanes<8>;
    type F16 = Lanes<16>;
    type Part = Lanes<16>;
    const PART: usize = 16;
    const HAS_REGISTERS_OF_16: bool = false;
    type Order = u32;

    #[inline(always)]
    fn mask_part(mask: LaneMask<16>, _: usize) -> LaneMask<16> {
        mask
    }

    type Rows = [usize; 4];

    #[inline(always)]
    fn rows(bits: u32) -> [usize; 4] {
        let (mut left, mut rows) = (bits, [0; 4]);
        for row in &mut rows {
            *row = left.trailing_zeros() as usize & 15;
            left &= left.wrapping_sub(1);
        }
        rows
    }

    #[inline(always)]
    fn pick(a: Lanes<16>, rows: [usize; 4]) -> Lanes<16> {
        let mut out = [0.0; 16];
        for (k, o) in out.iter_mut().enumerate() {
            *o = a.0[rows[k / 4]];
        }
        Lanes(out)
    }

    #[inline(always)]
    fn repeat(a: &[f32; 4]) -> Lanes<16> {
        let mut out = [0.0; 16];
        for (k, o) in out.iter_mut().enumerate() {
            *o = a[k % 4];
        }
        Lanes(out)
    }

    #[inline(always)]
    unsafe fn fours(from: [*const f32; 4]) -> Lanes<16> {
        let mut out = [0.0; 16];
        for (k, o) in out.iter_mut().enumerate() {
            // SAFETY: four floats can be read from each, as promised to this function.
            *o = unsafe { from[k / 4].add(k % 4).read() };
        }
        Lanes(out)
    }

    #[inline(always)]
    unsafe fn four_times(from: [*const f32; 4]) -> Lanes<16> {
        let mut out = [0.0; 16];
        for (k, o) in out.iter_mut().enumerate() {
            // SAFETY: they can be read, as promised to this function.
            *o = unsafe { from[k / 4].read() };
        }
        Lanes(out)
    }

    #[inline(always)]
    fn lane_of_fours<const LANE: usize>(a: Lanes<16>) -> Lanes<16> {
        let mut out = [0.0; 16];
        for (k, o) in out.iter_mut().enumerate() {
            *o = a.0[k / 4 * 4 + LANE];
        }
        Lanes(out)
    }

    #[inline(always)]
    fn larger8(a: Lanes<8>, b: Lanes<8>) -> Lanes<8> {
        a.max(b)
    }

    #[inline(always)]
    fn smaller8(a: Lanes<8>, b: Lanes<8>) -> Lanes<8> {
        a.min(b)
    }

    #[inline(always)]
    fn not_above8(a: Lanes<8>, b: Lanes<8>) -> u32 {
        a.le(b).bits()
    }

    #[inline(always)]
    fn lane8(a: Lanes<8>, lane: usize) -> f32 {
        a.0[lane & 7]
    }

    #[inline(always)]
    fn permute8(a: Lanes<8>, order: u32) -> Lanes<8> {
        let mut out = [0.0; 8];
        for (k, o) in out.iter_mut().enumerate() {
            *o = a.0[(order >> (3 * k) & 7) as usize];
        }
        Lanes(out)
    }

    #[inline(always)]
    fn order8(bits: u32) -> u32 {
        bits
    }

    #[inline(always)]
    unsafe fn compress8(a: Lanes<8>, bits: u32, to: *mut f32) {
        let (mut left, mut k) = (bits, 0);
        while left != 0 {
            // SAFETY: lanes: `k` is below 8, and there is room for 8, as promised to this function.
            unsafe { to.add(k).write(a.0[left.trailing_zeros() as usize & 7]) };
            left &= left - 1;
            k += 1;
        }
    }

    #[inline(always)]
    unsafe fn run<K: Kernel>(kernel: K) -> K::Output {
        #[inline(never)]
        unsafe fn with_portable<K: Kernel>(kernel: K) -> K::Output {
            // SAFETY: instruction set: none is needed.
            unsafe { kernel.run::<Portable>() }
        }
        // SAFETY: instruction set: none is needed.
        unsafe { with_portable(kernel) }
    }

    #[inline(always)]
    fn prefetch<T>(_: *const T) {}

    #[inline(always)]
    unsafe fn transpose16(rows: &[*const f32; 16]) -> [Lanes<16>; 8] {
        let mut out = [Lanes([0.0; 16]); 8];
        for (lane, row) in rows.iter().enumerate() {
            for (k, column) in out.iter_mut().enumerate() {
                // SAFETY: rows have 8 floats, as promised to this function.
                column.0[lane] = unsafe { row.add(k).read() };
            }
        }
        out
    }

    #[inline(always)]
    unsafe fn scatter16(columns: [Lanes<16>; 4], rows: &[*mut f32; 16]) {
        for (lane, row) in rows.iter().enumerate() {
            for (k, column) in columns.iter().enumerate() {
                // SAFETY: rows have 4 floats, as promised to this function.
                unsafe { row.add(k).write(column.0[lane]) };
            }
        }
    }

    #[inline(always)]
    unsafe fn scatter16_pairs(columns: [Lanes<16>; 2], rows: &[*mut f32; 16]) {
        for (lane, row) in rows.iter().enumerate() {
            for (k, column) in columns.iter().enumerate() {
                // SAFETY: rows have 2 floats, as promised to this function.
                unsafe { row.add(k).write(column.0[lane]) };
            }
        }
    }
}

/// Floats in an array.
#[derive(Clone, Copy)]
#[repr(align(16))]
pub(crate) struct Lanes<const N: usize>([f32; N]);

/// All bits set or none.
#[derive(Clone, Copy)]
#[repr(align(16))]
pub(crate) struct LaneMask<const N: usize>([u32; N]);

impl<const N: usize> Lanes<N> {
    #[inline(always)]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        let mut out = self;
        for x in &mut out.0 {
            *x = f(*x);
        }
        out
    }

    #[inline(always)]
    fn zip(self, o: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut out = self;
        for k in 0..N {
            out.0[k] = f(self.0[k], o.0[k]);
        }
        out
    }

    #[inline(always)]
    fn test(self, o: Self, f: impl Fn(f32, f32) -> bool) -> LaneMask<N> {
        let mut out = LaneMask([0; N]);
        for k in 0..N {
            out.0[k] = if f(self.0[k], o.0[k]) { u32::MAX } else { 0 };
        }
        out
    }
}

impl<const N: usize> Float for Lanes<N>
where
    [f32; N]: AsRef<[f32]> + AsMut<[f32]>,
{
    type Array = [f32; N];
    type Mask = LaneMask<N>;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Lanes([x; N])
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        // SAFETY: lanes: there are as many floats, as promised to this function.
        Lanes(unsafe { from.cast::<[f32; N]>().read_unaligned() })
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        // SAFETY: lanes: there is room for as many floats, as promised to this function.
        unsafe { to.cast::<[f32; N]>().write_unaligned(self.0) };
    }
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.zip(o, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self.zip(o, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.zip(o, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        self.zip(o, |a, b| a / b)
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        let mut out = self;
        for k in 0..N {
            out.0[k] = fma(self.0[k], b.0[k], c.0[k]);
        }
        out
    }
    #[inline(always)]
    fn fms(self, b: Self, c: Self) -> Self {
        let mut out = self;
        for k in 0..N {
            out.0[k] = fma(self.0[k], b.0[k], -c.0[k]);
        }
        out
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        self.zip(o, min)
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        self.zip(o, max)
    }
    #[inline(always)]
    fn sign(self) -> Self {
        self.map(|x| f32::from_bits(x.to_bits() & 0x8000_0000))
    }
    #[inline(always)]
    fn xor(self, o: Self) -> Self {
        self.zip(o, |a, b| f32::from_bits(a.to_bits() ^ b.to_bits()))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f32::abs)
    }
    #[inline(always)]
    fn le(self, o: Self) -> LaneMask<N> {
        self.test(o, |a, b| a <= b)
    }
    #[inline(always)]
    fn lt(self, o: Self) -> LaneMask<N> {
        self.test(o, |a, b| a < b)
    }
    #[inline(always)]
    fn same_bits(self, o: Self) -> LaneMask<N> {
        self.test(o, |a, b| a.to_bits() == b.to_bits())
    }
    #[inline(always)]
    fn or_else(self, mask: LaneMask<N>, o: Self) -> Self {
        let mut out = self;
        for k in 0..N {
            out.0[k] = if mask.0[k] != 0 { self.0[k] } else { o.0[k] };
        }
        out
    }
}

impl<const N: usize> LaneMask<N> {
    #[inline(always)]
    fn zip(self, o: Self, f: impl Fn(u32, u32) -> u32) -> Self {
        let mut out = self;
        for k in 0..N {
            out.0[k] = f(self.0[k], o.0[k]);
        }
        out
    }
}

impl<const N: usize> Mask for LaneMask<N> {
    #[inline(always)]
    fn bits(self) -> u32 {
        let mut bits = 0;
        for k in 0..N {
            bits |= (self.0[k] & 1) << k;
        }
        bits
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        let mut out = LaneMask([0; N]);
        for k in 0..N {
            out.0[k] = 0u32.wrapping_sub(bits >> k & 1);
        }
        out
    }
    #[inline(always)]
    fn and(self, o: Self) -> Self {
        self.zip(o, |a, b| a & b)
    }
    #[inline(always)]
    fn or(self, o: Self) -> Self {
        self.zip(o, |a, b| a | b)
    }
    #[inline(always)]
    fn without(self, o: Self) -> Self {
        self.zip(o, |a, b| a & !b)
    }
}
