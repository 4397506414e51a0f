//! Walks that are functions of their own, which several kernels call, so that each of them is there once. Where walks are to be as
//! fast as they can, kernels have them to themselves.

use eosphor_core::hierarchy::Tracer;
use eosphor_core::ray::{Hit, Ray, RayFilter};

/// A tracer that has such a function.
pub(crate) trait WalkFunction: Tracer {
    /// [`Tracer::hit_after`] by it.
    fn call(&self, ray: &Ray, filter: &RayFilter, after: Option<&Hit>) -> Hit;
}

/// Answers by that function. Whether there is any hit takes a walk of its own, which one kernel has.
pub(crate) struct ByFunction<T>(pub(crate) T);

impl<T: WalkFunction> Tracer for ByFunction<T> {
    #[inline(always)]
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        self.0.call(ray, filter, None)
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        self.0.occluded(ray, filter)
    }

    #[inline(always)]
    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        self.0.call(ray, filter, Some(after))
    }
}

/// Defines the function of a tracer, by a name that can be found in the PTX.
macro_rules! walk_function {
    ($name:ident, $tracer:ty) => {
        #[unsafe(no_mangle)]
        #[inline(never)]
        fn $name(tracer: &$tracer, ray: &Ray, filter: &RayFilter, after: Option<&Hit>) -> Hit {
            tracer.hit_after(ray, filter, after)
        }

        impl WalkFunction for $tracer {
            #[inline(always)]
            fn call(&self, ray: &Ray, filter: &RayFilter, after: Option<&Hit>) -> Hit {
                $name(self, ray, filter, after)
            }
        }
    };
}

pub(crate) use walk_function;
