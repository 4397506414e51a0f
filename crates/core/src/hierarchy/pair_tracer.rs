//! Queries by a [`PairView`].

use super::Tracer;
use super::pairs::{Outcome, PairView, Room, Walk};
use super::put_off::PutOff;
use super::search::{Any, Closest, Next, Search};
use super::stack::Stack;
use super::warp::Warp;
use crate::ray::{Hit, Ray, RayFilter};

/// Traverses a [`PairView`]; without `PLACED` the world alone, which takes fewer registers.
#[derive(Clone, Copy, Debug)]
pub struct PairTracer<'a, const PLACED: bool> {
    /// The trees.
    pub view: PairView<'a>,
}

impl<const PLACED: bool> PairTracer<'_, PLACED> {
    /// Searches for most rays. `false` if this one needs [`PairTracer::search_from_anywhere`].
    #[inline(always)]
    fn search<S: Search>(&self, ray: &Ray, filter: &RayFilter, search: S) -> Option<S> {
        let mut room: Room = Stack::room();
        let mut aside = PutOff::<S>::room();
        let mut put_off = PutOff::new(search, &mut aside);
        let mut walk = Walk::<false, PLACED>::new(&self.view, ray, &mut room);
        let warp = Warp::here();
        let outcome = if walk.goes_along(self.view.company, warp) {
            walk.run_together(&self.view, filter, &mut put_off, warp)
        } else {
            walk.run(&self.view, filter, &mut put_off)
        };
        if outcome == Outcome::Far {
            return None;
        }
        if put_off.decide(&self.view.primitives, ray) { Some(put_off.search) } else { None }
    }
}

/// Searches for any ray, and decides at once.
#[inline(always)]
fn search_for_any_ray(view: &PairView, ray: &Ray, filter: &RayFilter, search: &mut impl Search) {
    let mut room: Room = Stack::room();
    Walk::<true, true>::new(view, ray, &mut room).run(view, filter, search);
}

macro_rules! for_any_ray {
    ($name:ident($($after:ident: $type:ty)?) -> $answer:ty { $search:expr, |$found:ident, $view:ident, $ray:ident| $result:expr }) => {
        /// For rays that [`PairTracer::search`] is not for: rare, so it is a function of its own on GPUs.
        #[cfg_attr(target_arch = "nvptx64", inline(never), unsafe(no_mangle))]
        #[cfg_attr(not(target_arch = "nvptx64"), inline(always))]
        fn $name($view: &PairView, $ray: &Ray, filter: &RayFilter $(, $after: $type)?) -> $answer {
            let mut $found = $search;
            search_for_any_ray($view, $ray, filter, &mut $found);
            $result
        }
    };
}

for_any_ray! { closest_hit_of_any_ray() -> Hit {
    Closest::new(ray.t_max), |found, view, ray| found.hit(&view.primitives, ray)
} }
for_any_ray! { occluded_any_ray() -> bool {
    Any { t_max: ray.t_max, found: false }, |found, view, ray| found.found
} }
for_any_ray! { next_hit_of_any_ray(after: &Hit) -> Hit {
    Next::new(ray.t_max, after), |found, view, ray| found.hit(&view.primitives, ray)
} }

impl<const PLACED: bool> Tracer for PairTracer<'_, PLACED> {
    #[inline(always)]
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        match self.search(ray, filter, Closest::new(ray.t_max)) {
            Some(found) => found.hit(&self.view.primitives, ray),
            None => {
                let copy = self.view;
                closest_hit_of_any_ray(&copy, ray, filter)
            }
        }
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        match self.search(ray, filter, Any { t_max: ray.t_max, found: false }) {
            Some(found) => found.found,
            None => {
                let copy = self.view;
                occluded_any_ray(&copy, ray, filter)
            }
        }
    }

    #[inline(always)]
    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        match self.search(ray, filter, Next::new(ray.t_max, after)) {
            Some(found) => found.hit(&self.view.primitives, ray),
            None => {
                let copy = self.view;
                next_hit_of_any_ray(&copy, ray, filter, after)
            }
        }
    }
}
