//! Light from one of the lights, chosen by how much it may give, or from the environment.

use super::{Media, Numbers, PathPoint, ScatterPoint, limited, power_share};
use crate::integrator::PathRay;
use crate::light::{Light, LightSampleLanes};
use crate::material::NONE;
use crate::math::Vec3;
use crate::ray::{PrimitiveId, Ray, RayFilter};
use crate::sampling::triangle_point;
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
fn draw_environment<N: Numbers>(view: &SceneView, numbers: &N) -> LightDraw {
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
fn draw_light<N: Numbers>(
    view: &SceneView,
    light: &Light,
    chance: f32,
    origin: Vec3,
    numbers: &N,
) -> LightDraw {
    let falloff = view.settings.light_falloff;
    let sample = LightSampleLanes::<1>::new(light, falloff, |_| origin, |_| numbers.on_light());
    let weight = sample.weight[0] / chance;
    let mut color = light.le();
    if let Light::Triangle { texture, .. } = *light
        && texture != NONE
        && weight > 0.0
    {
        let place = triangle_point(numbers.on_light());
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

/// Samples the environment or one light from a point that `ray` found, by `choice` in [0, 1), for a path of this weight; `ask` is
/// told where that brings anything.
#[inline(always)]
pub fn sample_light<N: Numbers>(
    view: &SceneView,
    (point, at): (&PathPoint, &ScatterPoint),
    (ray, weight): (&PathRay, Vec3),
    numbers: &N,
    choice: f64,
    ask: impl FnOnce(LightRequest),
) {
    let settings = view.settings;
    let to_environment = view.environment.chance as f64;
    let mut light = None;
    let mut chance = 1.0;
    if choice >= to_environment {
        let share = 1.0 - to_environment;
        let lights = view.light_tree();
        let Some(chosen) = lights.choose(&at.receiver(point), (choice - to_environment) / share) else {
            return;
        };
        chance = chosen.chance * share as f32;
        // By `get`, which has no panic for GPUs.
        light = view.lights.get(chosen.number as usize);
        if light.is_none() {
            return;
        }
    }
    // The side that the sample lies on is known when there is one: then it is taken from there.
    let mut above = point.geometric_normal;
    let mut is_behind = false;
    let (origin, draw) = loop {
        let origin = point.position.plus_scaled(above, point.offset);
        let draw = match light {
            Some(light) => draw_light(view, light, chance, origin, numbers),
            None => draw_environment(view, numbers),
        };
        if !(draw.radiance.max_component() > 0.0) {
            return;
        }
        if draw.to_light.dot(above) > 0.0 {
            break (origin, draw);
        }
        // Glass is lit from the other side, too.
        if is_behind | !at.mixture.has_glass() {
            return;
        }
        is_behind = true;
        above = -above;
    };
    let direction = at.to_frame(draw.to_light);
    // A shading normal may put light on another side than the surface does.
    if (direction.z > 0.0) == is_behind {
        return;
    }
    let scattered = at.mixture.eval(direction);
    let share = if draw.density > 0.0 { power_share(draw.density, scattered.pdf) } else { 1.0 };
    let mut contribution = weight * scattered.value * draw.radiance * share;
    // What is infinitely far is in no body.
    if draw.t_max < f32::INFINITY {
        let media = Media::of(ray);
        let media = if is_behind { media.beyond(view, point) } else { media };
        contribution *= media.left(view, draw.t_max);
    }
    let contribution = limited(settings, ray.depth > 0, contribution);
    if contribution.max_component() > 0.0 {
        ask(LightRequest {
            ray: Ray { origin, t_min: 0.0, direction: draw.to_light, t_max: draw.t_max },
            filter: RayFilter { start: point.id, target: draw.target, cull_back_faces: false },
            contribution,
        });
    }
}
