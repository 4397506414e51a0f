//! The reference scheduler: one loop.

use super::{Bounce, LightRequest, NumbersByKey, PathState, bounce, visibility};
use crate::hierarchy::Tracer;
use crate::integrator::{PathRay, RayCounts};
use crate::math::Vec3;
use crate::sums::ExactSum;
use crate::view::SceneView;

/// Adds what `first` finds, and everything that its path finds after it, to `sum`; for sample `sample` of pixel (x, y).
#[inline(always)]
pub fn radiance<T: Tracer>(
    view: &SceneView,
    tracer: &T,
    first: PathRay,
    place: (u32, u32, u32),
    sum: &mut ExactSum,
    counts: &mut RayCounts,
) {
    let mut path = PathState::new(first);
    loop {
        counts.count(path.ray.kind);
        let hit = tracer.closest_hit(&path.ray.ray(), &path.ray.filter(view.settings));
        let numbers = NumbersByKey::new(view.settings, &path.ray, place);
        let mut step = Step { sum, request: None, next: None };
        bounce(view, &path, &hit, &numbers, &mut step);
        let Step { request, next, .. } = step;
        if let Some(request) = request {
            counts.shadow += 1;
            sum.add(request.contribution * visibility(view, tracer, &request));
        }
        path = match next {
            Some(next) => next,
            None => return,
        };
    }
}

/// What one surface gave.
struct Step<'a> {
    sum: &'a mut ExactSum,
    request: Option<LightRequest>,
    next: Option<PathState>,
}

impl Bounce for Step<'_> {
    #[inline(always)]
    fn add(&mut self, found: Vec3) {
        self.sum.add(found);
    }

    #[inline(always)]
    fn ask(&mut self, request: LightRequest) {
        self.request = Some(request);
    }

    #[inline(always)]
    fn go_on(&mut self, next: PathState) {
        self.next = Some(next);
    }
}
