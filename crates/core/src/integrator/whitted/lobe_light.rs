//! Lamps in glossy lobes. Lamps are sampled, and rays of the lobe may meet one: each way gets a share of the lamp's radiance, so
//! that nothing counts twice and a small bright lamp that a ray happens to meet makes no bright dot.
//!
//! Shares are those of the balance heuristic (Veach and Guibas 1995, "Optimally combining sampling techniques for Monte Carlo
//! rendering", section 3): each way's by how densely it samples the direction. They add up to one.

use super::are_lamps_drawn;
use super::children::{Mirror, glossy_lobe, reflected_share};
use super::direct_light::answers_light;
use crate::bsdf::{Delta, Lobe};
use crate::geometry::Instance;
use crate::integrator::PathRay;
use crate::light::{LightReceiver, light_of_primitive};
use crate::material::NONE;
use crate::math::Vec3;
use crate::settings::{Settings, ShadowMode};
use crate::shading::SurfacePoint;
use crate::view::{SceneView, item};

/// How a surface point reflects lamps: by the lobe that its glossy rays are distributed by.
#[derive(Clone, Copy, Debug)]
pub struct LampLobe {
    /// The lobe; where there is none, a direction that no light comes from.
    pub lobe: Lobe,
    /// Rays that are traced of it; where there is no lobe, 0.
    pub rays: f32,
    /// What is reflected, times the radiance of a lamp over the colour of its light.
    pub color: Vec3,
}

impl LampLobe {
    /// None.
    pub const NONE: LampLobe =
        LampLobe { lobe: Lobe::Delta(Delta { direction: Vec3::ZERO }), rays: 0.0, color: Vec3::ZERO };

    /// The lobe at a point that `ray` found, where rays of it will be traced and there are lights.
    #[inline(always)]
    pub fn new(view: &SceneView, point: &SurfacePoint, ray: &PathRay, depth_limit: u32) -> LampLobe {
        let look = &point.material_values;
        let rays = look.lobe_rays(ray.depth);
        let is_lobe = (rays > 0) & (ray.depth < depth_limit) & look.reflects();
        if !is_lobe | view.lights.is_empty() | !view.settings.lighting_model.is_lit() {
            return LampLobe::NONE;
        }
        let mirror = Mirror::new(view.settings, point, ray.direction);
        LampLobe {
            lobe: glossy_lobe(mirror.direction, look),
            rays: rays as f32,
            color: reflected_share(look, &mirror) * view.settings.lamp_radiance,
        }
    }

    /// Whether there is one.
    #[inline(always)]
    pub fn is_there(&self) -> bool {
        self.rays > 0.0
    }

    /// What a sample of a lamp brings: its weight times the density of the lobe, and the share of this way.
    #[inline(always)]
    pub fn weigh(&self, weight: f32, to_light: Vec3) -> f32 {
        let density = self.lobe.pdf(to_light);
        // The weight is one over the density of all samples of the lamp.
        weight * density / (1.0 + self.rays * density * weight)
    }
}

/// Whether lights are sampled for a point: surfaces that are black in every way are not asked about.
#[inline(always)]
pub fn takes_light(point: &SurfacePoint, lobe: &LampLobe) -> bool {
    answers_light(point.material_values.diffuse, point.material_values.specular)
        | (lobe.color.max_component() > 0.0)
}

/// Whether what a ray of a lobe finds behind a surface is found by sampling lamps, too: where shadow rays pass it.
#[inline(always)]
pub(super) fn lamps_shine_through(settings: &Settings) -> bool {
    settings.shadow_mode == ShadowMode::Coloured
}

/// The share of a lamp's radiance that a ray brings which found it this far from where it left the lobe's surface. It is all where
/// the ray is of no lobe and where what shines is no lamp that is sampled.
#[inline(always)]
pub(super) fn lamp_share(view: &SceneView, point: &SurfacePoint, ray: &PathRay, distance: f32) -> f32 {
    if !(ray.lobe_density > 0.0) | !point.front | (point.material_values.emission.max_component() <= 0.0) {
        return 1.0;
    }
    // Textured lamps are not sampled, and neither are spheres.
    let instance = item(view.instances, point.id.instance);
    let geometry = item(view.geometries, instance.geometry);
    let is_textured = item(view.materials, point.material).emission_texture != NONE;
    if is_textured | (point.id.primitive >= geometry.triangle_count) {
        return 1.0;
    }
    let corners = item(view.triangles, geometry.first_triangle + point.id.primitive);
    let area = facing_area(corners, instance, point.id.instance == 0, ray.direction);
    let mut draws = view.settings.lamp_samples as f32;
    if are_lamps_drawn(view) {
        let Some(light) = light_of_primitive(view.lights, point.id) else { return 1.0 };
        let position = point.position.plus_scaled(ray.direction, -distance);
        let from = LightReceiver { position, normal: Vec3::ZERO };
        draws *= view.light_tree().chance(&from, light);
    }
    let density = ray.lobe_density * (area / (draws * (distance * distance)));
    // Density over density plus 1; infinite ones, too. What is no number brings nothing.
    if density <= 1.0 {
        density / (1.0 + density)
    } else if density > 1.0 {
        1.0 / (1.0 + 1.0 / density)
    } else {
        0.0
    }
}

/// The area of a triangle as a direction sees it.
#[inline(always)]
fn facing_area(corners: &[Vec3; 3], instance: &Instance, is_world: bool, direction: Vec3) -> f32 {
    let [mut a, mut b, mut c] = *corners;
    if !is_world {
        let map = &instance.world_from_object;
        (a, b, c) = (map.point(a), map.point(b), map.point(c));
    }
    ((b - a).cross(c - a).dot(direction) * 0.5).abs()
}
