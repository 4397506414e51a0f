//! Queries by walks that put off what is unclear, for GPUs.

use super::deferred::DeferredCandidates;
use super::pairs::Outcome;
use crate::hierarchy::candidates::PrimitivesView;
use crate::hierarchy::search::Search;
use crate::ray::{Ray, RayFilter};

/// Walks through a hierarchy.
pub(super) trait Walks {
    /// What is in its leaves.
    fn primitives(&self) -> &PrimitivesView<'_>;
    /// For most rays.
    fn walk(&self, ray: &Ray, filter: &RayFilter, search: &mut impl Search) -> Outcome;
}

/// Searches for most rays. `None` if this one needs a walk for any ray.
#[inline(always)]
pub(super) fn search_by<S: Search>(
    walks: &impl Walks,
    ray: &Ray,
    filter: &RayFilter,
    search: S,
) -> Option<S> {
    let mut storage = DeferredCandidates::<S>::storage();
    let mut deferred = DeferredCandidates::new(search, &mut storage);
    if walks.walk(ray, filter, &mut deferred) == Outcome::Far {
        return None;
    }
    if deferred.decide_deferred(walks.primitives(), ray) { Some(deferred.search) } else { None }
}

/// Makes a tracer with a field `view: $view` answer queries by [`Walks`], and, where that is not for a ray, by a search that
/// `$search_for_any_ray(&view, &ray, &filter, start)` makes, from what `start(from)` gives: rare, so these are functions of their
/// own on GPUs.
macro_rules! tracer_by_walks {
    (
        ($($generics:tt)*) $tracer:ty, $view:ident, $search_for_any_ray:ident,
        $closest:ident, $occluded:ident, $next:ident
    ) => {
        $crate::out_of_line::out_of_line_on_gpus! {
            pub(super) fn $closest(view: &$view, ray: &Ray, filter: &RayFilter) -> Hit {
                let found = $search_for_any_ray(view, ray, filter, |from| Closest::new(ray.t_max, from));
                found.hit(&view.primitives, ray)
            }
        }

        $crate::out_of_line::out_of_line_on_gpus! {
            pub(super) fn $occluded(view: &$view, ray: &Ray, filter: &RayFilter) -> bool {
                $search_for_any_ray(view, ray, filter, |from| Any::new(ray.t_max, from)).found
            }
        }

        $crate::out_of_line::out_of_line_on_gpus! {
            pub(super) fn $next(view: &$view, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
                let found = $search_for_any_ray(view, ray, filter, |from| Next::new(ray, after, from));
                found.hit(&view.primitives, ray)
            }
        }

        impl<$($generics)*> Tracer for $tracer {
            #[inline(always)]
            fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
                match search_by(self, ray, filter, Closest::new(ray.t_max, 0.0)) {
                    Some(found) => found.hit(&self.view.primitives, ray),
                    None => {
                        let copy = self.view;
                        $closest(&copy, ray, filter)
                    }
                }
            }

            #[inline(always)]
            fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
                match search_by(self, ray, filter, Any::new(ray.t_max, 0.0)) {
                    Some(found) => found.found,
                    None => {
                        let copy = self.view;
                        $occluded(&copy, ray, filter)
                    }
                }
            }

            #[inline(always)]
            fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
                match search_by(self, ray, filter, Next::new(ray, after, 0.0)) {
                    Some(found) => found.hit(&self.view.primitives, ray),
                    None => {
                        let copy = self.view;
                        $next(&copy, ray, filter, after)
                    }
                }
            }
        }
    };
}

pub(super) use tracer_by_walks;
