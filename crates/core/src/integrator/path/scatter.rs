//! Where a path goes on.

use super::{Numbers, PathPoint, PathState, ScatterPoint, arrive::ray_behind};
use crate::integrator::coverage::MAX_HOLES;
use crate::integrator::{PathRay, RayKind};
use crate::math::Vec3;
use crate::sums::MAX_RADIANCE;

/// What goes on from a point that `path` found at distance `t`; `None` where the path ends. At the last bounce, `is_last`,
/// only what passes thin glass straight goes on: that is none.
#[inline(always)]
pub fn scatter(
    point: &PathPoint,
    at: &ScatterPoint,
    path: &PathState,
    t: f32,
    numbers: &Numbers,
    (choice, is_last): (f32, bool),
) -> Option<PathState> {
    let ray = &path.ray;
    let sample = at.mixture.sample(choice, numbers.direction())?;
    let weight = (ray.weight * sample.weight).min(Vec3::splat(MAX_RADIANCE));
    if !(weight.max_component() > 0.0) {
        return None;
    }
    if sample.is_straight {
        let ray = ray_behind(point, ray, weight, t);
        return (path.ray.holes < MAX_HOLES).then_some(PathState { ray, ..*path });
    }
    if is_last {
        return None;
    }
    let direction = at.to_world(sample.to_light);
    // What a shading normal sends to the wrong side counts as black.
    if (direction.dot(point.geometric_normal) > 0.0) == sample.is_transmitted {
        return None;
    }
    let kind = match (sample.is_transmitted, sample.is_delta) {
        (true, _) => RayKind::Refracted,
        (false, true) => RayKind::Reflected,
        (false, false) => RayKind::Glossy,
    };
    let next = PathRay {
        origin: point.offset_origin(direction),
        path: ray.path,
        direction,
        depth: ray.depth + 1,
        weight,
        kind,
        start: point.id,
        inside: ray.inside,
        holes: 0,
        travelled: 0.0,
        lobe_density: if sample.is_delta { 0.0 } else { sample.pdf },
    };
    Some(PathState { ray: next, left: at.receiver(point) })
}
