//! Render settings → the settings that reach a pixel.

use crate::model::{LightUnits, PixelSampling, RenderSettings};
use eosphor_core::camera::Camera;
use eosphor_core::geometry::Bounds;
use eosphor_core::material::Material;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::{Integrator, PixelSampling as CoreSampling, Settings, ShadowMode};
use eosphor_core::sums::MAX_RADIANCE;

/// Whether anything but emission and the ambient term is black without a light.
pub(super) fn needs_light(settings: &RenderSettings) -> bool {
    settings.lighting.is_lit()
}

/// What surrounds a scene in path tracing that has no light: grey, unless the settings bring light from all around themselves.
pub(super) fn surroundings(settings: &RenderSettings) -> Option<Vec3> {
    let is_dark = settings.background.max_component() <= 0.0 && settings.ambient <= 0.0;
    is_dark.then_some(Vec3::splat(RenderSettings::SURROUNDINGS))
}

/// The shadow mode that path tracing needs for these materials: coloured where light passes any.
pub(super) fn shadows_of_paths(materials: &[Material]) -> ShadowMode {
    if materials.iter().any(Material::is_passed_by_paths) { ShadowMode::Coloured } else { ShadowMode::Opaque }
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
        integrator: settings.integrator,
        roulette_depth: settings.roulette,
        clamp_indirect: settings.clamp_indirect.unwrap_or(MAX_RADIANCE),
        max_depth: settings.depth,
        energy_threshold: settings.energy_threshold,
        lighting_model: settings.lighting,
        shadow_mode: settings.shadows,
        fresnel: settings.fresnel,
        cull_back_faces: settings.cull_back_faces && settings.integrator == Integrator::Whitted,
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
