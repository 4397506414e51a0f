//! Light from one of the lights, chosen by chance.

use super::{Numbers, PathPoint, ScatterPoint, limited, power_share};
use crate::integrator::PathRay;
use crate::light::LightSampleLanes;
use crate::math::Vec3;
use crate::ray::{Ray, RayFilter};
use crate::view::SceneView;

/// A shadow ray, and what the path gets where nothing is in its way.
#[derive(Clone, Copy, Debug)]
pub struct LightRequest {
    /// From the surface to the light.
    pub ray: Ray,
    /// What it leaves out: where it starts, and the light.
    pub filter: RayFilter,
    /// What is added to the pixel, times what gets through.
    pub contribution: Vec3,
}

/// Samples one light, each with the same chance, from a point that `ray` found; `None` where it brings nothing.
#[inline(always)]
pub fn sample_light(
    view: &SceneView,
    point: &PathPoint,
    at: &ScatterPoint,
    ray: &PathRay,
    numbers: &Numbers,
    choice: f32,
) -> Option<LightRequest> {
    let settings = view.settings;
    let count = view.lights.len();
    let chosen = (choice * count as f32) as usize;
    // By `get`, which has no panic for GPUs; where there is no light, there is none of this number.
    let light = view.lights.get(if chosen < count { chosen } else { count.wrapping_sub(1) })?;
    let chances = count as f32;
    // The side that the sample lies on is known when there is one: then it is taken from there.
    let mut above = point.geometric_normal;
    let mut side = 0;
    loop {
        let origin = point.position.plus_scaled(above, point.offset);
        let sample =
            LightSampleLanes::<1>::new(light, settings.light_falloff, |_| origin, |_| numbers.on_light());
        let to_light = sample.direction(0);
        if !(sample.weight[0] > 0.0) {
            return None;
        }
        if to_light.dot(above) <= 0.0 {
            // Glass is lit from the other side, too.
            if (side == 1) | !at.mixture.has_glass() {
                return None;
            }
            side = 1;
            above = -above;
            continue;
        }
        let direction = at.to_frame(to_light);
        // A shading normal may put light on another side than the surface does.
        if (direction.z > 0.0) != (side == 0) {
            return None;
        }
        let scattered = at.mixture.eval(direction);
        let mut share = 1.0;
        let radiance = light.le() * settings.lamp_radiance;
        if light.is_lamp() {
            // The weight of a sample is one over its density.
            let density = 1.0 / (sample.weight[0] * chances);
            share = power_share(density, scattered.pdf);
        }
        let strength = sample.weight[0] * chances * share;
        let contribution = ray.weight * scattered.value * radiance * strength;
        let contribution = limited(settings, ray.depth > 0, contribution);
        if !(contribution.max_component() > 0.0) {
            return None;
        }
        return Some(LightRequest {
            ray: Ray { origin, t_min: 0.0, direction: to_light, t_max: sample.t_max[0] },
            filter: RayFilter { start: point.id, target: light.primitive(), cull_back_faces: false },
            contribution,
        });
    }
}
