//! Stage 2: what a surface point gives by itself.

use super::lobe_light::lamp_share;
use crate::integrator::PathRay;
use crate::math::{Vec3, min};
use crate::settings::LightingModel;
use crate::shading::SurfacePoint;
use crate::view::SceneView;

/// Emission and ambient term, for the ray that found the point at distance `t`; for the unlit models the whole colour.
#[inline(always)]
pub fn local_radiance(view: &SceneView, point: &SurfacePoint, ray: &PathRay, t: f32) -> Vec3 {
    let settings = view.settings;
    let t = ray.travelled + t;
    match settings.lighting_model {
        LightingModel::Distance => {
            let reach = 1.5 * settings.max_distance;
            Vec3::splat(1.0 - min(t, reach) / reach)
        }
        LightingModel::Diffuse => point.material_values.diffuse,
        LightingModel::Lambert | LightingModel::Phong | LightingModel::BlinnPhong => {
            let emission = point.material_values.emission * lamp_share(view, point, ray, t);
            emission + point.material_values.diffuse * settings.ambient
        }
    }
}
