//! Queries by a [`PairView`] for rays that may start far away.

use super::deferred::DeferredCandidates;
use super::pair_tracer::{closest_hit_of_any_ray, next_hit_of_any_ray, occluded_any_ray};
use super::pairs::{PairView, StackStorage, Walk};
use super::warp::Warp;
use crate::hierarchy::Tracer;
use crate::hierarchy::search::{Any, Closest, Next, Search};
use crate::hierarchy::stack::Stack;
use crate::ray::{Hit, Ray, RayFilter};

/// Traverses a [`PairView`] from where each ray enters the box of the tree, whether it starts far away or not. A
/// [`PairTracer`](super::PairTracer) finds the same: it does so for far rays alone, in a function that has to do with the
/// registers of the kernel that calls it. Without `PLACED` the world alone.
#[derive(Clone, Copy, Debug)]
pub struct FarTracer<'a, const PLACED: bool> {
    /// The trees.
    view: PairView<'a>,
}

impl<'a, const PLACED: bool> FarTracer<'a, PLACED> {
    /// Over trees whose numbers hold together.
    ///
    /// # Safety
    /// The view is [closed](crate::hierarchy#closed-views).
    #[inline(always)]
    pub unsafe fn new(view: PairView<'a>) -> Self {
        FarTracer { view }
    }
}

impl<const PLACED: bool> FarTracer<'_, PLACED> {
    /// The search that `start` makes of the point that it has to measure from. `None` where too much was unclear.
    #[inline(always)]
    fn search<S: Search>(&self, ray: &Ray, filter: &RayFilter, start: impl Fn(f64) -> S) -> Option<S> {
        let mut storage: StackStorage = Stack::storage();
        let mut walk = Walk::<true, PLACED>::new(&self.view, ray, &mut storage);
        let mut storage = DeferredCandidates::<S>::storage();
        let mut deferred = DeferredCandidates::new(start(walk.from()), &mut storage);
        let warp = Warp::here();
        if walk.goes_along(self.view.warp_mode, warp) {
            walk.run_together(&self.view, filter, &mut deferred, warp);
        } else {
            walk.run(&self.view, filter, &mut deferred);
        }
        let is_decided = deferred.decide_deferred(&self.view.primitives, ray);
        is_decided.then_some(deferred.search)
    }
}

impl<const PLACED: bool> Tracer for FarTracer<'_, PLACED> {
    #[inline(always)]
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        match self.search(ray, filter, |from| Closest::new(ray.t_max, from)) {
            Some(found) => found.hit(&self.view.primitives, ray),
            None => {
                let copy = self.view;
                closest_hit_of_any_ray(&copy, ray, filter)
            }
        }
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        match self.search(ray, filter, |from| Any::new(ray.t_max, from)) {
            Some(found) => found.found,
            None => {
                let copy = self.view;
                occluded_any_ray(&copy, ray, filter)
            }
        }
    }

    #[inline(always)]
    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        match self.search(ray, filter, |from| Next::new(ray, after, from)) {
            Some(found) => found.hit(&self.view.primitives, ray),
            None => {
                let copy = self.view;
                next_hit_of_any_ray(&copy, ray, filter, after)
            }
        }
    }
}
