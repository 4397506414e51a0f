//! Stage 2: what a ray does at the surface point that it found.

use super::children::is_alive;
use super::lobe_light::lamps_shine_through;
use super::local::is_lit;
use super::{MAX_DEPTH, PathRay, RayKind, branch_count};
use crate::math::Vec3;
use crate::sampling::hash_pair;
use crate::settings::Settings;
use crate::shading::SurfacePoint;
use crate::view::SceneView;

/// Holes that a ray passes one after the other; what lies behind more is black.
pub(super) const MAX_HOLES: u32 = 4096;

/// Bounces after the camera ray; none for the unlit models.
#[inline(always)]
pub fn depth_limit(settings: &Settings) -> u32 {
    if is_lit(settings.lighting_model) { settings.max_depth.min(MAX_DEPTH) } else { 0 }
}

/// The weight with which a ray arrives at a point at distance `t`: a body that it came through has taken its part.
#[inline(always)]
pub fn weight_at(view: &SceneView, point: &SurfacePoint, ray: &PathRay, t: f32) -> Vec3 {
    if point.front { ray.weight } else { ray.weight * point.left_by_body(view, t) }
}

/// Rays that go on from a point that a ray of this depth found; the one through its holes is not among them.
#[inline(always)]
pub fn branches_at(point: &SurfacePoint, depth: u32, depth_limit: u32) -> u32 {
    if depth < depth_limit && point.seen > 0.0 { branch_count(&point.look, depth) } else { 0 }
}

/// What goes on through the holes of a point at distance `t`, if it is worth tracing; `ray` has the weight with which it
/// arrived. It is no bounce.
#[inline(always)]
pub fn ray_behind(view: &SceneView, point: &SurfacePoint, ray: &PathRay, t: f32) -> Option<PathRay> {
    let behind = ray.weight * (1.0 - point.seen);
    if point.seen < 1.0 && ray.holes < MAX_HOLES && is_alive(view, behind) {
        let lobe_density = if lamps_shine_through(view.settings) { ray.lobe_density } else { 0.0 };
        Some(PathRay { lobe_density, ..through_hole(point, ray, behind, t) })
    } else {
        None
    }
}

/// What goes on through a hole in a surface, as if it were not there.
#[inline(always)]
pub(super) fn through_hole(point: &SurfacePoint, ray: &PathRay, weight: Vec3, t: f32) -> PathRay {
    PathRay {
        origin: point.leave(ray.direction),
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
