//! Hints about memory that will be read.

/// Tells memory that an element of an array will be read soon, if there is one. It changes no result. Several of these that do not
/// depend on each other wait together, where reads amid long computations wait one after the other.
#[inline(always)]
pub fn prefetch<T>(array: &[T], number: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(element) = array.get(number) {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let first = (element as *const T).cast::<i8>();
        // SAFETY: it reads nothing, and SSE is part of this architecture.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(first) };
        // Most elements begin in one line of the cache and may end in the next one.
        if size_of::<T>() > 4 {
            // SAFETY: it reads nothing, and SSE is part of this architecture.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(size_of::<T>() - 1)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (array, number);
}
