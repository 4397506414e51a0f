//! All stages of a path between two queries for the closest hit: what schedulers have in common.

use super::arrive::ray_behind;
use super::{
    Arrival, LightRequest, Media, Numbers, PathPoint, PathState, ScatterPoint, arrive, sample_light, scatter,
    surroundings,
};
use crate::integrator::MAX_DEPTH;
use crate::math::Vec3;
use crate::ray::Hit;
use crate::view::SceneView;

/// Takes what a path finds at a surface. Each is told at most once a bounce, in any order.
pub trait Bounce {
    /// Something to be added to the pixel.
    fn add(&mut self, found: Vec3);
    /// A light, to be added where it is seen.
    fn ask(&mut self, request: LightRequest);
    /// How the path goes on.
    fn go_on(&mut self, next: PathState);
}

/// What the ray of `path` found: `hit`.
#[inline(always)]
pub fn bounce<N: Numbers, B: Bounce>(view: &SceneView, path: &PathState, hit: &Hit, numbers: &N, to: &mut B) {
    let (settings, ray) = (view.settings, &path.ray);
    if hit.is_miss() {
        to.add(surroundings(view, ray));
        return;
    }
    let mut point = PathPoint::new(view, &ray.ray(), hit);
    point.material_values.ior = Media::of(ray).relative_ior(view, &point);
    let (found, arrival) = arrive(view, &point, path, hit.t, numbers);
    to.add(found);
    let weight = match arrival {
        Arrival::Ended => return,
        Arrival::Passed(weight) => {
            to.go_on(PathState { ray: ray_behind(&point, ray, weight, hit.t), ..*path });
            return;
        }
        Arrival::Met(weight) => weight,
    };
    let at = ScatterPoint::new(&point);
    let most = if settings.max_depth < MAX_DEPTH { settings.max_depth } else { MAX_DEPTH };
    let is_last = ray.depth >= most;
    let (choice, lobe) = numbers.choice();
    if !is_last {
        sample_light(view, (&point, &at), (ray, weight), numbers, choice, |request| to.ask(request));
    }
    scatter(view, (&point, &at), (path, weight), hit.t, numbers, (lobe, is_last), |next| to.go_on(next));
}
