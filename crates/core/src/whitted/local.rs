//! Stage 2: what a surface point gives by itself.

use crate::math::{Vec3, min};
use crate::settings::LightingModel;
use crate::shading::SurfacePoint;
use crate::view::SceneView;

/// Emission and ambient term; for the unlit models the whole colour. `t` is the distance along the ray.
#[inline(always)]
pub fn local_radiance(view: &SceneView, point: &SurfacePoint, t: f32) -> Vec3 {
    let settings = view.settings;
    match settings.lighting_model {
        LightingModel::Distance => {
            let reach = 1.5 * settings.max_distance;
            Vec3::splat(1.0 - min(t, reach) / reach)
        }
        LightingModel::Diffuse => point.look.diffuse,
        _ => point.look.emission + point.look.diffuse * settings.ambient,
    }
}

/// Whether the model goes on to lights and further rays.
#[inline(always)]
pub fn is_lit(model: LightingModel) -> bool {
    !matches!(model, LightingModel::Distance | LightingModel::Diffuse)
}
