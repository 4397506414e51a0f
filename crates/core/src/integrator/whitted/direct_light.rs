//! Stage 3: light that reaches a surface point.

use super::light_lanes::LightLanes;
use super::{LampLobe, LitPoint, Receiver, are_lamps_drawn, draw_lamp, lights_alone};
use crate::hierarchy::Tracer;
use crate::integrator::camera_ray::pixel_key;
use crate::integrator::transmittance;
use crate::light::Light;
use crate::math::Vec3;
use crate::ray::{PrimitiveId, RayFilter};
use crate::sampling::hash_pair;
use crate::settings::{Settings, ShadowMode};
use crate::view::SceneView;

/// Key of the random numbers of the first light; the others follow.
const FIRST_LIGHT_DIMENSION: u32 = 0x100;

/// Light from all lights, or from all but lamps and some lamps that are drawn, shadowed, times the surface's colours. `path` keys
/// the random numbers of the point within sample `sample` of pixel (x, y); `shadow_rays` counts. It is for points that
/// [take light](super::takes_light): for others it is black.
///
/// This is one point at a time. Schedulers that take many points call the parts: [`light_key`], then [`LightLanes`] or
/// [`gather`], then [`shade_direct`], for the lights and the sides of the point in the same order. Lamps that are drawn, by
/// [`draw_lamp`], follow the lights that are sampled each.
#[inline(always)]
pub fn direct_light<T: Tracer, const W: usize>(
    view: &SceneView,
    tracer: &T,
    point: &LitPoint,
    path: u32,
    (x, y, sample): (u32, u32, u32),
    shadow_rays: &mut u64,
) -> Vec3 {
    let key = point_key(view.settings, path, x, y);
    let sides = 1 + is_lit_from_behind(view.settings, point.transmission) as u32;
    let mut sum = Vec3::ZERO;
    let turns = LightTurns::new(view);
    let mut turn = 0;
    while turn < turns.all {
        let samples = turns.samples(view, turn);
        let mut side = 0;
        while side < sides {
            if let Some(turn) = turns.light(view, point, (key, sample), turn, side) {
                let LightTurn { light, receiver, filter, specular, .. } = &turn;
                let got = if W > 1 && samples > 1 {
                    gather::<T, W>(view, tracer, (light, samples), receiver, filter, shadow_rays)
                } else {
                    gather::<T, 1>(view, tracer, (light, samples), receiver, filter, shadow_rays)
                };
                sum += shade_direct(light.le(), point.diffuse, *specular, point.transmission, side, &got);
            }
            side += 1;
        }
        turn += 1;
    }
    sum
}

/// The lights that points are lit by, one after the other: those that are sampled each, and then lamps that are drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightTurns {
    /// How many are sampled each.
    alone: u32,
    /// How many turns there are.
    pub(super) all: u32,
}

/// A light, and a side of a point that is lit by it.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightTurn<'a> {
    /// The light.
    pub(super) light: &'a Light,
    /// Its number.
    pub(super) number: u32,
    /// The side of the point, with the number of the first sample.
    pub(super) receiver: Receiver,
    /// What shadow rays leave out.
    filter: RayFilter,
    /// The colour of the highlight.
    pub(super) specular: Vec3,
}

impl LightTurns {
    /// Those of a scene.
    #[inline(always)]
    pub(super) fn new(view: &SceneView) -> LightTurns {
        let alone = lights_alone(view);
        let draws = if are_lamps_drawn(view) { view.settings.lamp_samples } else { 0 };
        LightTurns { alone, all: alone + draws }
    }

    /// The first lamp stands for one that is drawn: surfaces answer all of them alike, and all have as many samples.
    #[inline(always)]
    fn slot(&self, turn: u32) -> u32 {
        if turn < self.alone { turn } else { self.alone }
    }

    /// Samples of the light of a turn.
    #[inline(always)]
    pub(super) fn samples(&self, view: &SceneView, turn: u32) -> u32 {
        // By `get`, which has no panic for GPUs.
        match view.lights.get(self.slot(turn) as usize) {
            Some(light) => light.samples(),
            None => 0,
        }
    }

    /// The colour of the highlight of a turn's light on a point.
    #[inline(always)]
    pub(super) fn specular(&self, view: &SceneView, point: &LitPoint, turn: u32) -> Option<Vec3> {
        let light = view.lights.get(self.slot(turn) as usize)?;
        Some(highlight(light, point.specular, point.lamp_highlights, &point.lobe).0)
    }

    /// The light of a turn for a side of a point, which has this key ([`point_key`]) and is of this sample of its pixel; `None`
    /// where no lamp reaches it.
    #[inline(always)]
    pub(super) fn light<'a>(
        &self,
        view: &SceneView<'a>,
        point: &LitPoint,
        (key, sample): (u32, u32),
        turn: u32,
        side: u32,
    ) -> Option<LightTurn<'a>> {
        let slot = self.slot(turn);
        let light = view.lights.get(slot as usize)?;
        let (specular, highlights) = highlight(light, point.specular, point.lamp_highlights, &point.lobe);
        let is_drawn = turn >= self.alone;
        let mut number = slot;
        let mut receiver = Receiver {
            key: light_key(key, slot, side),
            first: if is_drawn { sample } else { sample.wrapping_mul(light.samples()) },
            ..point.receiver(side, highlights)
        };
        if is_drawn {
            (number, receiver) = draw_lamp(view, &receiver, turn - self.alone)?;
        }
        let light = view.lights.get(number as usize)?;
        Some(LightTurn { light, number, receiver, filter: shadow_filter(light, point.id), specular })
    }
}

/// Whether a surface of these colours answers light by itself. Mirrors and glass do not: no ray need be traced to find
/// that out.
#[inline(always)]
pub fn answers_light(diffuse: Vec3, specular: Vec3) -> bool {
    !((diffuse.max_component() <= 0.0) & (specular.max_component() <= 0.0))
}

/// Whether a surface has a second side (number 1) that is lit too.
#[inline(always)]
pub fn is_lit_from_behind(settings: &Settings, transmission: Vec3) -> bool {
    settings.light_from_behind & (transmission.max_component() > 0.0)
}

/// The colour of a light's highlight on a surface, and whether there is one. Lamps are reflected by the lobe where there is one:
/// its rays meet them, too, so that a highlight besides would count them twice.
#[inline(always)]
pub fn highlight(light: &Light, specular: Vec3, lamp_highlights: bool, lobe: &LampLobe) -> (Vec3, bool) {
    let is_lamp = light.is_lamp();
    if is_lamp & lobe.is_there() {
        return (lobe.color, lobe.color.max_component() > 0.0);
    }
    (specular, (specular.max_component() > 0.0) & (lamp_highlights | !is_lamp))
}

/// The key of the random numbers of a surface point that was found at the end of `path`.
#[inline(always)]
pub fn point_key(settings: &Settings, path: u32, x: u32, y: u32) -> u32 {
    hash_pair(pixel_key(settings.seed, x, y), path)
}

/// The key of the samples of a light at one side of the point with this key.
#[inline(always)]
pub fn light_key(point_key: u32, light: u32, side: u32) -> u32 {
    let key = hash_pair(point_key, FIRST_LIGHT_DIMENSION + light);
    if side == 0 { key } else { hash_pair(key, side) }
}

/// What shadow rays from a primitive towards a light leave out.
#[inline(always)]
pub fn shadow_filter(light: &Light, from: PrimitiveId) -> RayFilter {
    // A light is not lit by itself: its samples lie in its own plane.
    RayFilter { start: from, target: light.primitive(), cull_back_faces: false }
}

/// Sums over the samples of a light, each weighted by what gets through: `N.L` and the highlight's lobe.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightSums {
    /// `N.L`.
    pub diffuse: Vec3,
    /// The highlight.
    pub specular: Vec3,
}

impl LightSums {
    /// Adds a sample's weights, times what gets through.
    #[inline(always)]
    pub fn add(&mut self, through: Vec3, diffuse: f32, specular: f32) {
        self.diffuse += through * diffuse;
        self.specular += through * specular;
    }
}

/// What a surface of these colours makes of light of this colour on a side.
#[inline(always)]
pub fn shade_direct(
    color: Vec3,
    diffuse: Vec3,
    specular: Vec3,
    transmission: Vec3,
    side: u32,
    got: &LightSums,
) -> Vec3 {
    if side == 0 {
        color * (diffuse * got.diffuse + specular * got.specular)
    } else {
        color * (transmission * (diffuse * got.diffuse))
    }
}

/// The first `count` samples of a light at one point, `W` at a time, and the last ones by 16 or 4 lanes: some of the others would
/// be idle. Weights are added sample by sample, so `W` does not change the sums.
#[inline(always)]
pub fn gather<T: Tracer, const W: usize>(
    view: &SceneView,
    tracer: &T,
    (light, count): (&Light, u32),
    receiver: &Receiver,
    filter: &RayFilter,
    shadow_rays: &mut u64,
) -> LightSums {
    let mut gatherer = Gatherer { view, tracer, light, receiver, filter, sum: Sum::default() };
    let mut start = 0;
    while start < count {
        let left = count - start;
        let (rays, lanes) = if W > 4 && left <= 4 {
            (gatherer.add::<4>(start, left), 4)
        } else if W > 16 && left < W as u32 {
            (gatherer.add::<16>(start, left), 16)
        } else {
            (gatherer.add::<W>(start, left), W as u32)
        };
        *shadow_rays += rays;
        start += lanes;
    }
    gatherer.sum.gathered(view.settings.shadow_mode == ShadowMode::Coloured)
}

struct Gatherer<'a, T> {
    view: &'a SceneView<'a>,
    tracer: &'a T,
    light: &'a Light,
    receiver: &'a Receiver,
    filter: &'a RayFilter,
    sum: Sum,
}

/// Where shadows have no colour, all channels are the same number: one is added up.
#[derive(Clone, Copy, Default)]
struct Sum {
    diffuse: f32,
    specular: f32,
    coloured: LightSums,
}

impl Sum {
    #[inline(always)]
    fn gathered(&self, is_coloured: bool) -> LightSums {
        if is_coloured {
            self.coloured
        } else {
            LightSums { diffuse: Vec3::splat(self.diffuse), specular: Vec3::splat(self.specular) }
        }
    }
}

impl<T: Tracer> Gatherer<'_, T> {
    /// Adds the samples that follow the first `start`, as many as there are lanes, at most `left`; returns the number
    /// of shadow rays.
    #[inline(always)]
    fn add<const W: usize>(&mut self, start: u32, left: u32) -> u64 {
        let first = self.receiver.first.wrapping_add(start);
        let lanes =
            LightLanes::<W>::new(self.view.settings, self.light, &Receiver { first, ..*self.receiver });
        let mut active = [false; W];
        let mut any = 0;
        for lane in 0..W {
            active[lane] = ((lane as u32) < left) & lanes.brings(lane);
            any += active[lane] as u32;
        }
        if any == 0 {
            return 0;
        }
        let mode = self.view.settings.shadow_mode;
        let rays = lanes.from_one_point(self.receiver.origin);
        let mut hidden = [false; W];
        if mode != ShadowMode::None {
            hidden = self.tracer.occluded_batch(&rays, self.filter, &active);
        }
        if mode == ShadowMode::Coloured {
            for lane in 0..W {
                if active[lane] {
                    let (ray, filter) = (rays.ray(lane), self.filter);
                    let through = if hidden[lane] {
                        transmittance(self.view, self.tracer, &ray, filter)
                    } else {
                        Vec3::ONE
                    };
                    self.sum.coloured.add(through, lanes.diffuse[lane], lanes.specular[lane]);
                }
            }
        } else {
            // No branch: adding 0 changes nothing.
            for lane in 0..W {
                let lit = active[lane] & !hidden[lane];
                self.sum.diffuse += if lit { lanes.diffuse[lane] } else { 0.0 };
                self.sum.specular += if lit { lanes.specular[lane] } else { 0.0 };
            }
        }
        if mode == ShadowMode::None { 0 } else { any as u64 }
    }
}
