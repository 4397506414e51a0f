//! Samples of one light, several at a time, before shadowing: of one surface point or of as many points.
//!
//! One short loop a step, each over arrays and free of branches: that is the form in which compilers turn loops into SIMD
//! code. With one lane it is plain scalar code, with the same bits.

use super::Receivers;
use crate::bsdf::specular_lobe;
use crate::hierarchy::ShadowBatch;
use crate::intersect::precise::{dot64, double, minus64};
use crate::light::Light;
use crate::light::{LightSample, sample_light, triangle_sample};
use crate::math::{Vec3, fma, max, vec3};
use crate::ray::Ray;
use crate::sampling::{point_2d, triangle_point};
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

/// The plane of a light triangle is off its samples by less than this (4 · 2^-24) times the lengths of its edges.
const OFF_PLANE: f32 = 1.0 / 4_194_304.0;

/// Where a ray that goes to a light triangle ends: the last number before it meets the triangle's plane, so that what lies on
/// the light does not hide it and what stands before it does.
#[inline(always)]
fn end_at_plane(origin: Vec3, direction: Vec3, v0: Vec3, normal: Vec3, off_plane: f32) -> f32 {
    let normal = double(normal);
    let height = dot64(normal, minus64(double(v0), double(origin))).abs() - off_plane as f64;
    let t = (height / dot64(normal, double(direction)).abs()) as f32;
    fma(t, -1.0 / 16_777_216.0, t)
}

/// Where a ray that goes to a point ends. Its direction is rounded, and its length is not quite 1.
#[inline(always)]
fn end_at_point(origin: Vec3, direction: Vec3, point: Vec3) -> f32 {
    let (way, direction) = (minus64(double(point), double(origin)), double(direction));
    (dot64(way, direction) / dot64(direction, direction)) as f32
}

impl<const W: usize> LightLanes<W> {
    /// One sample of the light in each lane.
    #[inline(always)]
    pub fn new<R: Receivers>(settings: &Settings, light: &Light, receivers: &R) -> LightLanes<W> {
        let none = [0.0; W];
        let mut lanes = LightLanes { direction: [none; 3], t_max: none, diffuse: none, specular: none };
        let mut weight = [0.0; W];
        lanes.sample(settings, light, receivers, &mut weight);
        lanes.weigh(settings.lighting_model, receivers, &weight);
        if light.is_lamp() & receivers.any_lobes() {
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

    /// Directions, distances and weights.
    #[inline(always)]
    fn sample<R: Receivers>(
        &mut self,
        settings: &Settings,
        light: &Light,
        receivers: &R,
        weight: &mut [f32; W],
    ) {
        match *light {
            Light::Triangle { v0, e1, e2, normal, area, samples, .. } => {
                let (mut u, mut v) = ([0.0; W], [0.0; W]);
                for lane in 0..W {
                    [u[lane], v[lane]] = point_2d(receivers.index(lane), receivers.key(lane));
                }
                let power = area / samples as f32;
                for lane in 0..W {
                    let [b1, b2] = triangle_point([u[lane], v[lane]]);
                    let offset = v0.plus_scaled(e1, b1).plus_scaled(e2, b2) - receivers.origin(lane);
                    weight[lane] = self.take(lane, triangle_sample(offset, normal, power));
                }
                let (a, b) = (e1.abs(), e2.abs());
                let off_plane = OFF_PLANE * ((a.x + a.y + a.z) + (b.x + b.y + b.z));
                for lane in 0..W {
                    let (origin, direction) = (receivers.origin(lane), self.direction(lane));
                    self.t_max[lane] = end_at_plane(origin, direction, v0, normal, off_plane);
                }
            }
            // An arm for each kind, so that none is chosen inside the loop.
            light @ Light::Point { position, .. } => {
                self.sample_each(settings, &light, receivers, weight);
                self.end_at(position, receivers);
            }
            light @ Light::Directional { .. } => self.sample_each(settings, &light, receivers, weight),
            light @ Light::Spot { position, .. } => {
                self.sample_each(settings, &light, receivers, weight);
                self.end_at(position, receivers);
            }
        }
    }

    /// The same for a light without size.
    #[inline(always)]
    fn sample_each<R: Receivers>(
        &mut self,
        settings: &Settings,
        light: &Light,
        receivers: &R,
        weight: &mut [f32; W],
    ) {
        let falloff = settings.light_falloff;
        for lane in 0..W {
            weight[lane] = self.take(lane, sample_light(light, receivers.origin(lane), falloff));
        }
    }

    /// Ends the rays at a point.
    #[inline(always)]
    fn end_at<R: Receivers>(&mut self, point: Vec3, receivers: &R) {
        for lane in 0..W {
            self.t_max[lane] = end_at_point(receivers.origin(lane), self.direction(lane), point);
        }
    }

    /// Direction and distance of a sample; returns its weight.
    #[inline(always)]
    fn take(&mut self, lane: usize, sample: LightSample) -> f32 {
        self.direction[0][lane] = sample.to_light.x;
        self.direction[1][lane] = sample.to_light.y;
        self.direction[2][lane] = sample.to_light.z;
        self.t_max[lane] = sample.distance;
        sample.weight
    }

    /// The surface's answer.
    #[inline(always)]
    fn weigh<R: Receivers>(&mut self, model: LightingModel, receivers: &R, weight: &[f32; W]) {
        let mut lit = [0.0; W];
        for lane in 0..W {
            let to_light = self.direction(lane);
            let cos = receivers.normal(lane).dot(to_light);
            let reached = (cos > 0.0) & (receivers.above(lane).dot(to_light) > 0.0);
            lit[lane] = if reached { weight[lane] } else { 0.0 };
            self.diffuse[lane] = lit[lane] * max(cos, 0.0);
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
            let lobe =
                specular_lobe(model, normal, to_viewer, self.direction(lane), receivers.shininess(lane));
            self.specular[lane] = if receivers.highlights(lane) { lit[lane] * lobe } else { 0.0 };
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
