//! Samples of lights for several points at a time.
//!
//! What lanes do alike stands in short loops over arrays, free of branches, which become SIMD code. Lights of other kinds than
//! triangles without textures and the environment are sampled lane by lane.

use super::NumbersOfLanes;
use super::light::{LightChoice, LightDraw, Strength, choose_lanes, draw_light, share_of_environment};
use crate::environment::PlaceLanes;
use crate::light::{Light, LightReceiver, LightSampleLanes, TriangleLamp};
use crate::material::NONE;
use crate::math::Vec3Lanes;
use crate::ray::PrimitiveId;
use crate::view::SceneView;

/// Samples of lights that were drawn.
pub(super) struct DrawLanes<const W: usize> {
    to_light: Vec3Lanes<W>,
    radiance: Vec3Lanes<W>,
    density: [f32; W],
    t_max: [f32; W],
    target: [PrimitiveId; W],
    is_there: [bool; W],
}

impl<const W: usize> DrawLanes<W> {
    /// Samples of the lights that lanes choose, where `is_wanted`: as [`super::sample_light`] draws them for receivers, seen from
    /// `origin`.
    #[inline(always)]
    pub(super) fn new(
        view: &SceneView,
        is_wanted: &[bool; W],
        receiver: impl Fn(usize) -> LightReceiver,
        origin: &Vec3Lanes<W>,
        numbers: &impl NumbersOfLanes<W>,
    ) -> DrawLanes<W> {
        let mut draws = DrawLanes {
            to_light: Vec3Lanes::ZERO,
            radiance: Vec3Lanes::ZERO,
            density: [0.0; W],
            t_max: [0.0; W],
            target: [PrimitiveId::NONE; W],
            is_there: [false; W],
        };
        let mut lamps = LampLanes::<W>::new();
        let mut is_environment = [false; W];
        let mut is_any_environment = false;
        let (choice, second_place) = numbers.lights();
        let chosen = choose_lanes(view, is_wanted, receiver, &choice);
        for lane in 0..W {
            let Some(LightChoice { light, chance, place }) = chosen[lane] else { continue };
            if !is_wanted[lane] {
                continue;
            }
            match light {
                Some(light) => {
                    if !lamps.take(lane, light, chance, place) {
                        let place = [place, second_place[lane]];
                        draws.set(lane, draw_light(view, light, chance, origin.get(lane), place));
                    }
                }
                None => (is_environment[lane], is_any_environment) = (true, true),
            }
        }
        if lamps.is_any {
            let samples = LightSampleLanes::<W>::of_triangles(
                |lane| lamps.lamp(lane),
                |lane| origin.get(lane),
                |lane| [lamps.place[lane], second_place[lane]],
            );
            for lane in 0..W {
                let weight = samples.weight[lane] / lamps.chance[lane];
                let strength = Strength::new(view.settings, lamps.color.get(lane), weight, true);
                if lamps.is_there[lane] {
                    let (to_light, t_max) = (samples.direction(lane), samples.t_max[lane]);
                    draws.set(lane, LightDraw { to_light, t_max, target: lamps.target[lane], strength });
                }
            }
        }
        if is_any_environment {
            draws.set_environment(view, &is_environment, &choice, &numbers.fine_places());
        }
        draws
    }

    /// As [`super::light::draw_environment`].
    #[inline(always)]
    fn set_environment(
        &mut self,
        view: &SceneView,
        is_environment: &[bool; W],
        choice: &[f64; W],
        fine_place: &[f64; W],
    ) {
        let environment = view.environment;
        let mut u = [[0.0; W], *fine_place];
        for lane in 0..W {
            u[0][lane] = if is_environment[lane] { share_of_environment(view, choice[lane]) } else { 0.0 };
        }
        let sample = environment.sample_lanes(view.environment_table, &u);
        let places = PlaceLanes::new(environment, &sample.to_light);
        let radiance = environment.radiance_lanes(&view.textures(), &places, is_environment);
        for lane in 0..W {
            let density = environment.chance * sample.density[lane];
            let draw = LightDraw::of_environment(sample.to_light.get(lane), radiance.get(lane), density);
            if is_environment[lane] {
                self.set(lane, draw);
            }
        }
    }

    /// Whether a light was chosen.
    #[inline(always)]
    pub(super) fn is_there(&self, lane: usize) -> bool {
        self.is_there[lane]
    }

    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> LightDraw {
        LightDraw {
            to_light: self.to_light.get(lane),
            t_max: self.t_max[lane],
            target: self.target[lane],
            strength: Strength { radiance: self.radiance.get(lane), density: self.density[lane] },
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, draw: LightDraw) {
        self.to_light.set(lane, draw.to_light);
        self.radiance.set(lane, draw.strength.radiance);
        self.density[lane] = draw.strength.density;
        self.t_max[lane] = draw.t_max;
        self.target[lane] = draw.target;
        self.is_there[lane] = true;
    }
}

/// Triangles without textures that were chosen as lights.
struct LampLanes<const W: usize> {
    corner: Vec3Lanes<W>,
    edges: [Vec3Lanes<W>; 2],
    normal: Vec3Lanes<W>,
    color: Vec3Lanes<W>,
    area: [f32; W],
    samples: [u32; W],
    is_two_sided: [bool; W],
    chance: [f32; W],
    /// The first coordinate of the point that is sampled.
    place: [f32; W],
    target: [PrimitiveId; W],
    is_there: [bool; W],
    is_any: bool,
}

impl<const W: usize> LampLanes<W> {
    #[inline(always)]
    fn new() -> LampLanes<W> {
        let zero = Vec3Lanes::ZERO;
        LampLanes {
            corner: zero,
            edges: [zero; 2],
            normal: zero,
            color: zero,
            area: [0.0; W],
            samples: [1; W],
            is_two_sided: [false; W],
            chance: [1.0; W],
            place: [0.0; W],
            target: [PrimitiveId::NONE; W],
            is_there: [false; W],
            is_any: false,
        }
    }

    /// Takes a light that was chosen with this chance, where it is such a triangle.
    #[inline(always)]
    fn take(&mut self, lane: usize, light: &Light, chance: f32, place: f32) -> bool {
        let Light::Triangle { texture: NONE, v0, e1, e2, normal, area, color, samples, is_two_sided, .. } =
            *light
        else {
            return false;
        };
        self.corner.set(lane, v0);
        self.edges[0].set(lane, e1);
        self.edges[1].set(lane, e2);
        self.normal.set(lane, normal);
        self.color.set(lane, color);
        (self.area[lane], self.samples[lane]) = (area, samples);
        self.is_two_sided[lane] = is_two_sided;
        self.chance[lane] = chance;
        self.place[lane] = place;
        self.target[lane] = light.primitive();
        self.is_there[lane] = true;
        self.is_any = true;
        true
    }

    #[inline(always)]
    fn lamp(&self, lane: usize) -> TriangleLamp {
        TriangleLamp {
            v0: self.corner.get(lane),
            e1: self.edges[0].get(lane),
            e2: self.edges[1].get(lane),
            normal: self.normal.get(lane),
            power: TriangleLamp::power(self.area[lane], self.samples[lane]),
            is_two_sided: self.is_two_sided[lane],
        }
    }
}
