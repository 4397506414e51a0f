//! How many rays a scene's samples take, by a guess.

use eosphor_core::settings::Integrator;
use eosphor_core::view::SceneView;
use eosphor_render::Accel;

/// Primitives that a ray tests in the time of one in a hierarchy.
const TESTED_IN_PASSING: f64 = 64.0;

/// A guess at the rays that a sample takes: its own, and to the lights from what it meets first. Without a hierarchy a ray is
/// as much work as many.
pub(crate) fn rays_per_sample(view: &SceneView, accel: Accel) -> f64 {
    let lights = shadow_rays(view);
    let primitives = (view.triangles.len() + view.spheres.len()) as f64;
    let work = if accel == Accel::None { (primitives / TESTED_IN_PASSING).max(1.0) } else { 1.0 };
    (1.0 + lights) * work
}

/// Shadow rays from a point.
pub(crate) fn shadow_rays(view: &SceneView) -> f64 {
    if view.light_nodes.is_empty() {
        return view.lights.iter().map(|light| f64::from(light.samples())).sum();
    }
    match view.settings.integrator {
        Integrator::Path => 1.0,
        Integrator::Whitted => {
            let alone = view.lights.iter().filter(|light| !light.is_lamp()).count();
            alone as f64 + f64::from(view.settings.lamp_samples)
        }
    }
}
