//! Rays that go on through the holes of a surface: where it covers only a part of what is behind it.

use super::{PathRay, RayKind};
use crate::math::Vec3;
use crate::sampling::hash_pair;
use crate::shading::SurfacePoint;
use crate::view::SceneView;

/// Holes that a ray passes one after the other; what lies behind more is black.
pub(super) const MAX_HOLES: u32 = 4096;

/// The weight with which a ray arrives at a point at distance `t`: a body that it came through has taken its part.
#[inline(always)]
pub fn weight_at(view: &SceneView, point: &SurfacePoint, ray: &PathRay, t: f32) -> Vec3 {
    if point.front { ray.weight } else { ray.weight * point.left_by_body(view, t) }
}

/// What goes on through the holes of a point at distance `t`, if it is worth tracing; `ray` has the weight with which it
/// arrived. It is no bounce.
#[inline(always)]
pub fn ray_through_hole(view: &SceneView, point: &SurfacePoint, ray: &PathRay, t: f32) -> Option<PathRay> {
    let behind = ray.weight * (1.0 - point.coverage);
    if point.coverage < 1.0 && ray.holes < MAX_HOLES && is_worth_tracing(view, behind) {
        Some(through_hole(point, ray, behind, t))
    } else {
        None
    }
}

/// Whether a ray of this weight is worth tracing.
#[inline(always)]
pub fn is_worth_tracing(view: &SceneView, weight: Vec3) -> bool {
    let energy = weight.max_component();
    (energy > 0.0) & (energy >= view.settings.energy_threshold)
}

/// What goes on through a hole in a surface, as if it were not there.
#[inline(always)]
fn through_hole(point: &SurfacePoint, ray: &PathRay, weight: Vec3, t: f32) -> PathRay {
    PathRay {
        origin: point.offset_origin(ray.direction),
        // Branches count from 1.
        path: hash_pair(ray.path, 0),
        weight,
        kind: RayKind::Refracted,
        start: point.id,
        holes: ray.holes + 1,
        travelled: ray.travelled + t,
        ..*ray
    }
}
