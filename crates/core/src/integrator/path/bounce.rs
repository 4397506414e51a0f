//! All stages of a path between two queries for the closest hit: what schedulers have in common.

use super::arrive::ray_behind;
use super::light::request;
use super::light_lanes::DrawLanes;
use super::{
    Arrival, LightRequest, Media, Numbers, NumbersOfLanes, PathPoint, PathState, ScatterPoint, arrive,
    sample_light, scatter, surroundings,
};
use crate::integrator::MAX_DEPTH;
use crate::light::LightReceiver;
use crate::math::{Vec3, Vec3Lanes};
use crate::ray::Hit;
use crate::settings::Settings;
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

/// Takes what several paths find at surfaces.
pub trait BounceLanes {
    /// Takes what one of them finds.
    type Lane<'a>: Bounce
    where
        Self: 'a;

    /// For the path of a lane.
    fn lane(&mut self, lane: usize) -> Self::Lane<'_>;
}

/// What the ray of `path` found: `hit`.
#[inline(always)]
pub fn bounce<N: Numbers, B: Bounce>(view: &SceneView, path: &PathState, hit: &Hit, numbers: &N, to: &mut B) {
    if hit.is_miss() {
        to.add(surroundings(view, &path.ray));
    } else {
        bounce_at_surface(view, path, hit, numbers, to);
    }
}

/// [`bounce`] of a ray that has met a surface: `hit` is none of those that are misses.
#[inline(always)]
pub fn bounce_at_surface<N: Numbers, B: Bounce>(
    view: &SceneView,
    path: &PathState,
    hit: &Hit,
    numbers: &N,
    to: &mut B,
) {
    let Some(Met { point, at, weight }) = meet(view, path, hit, numbers, to) else { return };
    let is_last = is_last(view.settings, path);
    if !is_last {
        sample_light(view, (&point, &at), (&path.ray, weight), numbers, |request| to.ask(request));
    }
    scatter(view, (&point, &at), (path, weight), hit.t, numbers, is_last, |next| to.go_on(next));
}

/// [`bounce`] of `count` paths that have met surfaces: `met(lane)` gives the path and the hit of each of W lanes, of which those
/// after the first `count` may repeat others. Samples of lights are drawn together.
#[inline(always)]
pub fn bounce_lanes<'a, const W: usize, B: BounceLanes>(
    view: &SceneView,
    count: usize,
    met: impl Fn(usize) -> (&'a PathState, &'a Hit),
    numbers: &impl NumbersOfLanes<W>,
    to: &mut B,
) {
    let mut points: [Option<Met>; W] = [const { None }; W];
    let mut receivers = [LightReceiver { position: Vec3::ZERO, normal: Vec3::ZERO }; W];
    let (mut origin, mut is_lit) = (Vec3Lanes::<W>::ZERO, [false; W]);
    for lane in 0..count {
        let (path, hit) = met(lane);
        points[lane] = meet(view, path, hit, &numbers.lane(lane), &mut to.lane(lane));
        let Some(Met { point, at, weight }) = &points[lane] else { continue };
        if is_last(view.settings, path) {
            continue;
        }
        if at.mixture.has_glass() {
            // Its light may come from either side.
            let (weight, numbers) = ((&path.ray, *weight), &numbers.lane(lane));
            sample_light(view, (point, at), weight, numbers, |request| to.lane(lane).ask(request));
            continue;
        }
        receivers[lane] = at.receiver(point);
        origin.set(lane, point.position.plus_scaled(point.geometric_normal, point.offset));
        is_lit[lane] = true;
    }
    let draws = DrawLanes::new(view, &is_lit, |lane| receivers[lane], &origin, numbers);
    for lane in 0..count {
        let Some(Met { point, at, weight }) = &points[lane] else { continue };
        let (path, hit) = met(lane);
        if draws.is_there(lane) {
            let draw = draws.get(lane);
            let is_above = draw.to_light.dot(point.geometric_normal) > 0.0;
            if is_above
                && draw.strength.is_any()
                && let Some(request) =
                    request(view, (point, at), (&path.ray, *weight), (origin.get(lane), &draw), false)
            {
                to.lane(lane).ask(request);
            }
        }
        let (weight, numbers) = ((path, *weight), &numbers.lane(lane));
        let is_last = is_last(view.settings, path);
        scatter(view, (point, at), weight, hit.t, numbers, is_last, |next| to.lane(lane).go_on(next));
    }
}

/// A surface that a path has met, and the weight that it has there.
struct Met {
    point: PathPoint,
    at: ScatterPoint,
    weight: Vec3,
}

/// What happens to a path up to its scattering; `None` where there is none.
#[inline(always)]
fn meet<N: Numbers, B: Bounce>(
    view: &SceneView,
    path: &PathState,
    hit: &Hit,
    numbers: &N,
    to: &mut B,
) -> Option<Met> {
    let ray = &path.ray;
    let mut point = PathPoint::new(view, &ray.ray(), hit);
    point.material_values.ior = Media::of(ray).relative_ior(view, &point);
    let (found, arrival) = arrive(view, &point, path, hit.t, numbers);
    to.add(found);
    match arrival {
        Arrival::Ended => None,
        Arrival::Passed(weight) => {
            to.go_on(PathState { ray: ray_behind(&point, ray, weight, hit.t), ..*path });
            None
        }
        Arrival::Met(weight) => {
            let at = ScatterPoint::new(&point);
            Some(Met { point, at, weight })
        }
    }
}

/// Whether a path ends where it is, after what it meets there is counted.
#[inline(always)]
fn is_last(settings: &Settings, path: &PathState) -> bool {
    let most = if settings.max_depth < MAX_DEPTH { settings.max_depth } else { MAX_DEPTH };
    path.ray.depth >= most
}
