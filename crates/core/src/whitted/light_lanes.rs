//! Samples of one light at a surface point, several at a time, before shadowing.
//!
//! One short loop a step, each over arrays and free of branches: that is the form in which compilers turn loops into SIMD
//! code. With one lane it is plain scalar code, with the same bits.

use super::direct_light::Receiver;
use crate::hierarchy::ShadowBatch;
use crate::light::Light;
use crate::math::{Vec3, max, vec3};
use crate::sampling::{point_2d, triangle_point};
use crate::settings::LightingModel;
use crate::shading::{sample_light, specular_lobe, triangle_sample};

/// Shadow rays and what each brings if nothing is in its way.
#[derive(Clone, Copy)]
pub(super) struct LightLanes<const W: usize> {
    /// Unit directions and distances of the light's points.
    pub(super) rays: ShadowBatch<W>,
    /// Weight times `N.L`; 0 where the light does not reach the surface.
    pub(super) diffuse: [f32; W],
    /// Weight times the highlight's lobe.
    pub(super) specular: [f32; W],
}

/// Shadow rays end this share of the distance before the light.
const STOP_SHORT: f32 = 1.0 - 1.0 / 8192.0;

impl<const W: usize> LightLanes<W> {
    /// Samples `first .. first + W` of the light's sequence with this key.
    #[inline(always)]
    pub(super) fn new(
        receiver: &Receiver,
        light: &Light,
        key: u32,
        first: u32,
        origin: Vec3,
    ) -> LightLanes<W> {
        let none = [0.0; W];
        let rays = ShadowBatch { origin, x: none, y: none, z: none, t_max: none };
        let mut lanes = LightLanes { rays, diffuse: none, specular: none };
        let mut weight = [0.0; W];
        lanes.sample(receiver, light, key, first, &mut weight);
        lanes.weigh(receiver, &weight);
        lanes
    }

    /// Directions, distances and weights.
    #[inline(always)]
    fn sample(&mut self, receiver: &Receiver, light: &Light, key: u32, first: u32, weight: &mut [f32; W]) {
        let (origin, rays) = (self.rays.origin, &mut self.rays);
        if let Light::Triangle { v0, e1, e2, normal, area, samples, .. } = *light {
            let (mut u, mut v) = ([0.0; W], [0.0; W]);
            for lane in 0..W {
                [u[lane], v[lane]] = point_2d(first.wrapping_add(lane as u32), key);
            }
            let power = area / samples as f32;
            for lane in 0..W {
                let [b1, b2] = triangle_point([u[lane], v[lane]]);
                let s = triangle_sample(v0.along(e1, b1).along(e2, b2) - origin, normal, power);
                (rays.x[lane], rays.y[lane], rays.z[lane]) = (s.to_light.x, s.to_light.y, s.to_light.z);
                rays.t_max[lane] = s.distance * STOP_SHORT;
                weight[lane] = s.weight;
            }
        } else {
            let s = sample_light(light, origin, receiver.view.settings.light_falloff);
            for (lane, weight) in weight.iter_mut().enumerate() {
                (rays.x[lane], rays.y[lane], rays.z[lane]) = (s.to_light.x, s.to_light.y, s.to_light.z);
                rays.t_max[lane] = s.distance * STOP_SHORT;
                *weight = s.weight;
            }
        }
    }

    /// The surface's answer.
    #[inline(always)]
    fn weigh(&mut self, receiver: &Receiver, weight: &[f32; W]) {
        let (normal, above, to_viewer) = (receiver.normal, receiver.above, receiver.point.to_viewer);
        let mut lit = [0.0; W];
        for lane in 0..W {
            let to_light = self.direction(lane);
            let cos = normal.dot(to_light);
            let reached = (cos > 0.0) & (above.dot(to_light) > 0.0);
            lit[lane] = if reached { weight[lane] } else { 0.0 };
            self.diffuse[lane] = lit[lane] * max(cos, 0.0);
        }
        let exponent = receiver.point.look.shininess;
        let has_highlight = receiver.highlights;
        // A loop for each model, so that none is chosen inside.
        match receiver.view.settings.lighting_model {
            LightingModel::Phong if has_highlight => {
                for lane in 0..W {
                    let (model, l) = (LightingModel::Phong, self.direction(lane));
                    self.specular[lane] = lit[lane] * specular_lobe(model, normal, to_viewer, l, exponent);
                }
            }
            LightingModel::BlinnPhong if has_highlight => {
                for lane in 0..W {
                    let (model, l) = (LightingModel::BlinnPhong, self.direction(lane));
                    self.specular[lane] = lit[lane] * specular_lobe(model, normal, to_viewer, l, exponent);
                }
            }
            _ => {}
        }
    }

    #[inline(always)]
    fn direction(&self, lane: usize) -> Vec3 {
        vec3(self.rays.x[lane], self.rays.y[lane], self.rays.z[lane])
    }
}
