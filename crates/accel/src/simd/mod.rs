//! Vectors of 4, 8 and 16 floats for each instruction set, in the few operations that traversals need.
//!
//! Every operation is one IEEE operation a lane, the same on all sets, so that code over [`Simd`] gives the same bits
//! on each. The types of an instruction set must only be used in functions below one that has it switched on by
//! `#[target_feature]` (all are `inline(always)` and end up in it); [`crate::SimdLevel::is_available`] is asked once, where
//! a tracer is made.

#[cfg(all(target_arch = "x86_64", any(feature = "avx2", feature = "avx512")))]
mod avx2;
#[cfg(all(target_arch = "x86_64", feature = "avx512"))]
mod avx512;
#[cfg(all(target_arch = "x86_64", any(feature = "avx2", feature = "avx512")))]
mod compress;
mod portable;
#[cfg(all(target_arch = "x86_64", any(feature = "avx2", feature = "avx512")))]
mod transpose;

#[cfg(all(target_arch = "x86_64", feature = "avx2"))]
pub(crate) use avx2::Avx2;
#[cfg(all(target_arch = "x86_64", feature = "avx512"))]
pub(crate) use avx512::Avx512;
pub(crate) use portable::Portable;

/// An instruction set.
pub(crate) trait Simd: Copy {
    /// 4 floats.
    type F4: Float<Array = [f32; 4]>;
    /// 8 floats.
    type F8: Float<Array = [f32; 8]>;
    /// 16 floats.
    type F16: Float<Array = [f32; 16]>;
    /// The part of 16 floats that is processed at a time where all 16 would take too many registers.
    type Part: Float;
    /// Of how many floats.
    const PART: usize;
    /// Whether 16 floats are one register.
    const HAS_REGISTERS_OF_16: bool;

    /// A part of 16 lanes.
    #[inline(always)]
    fn part(a: &Self::F16, number: usize) -> Self::Part {
        debug_assert!(number < 16 / Self::PART);
        // SAFETY: lanes: 16 floats are so many parts, one after the other.
        unsafe { *(&raw const *a).cast::<Self::Part>().add(number) }
    }
    /// The same, to be changed.
    #[inline(always)]
    fn part_mut(a: &mut Self::F16, number: usize) -> &mut Self::Part {
        debug_assert!(number < 16 / Self::PART);
        // SAFETY: lanes: 16 floats are so many parts, one after the other.
        unsafe { &mut *(&raw mut *a).cast::<Self::Part>().add(number) }
    }
    /// A part of a mask of 16 lanes.
    fn mask_part(mask: <Self::F16 as Float>::Mask, number: usize) -> <Self::Part as Float>::Mask;

    /// The larger of two numbers, by their bits as whole numbers with a sign. None is NaN. Where both are below 0, it may be the
    /// other one.
    fn larger8(a: Self::F8, b: Self::F8) -> Self::F8;
    /// The smaller one, likewise.
    fn smaller8(a: Self::F8, b: Self::F8) -> Self::F8;
    /// Bits of the lanes where `a` is no more than `b`, likewise.
    fn not_above8(a: Self::F8, b: Self::F8) -> u32;
    /// Lanes of a part, each four times: as many as there is room for.
    type Rows: Copy;
    /// The first of the lanes whose bits are set. After the last of them comes any lane.
    fn rows(bits: u32) -> Self::Rows;
    /// Items of `a` by these lanes.
    fn pick(a: Self::Part, rows: Self::Rows) -> Self::Part;
    /// The same four floats over and over.
    fn repeat(a: &[f32; 4]) -> Self::Part;
    /// Four floats from each of these places: of as many as a part has room for, the first ones.
    ///
    /// # Safety
    /// They can be read.
    unsafe fn fours(from: [*const f32; 4]) -> Self::Part;
    /// The number at each of these places, four times: of as many as a part has room for, the first ones.
    ///
    /// # Safety
    /// They can be read.
    unsafe fn four_times(from: [*const f32; 4]) -> Self::Part;
    /// Of each four lanes this one, in all four.
    fn lane_of_fours<const LANE: usize>(a: Self::Part) -> Self::Part;
    /// The number in a lane, below 8: sooner than from memory, where it would have to be written at once.
    fn lane8(a: Self::F8, lane: usize) -> f32;
    /// Items of `a` by the lanes of `order`, three bits each from the lowest.
    fn permute8(a: Self::F8, order: Order8<Self>) -> Self::F8;
    /// From three bits a lane.
    fn order8(bits: u32) -> Order8<Self>;
    /// The order's own opaque form.
    type Order: Copy;
    /// Writes the lanes of `a` whose bits are set one after the other; what follows them, up to 8 lanes, is garbage.
    ///
    /// # Safety
    /// There is room for 8 floats.
    unsafe fn compress8(a: Self::F8, bits: u32, to: *mut f32);
    /// Says that this place will be read soon; it may be anywhere.
    fn prefetch<T>(at: *const T);
    /// Runs a kernel in a function of its own that has the instruction set switched on.
    ///
    /// # Safety
    /// The CPU has the instruction set.
    unsafe fn run<K: Kernel>(kernel: K) -> K::Output;
    /// Turns 16 rows of 8 floats into 8 vectors.
    ///
    /// # Safety
    /// Each row can be read.
    unsafe fn transpose16(rows: &[*const f32; 16]) -> [Self::F16; 8];
    /// The other way round: writes 4 vectors as 16 rows of 4 floats.
    ///
    /// # Safety
    /// Each row can be written.
    unsafe fn scatter16(columns: [Self::F16; 4], rows: &[*mut f32; 16]);
    /// Writes 2 vectors as 16 rows of 2 floats.
    ///
    /// # Safety
    /// Each row can be written.
    unsafe fn scatter16_pairs(columns: [Self::F16; 2], rows: &[*mut f32; 16]);
}

/// Code for any instruction set.
pub(crate) trait Kernel {
    /// What it gives.
    type Output;
    /// Does the work. To be `inline(always)`.
    ///
    /// # Safety
    /// The CPU has the instruction set.
    unsafe fn run<S: Simd>(self) -> Self::Output;
}

/// Runs a kernel at a level that is available.
///
/// # Safety
/// Instruction set: the CPU has the level.
#[inline(always)]
pub(crate) unsafe fn run_at<K: Kernel>(level: crate::SimdLevel, kernel: K) -> K::Output {
    // For development: RUSTFLAGS="--cfg only_avx2" (or only_avx512) compiles the kernels once, in a third of the time.
    // SAFETY: instruction set: who develops so has such a CPU.
    #[cfg(only_avx2)]
    return unsafe { Avx2::run(kernel) };
    // SAFETY: instruction set: who develops so has such a CPU.
    #[cfg(only_avx512)]
    return unsafe { Avx512::run(kernel) };
    #[cfg(not(any(only_avx2, only_avx512)))]
    {
        #[cfg(all(target_arch = "x86_64", feature = "avx512"))]
        if level == crate::SimdLevel::Avx512 {
            // SAFETY: instruction set: promised to this function.
            return unsafe { Avx512::run(kernel) };
        }
        #[cfg(all(target_arch = "x86_64", feature = "avx2"))]
        if level == crate::SimdLevel::Avx2 {
            // SAFETY: instruction set: promised to this function.
            return unsafe { Avx2::run(kernel) };
        }
        let _ = level;
        // SAFETY: instruction set: none is needed.
        unsafe { Portable::run(kernel) }
    }
}

/// An order of 8 lanes.
pub(crate) type Order8<S> = <S as Simd>::Order;

/// Lanes of floats.
pub(crate) trait Float: Copy {
    /// As many floats.
    type Array: Copy + AsRef<[f32]> + AsMut<[f32]>;
    /// A truth value for each lane.
    type Mask: Mask;

    /// The same in every lane.
    fn splat(x: f32) -> Self;
    /// # Safety
    /// There are as many floats as lanes.
    unsafe fn load(from: *const f32) -> Self;
    /// # Safety
    /// There is room for as many floats as lanes.
    unsafe fn store(self, to: *mut f32);
    fn add(self, o: Self) -> Self;
    fn sub(self, o: Self) -> Self;
    fn mul(self, o: Self) -> Self;
    fn div(self, o: Self) -> Self;
    /// `self * b + c`, rounded once.
    fn fma(self, b: Self, c: Self) -> Self;
    /// `self * b - c`, rounded once.
    fn fms(self, b: Self, c: Self) -> Self;
    /// `self < o ? self : o`.
    fn min(self, o: Self) -> Self;
    /// `self > o ? self : o`.
    fn max(self, o: Self) -> Self;
    /// The bits of the sign.
    fn sign(self) -> Self;
    /// Bits that differ.
    fn xor(self, o: Self) -> Self;
    /// Without the sign.
    fn abs(self) -> Self;
    fn le(self, o: Self) -> Self::Mask;
    fn lt(self, o: Self) -> Self::Mask;
    /// Whether the bits are equal.
    fn same_bits(self, o: Self) -> Self::Mask;
    /// `self` where the mask is set, else `o`.
    fn or_else(self, mask: Self::Mask, o: Self) -> Self;

    /// The same in place: where the mask is set, by `o`.
    #[inline(always)]
    fn replace(&mut self, mask: Self::Mask, o: Self) {
        *self = o.or_else(mask, *self);
    }
    /// Through memory, for what is rare.
    #[inline(always)]
    fn to_array(self) -> Self::Array {
        let mut array = core::mem::MaybeUninit::<Self::Array>::uninit();
        // SAFETY: lanes: an array has as many floats as lanes.
        unsafe {
            self.store(array.as_mut_ptr().cast());
            array.assume_init()
        }
    }
    #[inline(always)]
    fn from_array(array: &Self::Array) -> Self {
        // SAFETY: lanes: an array has as many floats as lanes.
        unsafe { Self::load(array.as_ref().as_ptr()) }
    }
    /// With the sign of `self`, the other way round.
    #[inline(always)]
    fn negate(self) -> Self {
        self.xor(Self::splat(-0.0))
    }
    /// The smallest of the lanes in the mask; infinity where there are none.
    #[inline(always)]
    fn smallest(self, mask: Self::Mask) -> f32 {
        let all = self.or_else(mask, Self::splat(f32::INFINITY)).to_array();
        all.as_ref().iter().fold(f32::INFINITY, |a, &b| if b < a { b } else { a })
    }
    /// The largest of the lanes in the mask; minus infinity where there are none.
    #[inline(always)]
    fn largest(self, mask: Self::Mask) -> f32 {
        let all = self.or_else(mask, Self::splat(f32::NEG_INFINITY)).to_array();
        all.as_ref().iter().fold(f32::NEG_INFINITY, |a, &b| if b > a { b } else { a })
    }
}

/// A truth value for each lane.
pub(crate) trait Mask: Copy {
    /// Lane 0 is the lowest bit.
    fn bits(self) -> u32;
    fn from_bits(bits: u32) -> Self;
    fn and(self, o: Self) -> Self;
    fn or(self, o: Self) -> Self;
    /// `self` without `o`.
    fn without(self, o: Self) -> Self;
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
}

/// An array of three expressions, one for each axis. (Closures would not do: they cannot be made to be inlined, and what
/// is not inlined is compiled without the instruction set of its caller.)
macro_rules! each {
    ($k:ident => $expression:expr) => {
        [
            {
                let $k = 0usize;
                $expression
            },
            {
                let $k = 1usize;
                $expression
            },
            {
                let $k = 2usize;
                $expression
            },
        ]
    };
}
pub(crate) use each;

/// Three floats a lane.
pub(crate) type Vec3V<F> = [F; 3];

/// As [`eosphor_core::math::Vec3::dot`].
#[inline(always)]
pub(crate) fn dot<F: Float>(a: &Vec3V<F>, b: &Vec3V<F>) -> F {
    a[2].fma(b[2], a[1].fma(b[1], a[0].mul(b[0])))
}

/// As [`eosphor_core::math::Vec3::cross`].
#[inline(always)]
pub(crate) fn cross<F: Float>(a: &Vec3V<F>, b: &Vec3V<F>) -> Vec3V<F> {
    [a[1].fms(b[2], a[2].mul(b[1])), a[2].fms(b[0], a[0].mul(b[2])), a[0].fms(b[1], a[1].mul(b[0]))]
}

#[inline(always)]
pub(crate) fn subtract<F: Float>(a: &Vec3V<F>, b: &Vec3V<F>) -> Vec3V<F> {
    [a[0].sub(b[0]), a[1].sub(b[1]), a[2].sub(b[2])]
}

#[inline(always)]
pub(crate) fn splat3<F: Float>(v: eosphor_core::math::Vec3) -> Vec3V<F> {
    [F::splat(v.x), F::splat(v.y), F::splat(v.z)]
}
