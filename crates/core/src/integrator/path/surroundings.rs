//! What surrounds the scene.

use super::{limited, power_share};
use crate::integrator::PathRay;
use crate::math::Vec3;
use crate::view::SceneView;

/// What a ray brings that leaves the scene: the environment, or the background, which is light from all around where there is none;
/// and that of the ambient term. All are radiance. Of what light samples find, too, the ray's share counts.
#[inline(always)]
pub fn surroundings(view: &SceneView, ray: &PathRay) -> Vec3 {
    let (settings, environment) = (view.settings, view.environment);
    let mut radiance = settings.background;
    // Straight from the camera, through holes too.
    let is_looked_at = ray.depth == 0;
    if environment.is_there() & (environment.is_seen | !is_looked_at) {
        radiance = environment.radiance(&view.textures(), ray.direction);
        if (ray.lobe_density > 0.0) & (environment.chance > 0.0) {
            let density = environment.chance * environment.density(view.environment_table, ray.direction);
            radiance = radiance * power_share(ray.lobe_density, density);
        }
    }
    radiance += Vec3::splat(settings.ambient);
    limited(settings, ray.depth > 1, ray.weight * radiance)
}
