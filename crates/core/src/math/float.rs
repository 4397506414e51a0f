//! The only place where arithmetic is written differently for CPU and GPU.
//!
//! `+ - * /` and square root are correctly rounded on every target, so they may be used anywhere. A fused
//! multiply-add is always asked for by name ([`fma`]): compilers never fuse by themselves here. `min` and `max`
//! are written as comparisons so that one x86 instruction does them; they differ between targets only for NaN
//! and the sign of zero, which must never reach a pixel (../../../../ARCHITECTURE.md, "The picture contract").

#[cfg(target_arch = "nvptx64")]
#[allow(missing_docs, reason = "documented at their CPU twins below")]
mod target {
    use core::f32::math;
    #[inline(always)]
    pub fn fma(a: f32, b: f32, c: f32) -> f32 {
        math::mul_add(a, b, c)
    }
    #[inline(always)]
    pub fn sqrt(x: f32) -> f32 {
        math::sqrt(x)
    }
    #[inline(always)]
    pub fn floor(x: f32) -> f32 {
        math::floor(x)
    }
    #[inline(always)]
    pub fn fma64(a: f64, b: f64, c: f64) -> f64 {
        core::f64::math::mul_add(a, b, c)
    }
    #[inline(always)]
    pub fn sqrt64(x: f64) -> f64 {
        core::f64::math::sqrt(x)
    }
    #[inline(always)]
    pub fn floor64(x: f64) -> f64 {
        core::f64::math::floor(x)
    }
    #[inline(always)]
    pub fn min(a: f32, b: f32) -> f32 {
        a.min(b)
    }
    #[inline(always)]
    pub fn max(a: f32, b: f32) -> f32 {
        a.max(b)
    }
}

#[cfg(not(target_arch = "nvptx64"))]
mod target {
    /// `a * b + c`, rounded once. One instruction under AVX2+FMA, a slow but equal library call without.
    #[inline(always)]
    pub fn fma(a: f32, b: f32, c: f32) -> f32 {
        a.mul_add(b, c)
    }
    /// Square root, correctly rounded; NaN for negative numbers.
    #[inline(always)]
    pub fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }
    /// The largest whole number not above `x`.
    #[inline(always)]
    pub fn floor(x: f32) -> f32 {
        x.floor()
    }
    /// `a * b + c` in double precision, rounded once.
    #[inline(always)]
    pub fn fma64(a: f64, b: f64, c: f64) -> f64 {
        a.mul_add(b, c)
    }
    /// Square root in double precision, correctly rounded.
    #[inline(always)]
    pub fn sqrt64(x: f64) -> f64 {
        x.sqrt()
    }
    /// The largest whole number not above `x`, in double precision.
    #[inline(always)]
    pub fn floor64(x: f64) -> f64 {
        x.floor()
    }
    /// The smaller of two numbers; `b` when either is NaN.
    #[inline(always)]
    pub fn min(a: f32, b: f32) -> f32 {
        if a < b { a } else { b }
    }
    /// The larger of two numbers; `b` when either is NaN.
    #[inline(always)]
    pub fn max(a: f32, b: f32) -> f32 {
        if a > b { a } else { b }
    }
}

pub use target::*;

/// `a * b - c * d` with one product kept exact, as hand-written GPU code does it.
#[inline(always)]
pub fn difference_of_products(a: f32, b: f32, c: f32, d: f32) -> f32 {
    fma(a, b, -(c * d))
}

/// `x` limited to `[low, high]`; `low` when `x` is NaN.
#[inline(always)]
pub fn clamp(x: f32, low: f32, high: f32) -> f32 {
    min(if x > low { x } else { low }, high)
}
