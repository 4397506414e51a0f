//! Samples of one light, several at a time, before shadowing: of one surface point or of as many points.
//!
//! One short loop a step, each over arrays and free of branches: that is the form in which compilers turn loops into SIMD
//! code. With one lane it is plain scalar code, with the same bits.

use super::Receivers;
use crate::bsdf::{Lambert, Lobe};
use crate::hierarchy::ShadowBatch;
use crate::light::{Light, LightSampleLanes, TriangleLampLanes};
use crate::math::{Vec3, vec3};
use crate::ray::Ray;
use crate::sampling::point_2d;
use crate::settings::{LightingModel, Settings};

/// Shadow rays and what each brings if nothing is in its way.
#[derive(Clone, Copy, Debug)]
pub struct LightLanes<const W: usize> {
    /// Unit vectors to the light's points: x of every lane, y, z.
    pub direction: [[f32; W]; 3],
    /// Shadow rays end here, just before the light.
    pub t_max: [f32; W],
    /// Weight times `N.L`; 0 where the light does not reach the surface.
    pub diffuse: [f32; W],
    /// Weight times the highlight's lobe.
    pub specular: [f32; W],
}

impl<const W: usize> LightLanes<W> {
    /// Of no light.
    pub const NONE: LightLanes<W> =
        LightLanes { direction: [[0.0; W]; 3], t_max: [0.0; W], diffuse: [0.0; W], specular: [0.0; W] };

    /// Puts the only sample of another here, in a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, sample: &LightLanes<1>) {
        for axis in 0..3 {
            self.direction[axis][lane] = sample.direction[axis][0];
        }
        self.t_max[lane] = sample.t_max[0];
        (self.diffuse[lane], self.specular[lane]) = (sample.diffuse[0], sample.specular[0]);
    }

    /// One sample of the light in each lane.
    #[inline(always)]
    pub fn new<R: Receivers>(settings: &Settings, light: &Light, receivers: &R) -> LightLanes<W> {
        let random = |lane| point_2d(receivers.index(lane), receivers.key(lane));
        let sample =
            LightSampleLanes::new(light, settings.light_falloff, |lane| receivers.origin(lane), random);
        let scale = [receivers.scale(); W];
        LightLanes::of_samples(settings, sample, &scale, light.is_lamp(), receivers)
    }

    /// One sample of another triangle in each lane; `scale` takes the place of the receivers'.
    #[inline(always)]
    pub fn of_triangles<R: Receivers>(
        settings: &Settings,
        lamps: &TriangleLampLanes<W>,
        scale: &[f32; W],
        receivers: &R,
    ) -> LightLanes<W> {
        let random = |lane| point_2d(receivers.index(lane), receivers.key(lane));
        let sample =
            LightSampleLanes::of_triangles(|lane| lamps.get(lane), |lane| receivers.origin(lane), random);
        LightLanes::of_samples(settings, sample, scale, true, receivers)
    }

    #[inline(always)]
    fn of_samples<R: Receivers>(
        settings: &Settings,
        sample: LightSampleLanes<W>,
        scale: &[f32; W],
        is_lamp: bool,
        receivers: &R,
    ) -> LightLanes<W> {
        let none = [0.0; W];
        let LightSampleLanes { to_light: direction, t_max, mut weight } = sample;
        for lane in 0..W {
            weight[lane] *= scale[lane];
        }
        let mut lanes = LightLanes { direction, t_max, diffuse: none, specular: none };
        lanes.weigh(settings.lighting_model, receivers, &weight);
        if is_lamp & receivers.any_lobes() {
            lanes.weigh_lobes(receivers, &weight);
        }
        lanes
    }

    /// Whether the light brings anything in a lane, where nothing is in the way.
    #[inline(always)]
    pub fn brings(&self, lane: usize) -> bool {
        (self.diffuse[lane] > 0.0) | (self.specular[lane] > 0.0)
    }

    /// The rays, where all lanes are of one point.
    #[inline(always)]
    pub fn from_one_point(&self, origin: Vec3) -> ShadowBatch<W> {
        let [x, y, z] = self.direction;
        ShadowBatch { origin, x, y, z, t_max: self.t_max }
    }

    /// The ray of a lane, where it starts from `origin`.
    #[inline(always)]
    pub fn ray(&self, lane: usize, origin: Vec3) -> Ray {
        Ray { origin, t_min: 0.0, direction: self.direction(lane), t_max: self.t_max[lane] }
    }

    /// The surface's answer.
    #[inline(always)]
    fn weigh<R: Receivers>(&mut self, model: LightingModel, receivers: &R, weight: &[f32; W]) {
        let mut lit = [0.0; W];
        for lane in 0..W {
            let to_light = self.direction(lane);
            let cos = Lambert { normal: receivers.normal(lane) }.eval(to_light);
            let reached = (cos > 0.0) & (receivers.above(lane).dot(to_light) > 0.0);
            lit[lane] = if reached { weight[lane] } else { 0.0 };
            self.diffuse[lane] = lit[lane] * cos;
        }
        if receivers.any_highlights() {
            // A loop for each model, so that none is chosen inside.
            match model {
                LightingModel::Phong => self.highlight(LightingModel::Phong, receivers, &lit),
                LightingModel::BlinnPhong => self.highlight(LightingModel::BlinnPhong, receivers, &lit),
                LightingModel::Distance | LightingModel::Diffuse | LightingModel::Lambert => {}
            }
        }
    }

    #[inline(always)]
    fn highlight<R: Receivers>(&mut self, model: LightingModel, receivers: &R, lit: &[f32; W]) {
        for lane in 0..W {
            let (normal, to_viewer) = (receivers.normal(lane), receivers.to_viewer(lane));
            // No `map_or`: its closure would be compiled without the caller's instruction set.
            let factor = match Lobe::highlight(model, normal, to_viewer, receivers.shininess(lane)) {
                Some(lobe) => lobe.eval(self.direction(lane)),
                None => 0.0,
            };
            self.specular[lane] = if receivers.highlights(lane) { lit[lane] * factor } else { 0.0 };
        }
    }

    /// What lobes reflect of a lamp, in place of highlights. Rays of a lobe ask for the surface's own normal alone.
    #[inline(always)]
    fn weigh_lobes<R: Receivers>(&mut self, receivers: &R, weight: &[f32; W]) {
        for lane in 0..W {
            let lobe = receivers.lobe(lane);
            if lobe.is_there() {
                let to_light = self.direction(lane);
                let reached = receivers.highlights(lane) & (receivers.above(lane).dot(to_light) > 0.0);
                self.specular[lane] = if reached { lobe.weigh(weight[lane], to_light) } else { 0.0 };
            }
        }
    }

    #[inline(always)]
    fn direction(&self, lane: usize) -> Vec3 {
        let [x, y, z] = &self.direction;
        vec3(x[lane], y[lane], z[lane])
    }
}
