//! Render settings → the settings that reach a pixel.

use crate::model::{LightUnits, PixelSampling, RenderSettings};
use eosphor_core::camera::Camera;
use eosphor_core::geometry::Bounds;
use eosphor_core::math::vec3;
use eosphor_core::settings::{PixelSampling as CoreSampling, Settings};

/// Whether anything but emission and the ambient term is black without a light.
pub(super) fn needs_light(settings: &RenderSettings) -> bool {
    settings.lighting.is_lit()
}

pub(super) fn build(settings: &RenderSettings, camera: &Camera, world: &Bounds) -> Settings {
    let (samples, grid_side, pixel_sampling) = match settings.pixel_sampling {
        PixelSampling::Center => (settings.samples, 1, CoreSampling::Center),
        PixelSampling::Random => (settings.samples, 1, CoreSampling::Random),
        PixelSampling::Grid(side) => (side * side, side, CoreSampling::Grid),
    };
    Settings {
        width: settings.size[0],
        height: settings.size[1],
        samples,
        grid_side,
        pixel_sampling,
        max_depth: settings.depth,
        energy_threshold: settings.energy_threshold,
        lighting_model: settings.lighting,
        shadow_mode: settings.shadows,
        fresnel: settings.fresnel,
        cull_back_faces: settings.cull_back_faces,
        light_from_behind: settings.light_from_behind,
        light_falloff: settings.light_falloff,
        lamp_samples: settings.light_samples,
        lamp_radiance: match settings.light_units {
            LightUnits::Physical => std::f32::consts::PI,
            LightUnits::Plain => 1.0,
        },
        ambient: settings.ambient,
        max_distance: settings.max_distance.unwrap_or_else(|| default_max_distance(camera, world)),
        background: settings.background,
        seed: settings.seed,
    }
}

/// The distance from the camera to the farthest corner of the scene's box over 1.5; 1 where there is none.
fn default_max_distance(camera: &Camera, world: &Bounds) -> f32 {
    if world.is_empty() {
        return 1.0;
    }
    let (a, b) = ((world.min - camera.eye).abs(), (world.max - camera.eye).abs());
    let distance = vec3(a.x.max(b.x), a.y.max(b.y), a.z.max(b.z)).length();
    if distance > 0.0 { distance / 1.5 } else { 1.0 }
}
