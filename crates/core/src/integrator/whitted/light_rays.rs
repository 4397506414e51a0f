//! Light at a surface point in three steps, for devices that trace shadow rays apart: the rays, what gets through, and the sum.
//! It is [`direct_light`](super::direct_light)'s, bit for bit.

use super::direct_light::LightTurns;
use super::{LightLanes, LightSums, LitPoint, is_lit_from_behind, point_key, shade_direct, shadow_filter};
use super::{shadow_origin, side_sign};
use crate::light::Light;
use crate::math::Vec3;
use crate::ray::{PrimitiveId, Ray, RayFilter};
use crate::settings::Settings;
use crate::view::SceneView;

/// A shadow ray, and what the light brings where nothing is in its way.
#[derive(Clone, Copy, Debug)]
pub struct LightRay {
    /// The number of the light.
    pub light: u32,
    /// The side of the point that it starts from.
    pub side: u32,
    /// Unit vector to the light.
    pub direction: Vec3,
    /// The ray ends here, just before the light.
    pub t_max: f32,
    /// Weight times `N.L`.
    pub diffuse: f32,
    /// Weight times the highlight.
    pub specular: f32,
}

/// Samples that Whitted's integrator takes of these lights on one side of a point, where lamps are drawn or not.
pub fn light_samples_of_side(lights: &[Light], are_lamps_drawn: bool, settings: &Settings) -> u32 {
    let is_alone = |light: &Light| !(are_lamps_drawn && light.is_lamp());
    let alone = lights.iter().take_while(|light| is_alone(light)).count();
    let samples = lights[..alone].iter().fold(0u32, |sum, light| sum.saturating_add(light.samples()));
    let drawn = match lights.get(alone) {
        Some(lamp) => settings.lamp_samples.saturating_mul(lamp.samples()),
        None => 0,
    };
    samples.saturating_add(drawn)
}

/// Shadow rays that these lights ask of a point at most. They have numbers from 0: light after light, of each side after side, of
/// each sample after sample. For points with one side those of the second are not there.
pub fn light_rays_of_point(lights: &[Light], are_lamps_drawn: bool, settings: &Settings) -> u32 {
    light_samples_of_side(lights, are_lamps_drawn, settings).saturating_mul(sides_of_any(settings))
}

/// Sides that any point has.
#[inline(always)]
fn sides_of_any(settings: &Settings) -> u32 {
    1 + settings.light_from_behind as u32
}

/// A shadow ray's place among those of a point.
#[derive(Clone, Copy, Debug)]
struct Place {
    turn: u32,
    side: u32,
    sample: u32,
}

impl Place {
    /// The place of a number.
    #[inline(always)]
    fn new(view: &SceneView, turns: &LightTurns, number: u32) -> Place {
        let sides = sides_of_any(view.settings);
        let (mut turn, mut left) = (0, number);
        while turn < turns.all {
            let samples = turns.samples(view, turn);
            if left < samples * sides {
                let side = (left >= samples) as u32;
                return Place { turn, side, sample: left - side * samples };
            }
            left -= samples * sides;
            turn += 1;
        }
        Place { turn, side: 0, sample: 0 }
    }
}

/// The shadow ray of a number; `None` where the light brings nothing or there is no such ray. The other arguments are those of
/// [`direct_light`](super::direct_light).
#[inline(always)]
pub fn light_ray(
    view: &SceneView,
    point: &LitPoint,
    path: u32,
    (x, y, sample): (u32, u32, u32),
    number: u32,
) -> Option<LightRay> {
    let turns = LightTurns::new(view);
    let place = Place::new(view, &turns, number);
    if place.side > is_lit_from_behind(view.settings, point.transmission) as u32 {
        return None;
    }
    let key = point_key(view.settings, path, x, y);
    let turn = turns.light(view, point, (key, sample), place.turn, place.side)?;
    let mut receiver = turn.receiver;
    receiver.first = receiver.first.wrapping_add(place.sample);
    let lanes = LightLanes::<1>::new(view.settings, turn.light, &receiver);
    if !lanes.brings(0) {
        return None;
    }
    let ray = lanes.ray(0, receiver.origin);
    Some(LightRay {
        light: turn.number,
        side: place.side,
        direction: ray.direction,
        t_max: ray.t_max,
        diffuse: lanes.diffuse[0],
        specular: lanes.specular[0],
    })
}

/// Where shadow rays of a side of a point start, as [`LitPoint`] has it, and what they leave out on the way to a light; `None`
/// where there is no such light.
#[inline(always)]
pub fn light_query(
    view: &SceneView,
    (position, offset, geometric_normal): (Vec3, f32, Vec3),
    from: PrimitiveId,
    (light, side): (u32, u32),
    (direction, t_max): (Vec3, f32),
) -> Option<(Ray, RayFilter)> {
    let light = view.lights.get(light as usize)?;
    let origin = shadow_origin(position, geometric_normal * side_sign(side), offset);
    Some((Ray { origin, t_min: 0.0, direction, t_max }, shadow_filter(light, from)))
}

/// How far a point's light is added up.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightProgress {
    /// What lights that are done with give.
    pub sum: Vec3,
    /// Samples of the one that follows.
    pub got: LightSums,
    /// The number of that light, once a sample has said it.
    pub light: Option<u32>,
}

/// What became of a shadow ray.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// The number of the light; `None` where the light brings nothing or there is no such ray.
    pub light: Option<u32>,
    /// What gets through, per channel.
    pub through: Vec3,
    /// As [`LightRay::diffuse`].
    pub diffuse: f32,
    /// As [`LightRay::specular`].
    pub specular: f32,
}

/// Adds what became of the rays with these numbers. `point` is that of [`light_ray`].
#[inline(always)]
pub fn add_light(
    view: &SceneView,
    point: &LitPoint,
    (first, end): (u32, u32),
    progress: &mut LightProgress,
    sample: impl Fn(u32) -> LightSample,
) {
    let sides = 1 + is_lit_from_behind(view.settings, point.transmission) as u32;
    let turns = LightTurns::new(view);
    let Place { mut turn, mut side, sample: mut of_side } = Place::new(view, &turns, first);
    let mut number = first;
    while number < end && turn < turns.all {
        let samples = turns.samples(view, turn);
        while number < end && of_side < samples {
            let LightSample { light, through, diffuse, specular } = sample(number);
            // Which lamp was drawn need not be found out again.
            if light.is_some() {
                progress.light = light;
            }
            progress.got.add(through, diffuse, specular);
            number += 1;
            of_side += 1;
        }
        if of_side >= samples {
            if side < sides
                && let Some(number) = progress.light
                && let Some(light) = view.lights.get(number as usize)
                && let Some(specular) = turns.specular(view, point, turn)
            {
                let (diffuse, transmission) = (point.diffuse, point.transmission);
                progress.sum +=
                    shade_direct(light.le(), diffuse, specular, transmission, side, &progress.got);
            }
            (progress.got, progress.light) = (LightSums::default(), None);
            of_side = 0;
            side += 1;
            if side >= sides_of_any(view.settings) {
                side = 0;
                turn += 1;
            }
        }
    }
}
