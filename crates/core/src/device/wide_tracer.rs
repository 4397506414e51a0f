//! Queries by a [`WideView`].

use super::pairs::Outcome;
use super::walks::{Walks, search_by, tracer_by_walks};
use super::warp::Warp;
use super::wide::{StackStorage, Walk, WideView};
use crate::hierarchy::Tracer;
use crate::hierarchy::candidates::PrimitivesView;
use crate::hierarchy::search::{Any, Closest, Next, Search};
use crate::hierarchy::stack::Stack;
use crate::ray::{Hit, Ray, RayFilter};

/// Traverses a [`WideView`], the threads of a warp in step; without `PLACED` the world alone, which takes fewer registers.
#[derive(Clone, Copy, Debug)]
pub struct WideTracer<'a, const PLACED: bool> {
    /// The trees.
    view: WideView<'a>,
}

impl<'a, const PLACED: bool> WideTracer<'a, PLACED> {
    /// Over trees whose numbers hold together.
    ///
    /// # Safety
    /// The view is [closed](crate::hierarchy#closed-views).
    #[inline(always)]
    pub unsafe fn new(view: WideView<'a>) -> Self {
        WideTracer { view }
    }
}

impl<const PLACED: bool> Walks for WideTracer<'_, PLACED> {
    #[inline(always)]
    fn primitives(&self) -> &PrimitivesView<'_> {
        &self.view.primitives
    }

    #[inline(always)]
    fn walk(&self, ray: &Ray, filter: &RayFilter, search: &mut impl Search) -> Outcome {
        let mut storage: StackStorage = Stack::storage();
        let mut walk = Walk::<false, PLACED>::new(&self.view, ray, &mut storage);
        walk.run::<true>(&self.view, filter, search, Warp::here())
    }
}

/// Searches for any ray, and decides at once.
#[inline(always)]
fn search_for_any_ray<S: Search>(
    view: &WideView,
    ray: &Ray,
    filter: &RayFilter,
    start: impl Fn(f64) -> S,
) -> S {
    let mut storage: StackStorage = Stack::storage();
    let mut search = start(0.0);
    Walk::<true, true>::new(view, ray, &mut storage).run::<false>(view, filter, &mut search, Warp::here());
    search
}

tracer_by_walks! {
    (const PLACED: bool) WideTracer<'_, PLACED>, WideView, search_for_any_ray,
    closest_hit_of_any_ray_wide, occluded_any_ray_wide, next_hit_of_any_ray_wide
}
