//! Stage 2: what a ray does at the surface point that it found.

use super::branch_count;
use super::lobe_light::lamps_shine_through;
use crate::integrator::transmittance::material_of;
use crate::integrator::{MAX_DEPTH, PathRay, ray_through_hole};
use crate::ray::Hit;
use crate::settings::Settings;
use crate::shading::SurfacePoint;
use crate::view::{SceneView, item};

/// Bounces after the camera ray; none for the unlit models.
#[inline(always)]
pub fn depth_limit(settings: &Settings) -> u32 {
    if settings.lighting_model.is_lit() { settings.max_depth.min(MAX_DEPTH) } else { 0 }
}

/// Whether no ray goes on from what was hit, whatever textures say there.
#[inline(always)]
pub fn ends_at(view: &SceneView, hit: &Hit) -> bool {
    item(view.materials, material_of(view, hit.id)).ends_rays()
}

/// Rays that go on from a point that a ray of this depth found; the one through its holes is not among them.
#[inline(always)]
pub fn branches_at(point: &SurfacePoint, depth: u32, depth_limit: u32) -> u32 {
    if depth < depth_limit && point.coverage > 0.0 { branch_count(&point.material_values, depth) } else { 0 }
}

/// Continues a ray through the hole of a surface ([`ray_through_hole`]). It keeps `lobe_density` only with coloured shadows,
/// where shadow rays too reach lamps behind the surface; otherwise that becomes 0.
#[inline(always)]
pub fn ray_behind(view: &SceneView, point: &SurfacePoint, ray: &PathRay, t: f32) -> Option<PathRay> {
    let lobe_density = if lamps_shine_through(view.settings) { ray.lobe_density } else { 0.0 };
    ray_through_hole(view, point, ray, t).map(|behind| PathRay { lobe_density, ..behind })
}
