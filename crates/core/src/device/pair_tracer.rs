//! Queries by a [`PairView`].

use super::pairs::{Outcome, PairView, StackStorage, Walk};
use super::walks::{Walks, search_by, tracer_by_walks};
use super::warp::Warp;
use crate::hierarchy::Tracer;
use crate::hierarchy::candidates::PrimitivesView;
use crate::hierarchy::search::{Any, Closest, Next, Search};
use crate::hierarchy::stack::Stack;
use crate::ray::{Hit, Ray, RayFilter};

/// Traverses a [`PairView`]; without `PLACED` the world alone, which takes fewer registers. With `IN_STEP` the threads of a
/// warp wait for each other after every node, whatever the view says of it.
#[derive(Clone, Copy, Debug)]
pub struct PairTracer<'a, const PLACED: bool, const IN_STEP: bool = false> {
    /// The trees.
    view: PairView<'a>,
}

impl<'a, const PLACED: bool, const IN_STEP: bool> PairTracer<'a, PLACED, IN_STEP> {
    /// Over trees whose numbers hold together.
    ///
    /// # Safety
    /// The view is [closed](crate::hierarchy#closed-views).
    #[inline(always)]
    pub unsafe fn new(view: PairView<'a>) -> Self {
        PairTracer { view }
    }
}

impl<const PLACED: bool, const IN_STEP: bool> Walks for PairTracer<'_, PLACED, IN_STEP> {
    #[inline(always)]
    fn primitives(&self) -> &PrimitivesView<'_> {
        &self.view.primitives
    }

    #[inline(always)]
    fn walk(&self, ray: &Ray, filter: &RayFilter, search: &mut impl Search) -> Outcome {
        let mut storage: StackStorage = Stack::storage();
        let mut walk = Walk::<false, PLACED>::new(&self.view, ray, &mut storage);
        let warp = Warp::here();
        if IN_STEP {
            walk.run_in_step(&self.view, filter, search, warp)
        } else if walk.goes_along(self.view.warp_mode, warp) {
            walk.run_together(&self.view, filter, search, warp)
        } else {
            walk.run(&self.view, filter, search)
        }
    }
}

/// Searches for any ray, and decides at once.
#[inline(always)]
fn search_for_any_ray<S: Search>(
    view: &PairView,
    ray: &Ray,
    filter: &RayFilter,
    start: impl Fn(f64) -> S,
) -> S {
    let mut storage: StackStorage = Stack::storage();
    let mut walk = Walk::<true, true>::new(view, ray, &mut storage);
    let mut search = start(walk.from());
    walk.run(view, filter, &mut search);
    search
}

tracer_by_walks! {
    (const PLACED: bool, const IN_STEP: bool) PairTracer<'_, PLACED, IN_STEP>, PairView, search_for_any_ray,
    closest_hit_of_any_ray, occluded_any_ray, next_hit_of_any_ray
}
