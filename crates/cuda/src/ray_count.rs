//! How many rays a scene's samples take, by a guess.

use eosphor_core::integrator::whitted::light_samples_of_side;
use eosphor_core::light::Light;
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

/// Shadow rays from one side of a point.
pub(crate) fn shadow_rays(view: &SceneView) -> f64 {
    let are_lamps_drawn = !view.light_nodes.is_empty();
    if are_lamps_drawn && view.settings.integrator == Integrator::Path {
        return 1.0;
    }
    light_samples_of_side(view.lights, are_lamps_drawn, view.settings).into()
}

/// A light with as many samples is worth a part of a warp for itself.
const MANY_SAMPLES: u32 = 8;

/// Whether most shadow rays of Whitted's integrator go to lights with many samples each.
pub(crate) fn many_rays_share_lights(view: &SceneView) -> bool {
    let samples = |lights: &mut dyn Iterator<Item = u32>| lights.map(u64::from).sum::<u64>();
    let all = samples(&mut view.lights.iter().map(Light::samples));
    let many = samples(&mut view.lights.iter().map(Light::samples).filter(|&n| n >= MANY_SAMPLES));
    2 * many > all
}
