//! What surrounds the scene.

use super::limited;
use crate::integrator::PathRay;
use crate::math::Vec3;
use crate::view::SceneView;

/// What a ray brings that leaves the scene: the background, which is light from all around, with that of the ambient term. Both are
/// radiance. No light sample finds it, so all of it counts.
#[inline(always)]
pub fn surroundings(view: &SceneView, ray: &PathRay) -> Vec3 {
    let settings = view.settings;
    let radiance = settings.background + Vec3::splat(settings.ambient);
    limited(settings, ray.depth > 1, ray.weight * radiance)
}
