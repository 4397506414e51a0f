//! Where a path goes on.

use super::{Media, Numbers, PathPoint, PathState, ScatterPoint, arrive::ray_behind};
use crate::integrator::coverage::MAX_HOLES;
use crate::integrator::{PathRay, RayKind};
use crate::math::Vec3;
use crate::sums::MAX_RADIANCE;
use crate::view::SceneView;

/// What goes on from a point that `path` found at distance `t`, with the weight that it has there; `go_on` is told, unless the path
/// ends. At the last bounce, `is_last`, only what passes thin glass straight goes on: that is none.
#[inline(always)]
pub fn scatter<N: Numbers>(
    view: &SceneView,
    (point, at): (&PathPoint, &ScatterPoint),
    (path, weight): (&PathState, Vec3),
    t: f32,
    numbers: &N,
    is_last: bool,
    go_on: impl FnOnce(PathState),
) {
    let ray = &path.ray;
    let Some(sample) = at.mixture.sample(numbers.direction(), || numbers.side()) else { return };
    let weight = (weight * sample.weight).min(Vec3::splat(MAX_RADIANCE));
    if !(weight.max_component() > 0.0) {
        return;
    }
    let direction = at.to_world(sample.to_light);
    let media = Media::of(ray);
    let media = if sample.is_transmitted { media.beyond(view, point) } else { media };
    let [inside, outer] = media.words();
    let mut next = PathState {
        ray: PathRay {
            origin: point.offset_origin(direction),
            path: outer,
            direction,
            depth: ray.depth + 1,
            weight,
            kind: match (sample.is_transmitted, sample.is_delta) {
                (true, _) => RayKind::Refracted,
                (false, true) => RayKind::Reflected,
                (false, false) => RayKind::Glossy,
            },
            start: point.id,
            inside,
            holes: 0,
            travelled: 0.0,
            lobe_density: if sample.is_delta { 0.0 } else { sample.pdf },
        },
        left: at.receiver(point),
    };
    if sample.is_straight {
        if ray.holes >= MAX_HOLES {
            return;
        }
        next = PathState { ray: ray_behind(point, ray, weight, t), ..*path };
    } else if is_last | ((direction.dot(point.geometric_normal) > 0.0) == sample.is_transmitted) {
        // What a shading normal sends to the wrong side counts as black.
        return;
    }
    go_on(next);
}
