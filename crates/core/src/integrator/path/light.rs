//! Light from one of the lights, chosen by how much it may give, or from the environment.

use super::{Numbers, PathPoint, ScatterPoint, limited, power_share};
use crate::integrator::PathRay;
use crate::light::{Light, LightSampleLanes};
use crate::material::NONE;
use crate::math::Vec3;
use crate::ray::{PrimitiveId, Ray, RayFilter};
use crate::sampling::{point_2d, triangle_point};
use crate::shading::emission_texel;
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

/// A sample of a light, as seen from a point.
struct LightDraw {
    to_light: Vec3,
    /// Radiance over density, for all that lights and their choice say; times pi for lamps.
    radiance: Vec3,
    /// Density per steradian; 0 where rays of lobes do not meet the light.
    density: f32,
    t_max: f32,
    target: PrimitiveId,
}

/// From the environment.
#[inline(always)]
fn draw_environment(view: &SceneView, numbers: &Numbers) -> LightDraw {
    let environment = view.environment;
    let [u, jitter] = numbers.on_environment();
    let sample = environment.sample(view.environment_table, u, jitter);
    let density = environment.chance * sample.density;
    let radiance = environment.radiance(&view.textures(), sample.to_light);
    LightDraw {
        to_light: sample.to_light,
        radiance: if density > 0.0 { radiance * (1.0 / density) } else { Vec3::ZERO },
        density,
        t_max: f32::INFINITY,
        target: PrimitiveId::NONE,
    }
}

/// From one of the lights, which is chosen with this chance.
#[inline(always)]
fn draw_light(view: &SceneView, light: &Light, chance: f32, origin: Vec3, numbers: &Numbers) -> LightDraw {
    let falloff = view.settings.light_falloff;
    let sample = LightSampleLanes::<1>::new(light, falloff, |_| origin, |_| numbers.on_light());
    let weight = sample.weight[0] / chance;
    let mut color = light.le();
    if let Light::Triangle { texture, .. } = *light
        && texture != NONE
        && weight > 0.0
    {
        let (index, key) = numbers.on_light();
        let place = triangle_point(point_2d(index, key));
        color *= emission_texel(view, light.primitive(), texture, place);
    }
    // The weight of a lamp's sample is one over its density.
    let density = if light.is_lamp() & (weight > 0.0) { 1.0 / weight } else { 0.0 };
    LightDraw {
        to_light: sample.direction(0),
        radiance: color * (view.settings.lamp_radiance * weight),
        density,
        t_max: sample.t_max[0],
        target: match light {
            Light::Sphere { .. } => PrimitiveId::NONE,
            _ => light.primitive(),
        },
    }
}

/// Samples the environment or one light from a point that `ray` found, by `choice` in [0, 1); `None` where that brings nothing.
#[inline(always)]
pub fn sample_light(
    view: &SceneView,
    point: &PathPoint,
    at: &ScatterPoint,
    ray: &PathRay,
    numbers: &Numbers,
    choice: f64,
) -> Option<LightRequest> {
    let settings = view.settings;
    let to_environment = view.environment.chance as f64;
    let is_environment = choice < to_environment;
    let mut light = None;
    let mut chance = 1.0;
    if !is_environment {
        let share = 1.0 - to_environment;
        let chosen = view.light_tree().choose(&at.receiver(point), (choice - to_environment) / share)?;
        chance = chosen.chance * share as f32;
        // By `get`, which has no panic for GPUs.
        light = Some(view.lights.get(chosen.number as usize)?);
    }
    // The side that the sample lies on is known when there is one: then it is taken from there.
    let mut above = point.geometric_normal;
    let mut side = 0;
    loop {
        let origin = point.position.plus_scaled(above, point.offset);
        let draw = match light {
            Some(light) => draw_light(view, light, chance, origin, numbers),
            None => draw_environment(view, numbers),
        };
        if !(draw.radiance.max_component() > 0.0) {
            return None;
        }
        if draw.to_light.dot(above) <= 0.0 {
            // Glass is lit from the other side, too.
            if (side == 1) | !at.mixture.has_glass() {
                return None;
            }
            side = 1;
            above = -above;
            continue;
        }
        let direction = at.to_frame(draw.to_light);
        // A shading normal may put light on another side than the surface does.
        if (direction.z > 0.0) != (side == 0) {
            return None;
        }
        let scattered = at.mixture.eval(direction);
        let share = if draw.density > 0.0 { power_share(draw.density, scattered.pdf) } else { 1.0 };
        let contribution = ray.weight * scattered.value * draw.radiance * share;
        let contribution = limited(settings, ray.depth > 0, contribution);
        if !(contribution.max_component() > 0.0) {
            return None;
        }
        return Some(LightRequest {
            ray: Ray { origin, t_min: 0.0, direction: draw.to_light, t_max: draw.t_max },
            filter: RayFilter { start: point.id, target: draw.target, cull_back_faces: false },
            contribution,
        });
    }
}
