//! The reference scheduler: one loop.

use super::{
    Arrival, Numbers, PathPoint, PathState, ScatterPoint, arrive, sample_light, scatter, surroundings,
    visibility,
};
use crate::hierarchy::Tracer;
use crate::integrator::{MAX_DEPTH, PathRay, RayCounts};
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
    let settings = view.settings;
    let most = if settings.max_depth < MAX_DEPTH { settings.max_depth } else { MAX_DEPTH };
    let mut path = PathState::new(first);
    loop {
        let ray = path.ray;
        counts.count(ray.kind);
        let hit = tracer.closest_hit(&ray.ray(), &ray.filter(settings));
        if hit.is_miss() {
            sum.add(surroundings(view, &ray));
            return;
        }
        let point = PathPoint::new(view, &ray.ray(), &hit);
        let numbers = Numbers::new(settings, &ray, place);
        let (found, arrival) = arrive(view, &point, &path, hit.t, &numbers);
        sum.add(found);
        let met = match arrival {
            Arrival::Ended => return,
            Arrival::Passed(behind) => {
                path = behind;
                continue;
            }
            Arrival::Met(met) => met,
        };
        let at = ScatterPoint::new(&point);
        let is_last = met.ray.depth >= most;
        let (light, lobe) = numbers.choice();
        if !is_last && let Some(request) = sample_light(view, &point, &at, &met.ray, &numbers, light) {
            counts.shadow += 1;
            sum.add(request.contribution * visibility(view, tracer, &request));
        }
        path = match scatter(&point, &at, &met, hit.t, &numbers, (lobe, is_last)) {
            Some(next) => next,
            None => return,
        };
    }
}
