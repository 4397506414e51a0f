//! Light from one of the lights, chosen by how much it may give, or from the environment.

use super::{Media, Numbers, PathPoint, ScatterPoint, limited, power_share};
use crate::bsdf::Scattered;
use crate::integrator::PathRay;
use crate::light::{ChosenLight, Light, LightReceiver, LightSampleLanes};
use crate::material::NONE;
use crate::math::Vec3;
use crate::ray::{PrimitiveId, Ray, RayFilter};
use crate::sampling::triangle_point;
use crate::settings::Settings;
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
#[derive(Clone, Copy)]
pub(super) struct LightDraw {
    pub(super) to_light: Vec3,
    pub(super) t_max: f32,
    pub(super) target: PrimitiveId,
    pub(super) strength: Strength,
}

/// How strong a light is whose sample was drawn.
#[derive(Clone, Copy)]
pub(super) struct Strength {
    /// Radiance over density, for all that lights and their choice say; times pi for lamps.
    pub(super) radiance: Vec3,
    /// Density per steradian; 0 where rays of lobes do not meet the light.
    pub(super) density: f32,
}

impl Strength {
    /// Of a light's colour, where samples have this weight, that of their choice included.
    #[inline(always)]
    pub(super) fn new(settings: &Settings, color: Vec3, weight: f32, is_lamp: bool) -> Strength {
        Strength {
            radiance: color * (settings.lamp_radiance * weight),
            // The weight of a lamp's sample is one over its density.
            density: if is_lamp & (weight > 0.0) { 1.0 / weight } else { 0.0 },
        }
    }

    #[inline(always)]
    pub(super) fn is_any(&self) -> bool {
        self.radiance.max_component() > 0.0
    }

    /// What a path of this weight and depth gets of it where the surface scatters it like that, and bodies between leave so much.
    #[inline(always)]
    pub(super) fn contribution(
        &self,
        settings: &Settings,
        (weight, depth): (Vec3, u32),
        scattered: Scattered,
        left: Vec3,
    ) -> Vec3 {
        let share = if self.density > 0.0 { power_share(self.density, scattered.pdf) } else { 1.0 };
        limited(settings, depth > 0, weight * scattered.value * self.radiance * share * left)
    }
}

/// A light that was chosen.
#[derive(Clone, Copy)]
pub(super) struct LightChoice<'a> {
    /// `None`: the environment.
    pub(super) light: Option<&'a Light>,
    /// How likely it was; of the environment, this is in its density.
    pub(super) chance: f32,
    /// The first coordinate of a point of the light, in [0, 1).
    pub(super) place: f32,
}

impl LightChoice<'_> {
    const ENVIRONMENT: LightChoice<'static> = LightChoice { light: None, chance: 1.0, place: 0.0 };
}

impl LightDraw {
    /// In a direction of the environment, whose samples have this density.
    #[inline(always)]
    pub(super) fn of_environment(to_light: Vec3, radiance: Vec3, density: f32) -> LightDraw {
        let radiance = if density > 0.0 { radiance * (1.0 / density) } else { Vec3::ZERO };
        LightDraw {
            to_light,
            t_max: f32::INFINITY,
            target: PrimitiveId::NONE,
            strength: Strength { radiance, density },
        }
    }
}

/// Where a number that chooses the environment lies among those that do.
#[inline(always)]
pub(super) fn share_of_environment(view: &SceneView, choice: f64) -> f64 {
    choice / view.environment.chance as f64
}

/// From the environment, which was chosen because `choice` is below its chance.
#[inline(always)]
fn draw_environment(view: &SceneView, choice: f64, fine_place: f64) -> LightDraw {
    let environment = view.environment;
    let u = [share_of_environment(view, choice), fine_place];
    let sample = environment.sample(view.environment_table, u);
    let radiance = environment.radiance(&view.textures(), sample.to_light);
    LightDraw::of_environment(sample.to_light, radiance, environment.chance * sample.density)
}

/// From one of the lights, which is chosen with this chance, at a place of it.
#[inline(always)]
pub(super) fn draw_light(
    view: &SceneView,
    light: &Light,
    chance: f32,
    origin: Vec3,
    place: [f32; 2],
) -> LightDraw {
    let falloff = view.settings.light_falloff;
    let sample = LightSampleLanes::<1>::new(light, falloff, |_| origin, |_| place);
    let weight = sample.weight[0] / chance;
    let mut color = light.le();
    if let Light::Triangle { texture, .. } = *light
        && texture != NONE
        && weight > 0.0
    {
        color *= emission_texel(view, light.primitive(), texture, triangle_point(place));
    }
    LightDraw {
        to_light: sample.direction(0),
        strength: Strength::new(view.settings, color, weight, light.is_lamp()),
        t_max: sample.t_max[0],
        target: match light {
            Light::Sphere { .. } => PrimitiveId::NONE,
            _ => light.primitive(),
        },
    }
}

/// The choice of a light in each of several lanes that are wanted, as [`choose`] makes it.
#[inline(always)]
pub(super) fn choose_lanes<'a, const W: usize>(
    view: &SceneView<'a>,
    is_wanted: &[bool; W],
    receiver: impl Fn(usize) -> LightReceiver,
    choice: &[f64; W],
) -> [Option<LightChoice<'a>>; W] {
    let to_environment = view.environment.chance as f64;
    let share = 1.0 - to_environment;
    let mut lights = [None; W];
    if share > 0.0 {
        let (mut u, mut is_asked) = ([0.0; W], [false; W]);
        for lane in 0..W {
            u[lane] = (choice[lane] - to_environment) / share;
            is_asked[lane] = is_wanted[lane] & (choice[lane] >= to_environment);
        }
        lights = view.light_tree().choose_lanes(&is_asked, receiver, &u);
    }
    let mut chosen = [None; W];
    for lane in 0..W {
        chosen[lane] = if choice[lane] < to_environment {
            Some(LightChoice::ENVIRONMENT)
        } else {
            lights[lane].and_then(|light| chosen_light(view, &light, share))
        };
    }
    chosen
}

/// The light that is sampled by `choice` in [0, 1). `None` where none reaches the point.
#[inline(always)]
pub(super) fn choose<'a>(
    view: &SceneView<'a>,
    receiver: &LightReceiver,
    choice: f64,
) -> Option<LightChoice<'a>> {
    let to_environment = view.environment.chance as f64;
    if choice < to_environment {
        return Some(LightChoice::ENVIRONMENT);
    }
    let share = 1.0 - to_environment;
    let chosen = view.light_tree().choose(receiver, (choice - to_environment) / share)?;
    chosen_light(view, &chosen, share)
}

/// One of the lights, which have this share of all samples.
#[inline(always)]
fn chosen_light<'a>(view: &SceneView<'a>, chosen: &ChosenLight, share: f64) -> Option<LightChoice<'a>> {
    // By `get`, which has no panic for GPUs.
    let light = view.lights.get(chosen.number as usize)?;
    Some(LightChoice { light: Some(light), chance: chosen.chance * share as f32, place: chosen.rest })
}

/// Samples the environment or one light from a point that `ray` found, for a path of this weight; `ask` is told where that brings
/// anything.
#[inline(always)]
pub fn sample_light<N: Numbers>(
    view: &SceneView,
    (point, at): (&PathPoint, &ScatterPoint),
    (ray, weight): (&PathRay, Vec3),
    numbers: &N,
    ask: impl FnOnce(LightRequest),
) {
    let (choice, second_place) = numbers.light();
    let Some(LightChoice { light, chance, place }) = choose(view, &at.receiver(point), choice) else {
        return;
    };
    // The side that the sample lies on is known when there is one: then it is taken from there.
    let mut above = point.geometric_normal;
    let mut is_behind = false;
    let (origin, draw) = loop {
        let origin = point.position.plus_scaled(above, point.offset);
        let draw = match light {
            Some(light) => draw_light(view, light, chance, origin, [place, second_place]),
            None => draw_environment(view, choice, numbers.fine_place()),
        };
        if !draw.strength.is_any() {
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
    if let Some(request) = request(view, (point, at), (ray, weight), (origin, &draw), is_behind) {
        ask(request);
    }
}

/// What a light that was drawn brings to a point, seen from its front or from behind, where that is anything.
#[inline(always)]
pub(super) fn request(
    view: &SceneView,
    (point, at): (&PathPoint, &ScatterPoint),
    (ray, weight): (&PathRay, Vec3),
    (origin, draw): (Vec3, &LightDraw),
    is_behind: bool,
) -> Option<LightRequest> {
    let direction = at.to_frame(draw.to_light);
    // A shading normal may put light on another side than the surface does.
    if (direction.z > 0.0) == is_behind {
        return None;
    }
    let scattered = at.mixture.eval(direction);
    // What is infinitely far is in no body.
    let left = if draw.t_max < f32::INFINITY {
        let media = Media::of(ray);
        let media = if is_behind { media.beyond(view, point) } else { media };
        media.left(view, draw.t_max)
    } else {
        Vec3::ONE
    };
    let contribution = draw.strength.contribution(view.settings, (weight, ray.depth), scattered, left);
    (contribution.max_component() > 0.0).then_some(LightRequest {
        ray: Ray { origin, t_min: 0.0, direction: draw.to_light, t_max: draw.t_max },
        filter: RayFilter { start: point.id, target: draw.target, cull_back_faces: false },
        contribution,
    })
}
