//! PG1's configuration files ("Raytracer with an acceleration structure and a GPU implementation", CTU FIT 2025): a
//! model, a camera and settings. What a file leaves open is as in the preset of that name.

mod cornell;
mod fault;
mod format;
mod keys;
#[cfg(test)]
mod tests;

pub(in crate::files) use cornell::cornell_pg1;
pub use keys::{ConfigKey, KeyUse, config_keys};

use crate::error::SceneError;
use crate::files::loader::Loader;
use crate::files::reference_systems::presets::{Preset, pg1_camera};
use crate::files::requests::SceneRequests;
use crate::model::{
    Camera, DeviceKind, DeviceSettings, Light, NormalMode, PixelSampling, RenderSettings, Scene, Structure,
    double,
};
use eosphor_core::settings::LightingModel;
use fault::{at, problem, wrong};
use format::{CameraEntry, Config, PointLight, RenderMode, RenderType, Renderer, SceneEntry};
use format::{ShadingType, StructureName};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Whether a JSON file is such a configuration: it has a renderer and a scene, and is not one of ours.
pub(in crate::files) fn is_config(bytes: &[u8]) -> bool {
    #[derive(Deserialize)]
    struct Keys {
        eosphor: Option<IgnoredAny>,
        renderer: Option<IgnoredAny>,
        scene: Option<IgnoredAny>,
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    serde_json::from_slice(bytes)
        .is_ok_and(|keys: Keys| keys.eosphor.is_none() && keys.renderer.is_some() && keys.scene.is_some())
}

/// Reads a configuration and its model into the loader.
pub(in crate::files) fn read(loader: &mut Loader, path: &Path) -> Result<(), SceneError> {
    let bytes = loader.read(path)?;
    let text = String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes));
    let config: Config = serde_json::from_str(&text).map_err(|e| wrong(path, &e))?;
    if config.obj_loader.triangulate == Some(false) {
        let line = fault::line_of_key(&text, "triangulate");
        loader.warnings.add(path, line, "faces become triangles whatever this says");
    }

    let model = find_model(loader, path, &text, &config)?;
    let instances = crate::files::read_model(loader, &model)?;
    loader.scene.instances.extend(instances);
    let scene = &mut loader.scene;
    scene.settle_origin();
    let SceneRequests { device, output, .. } = requests_of(&config);
    (scene.device, scene.output) = (device, output);
    let Config { seed, renderer, scene: SceneEntry { camera, point_lights, .. }, .. } = config;
    for PointLight { pos, color } in point_lights {
        scene.lights.push(Light::Point { position: scene.point_of_file(pos), color });
    }
    scene.camera = camera.as_ref().map(|camera| camera_of(camera, scene, path, &text)).transpose()?;
    Preset::Pg1.apply(scene);
    let settings = &mut scene.settings;
    settings.seed = seed.unwrap_or(settings.seed);
    set_renderer(settings, &renderer);
    if let Some(camera) = &camera {
        set_film(settings, camera);
    }
    scene.validate().map_err(|p| problem(path, &text, &p))
}

/// The model lies beside the configuration, or in the folder that it names.
fn find_model(loader: &Loader, path: &Path, text: &str, config: &Config) -> Result<PathBuf, SceneError> {
    let name = &config.scene.source_file;
    let beside = path.parent().unwrap_or(Path::new(""));
    let folder = config.obj_loader.basepath.as_ref().map(|base| beside.join(base.replace('\\', "/")));
    let found = folder.and_then(|folder| loader.find(&folder, name.as_bytes()));
    found.or_else(|| loader.find(beside, name.as_bytes())).ok_or_else(|| {
        let message = format!(
            "the model \"{name}\" is missing; source_file is relative to this file or to obj_loader.basepath"
        );
        at(path, fault::line_of_key(text, "source_file"), message)
    })
}

fn camera_of(entry: &CameraEntry, scene: &Scene, path: &Path, text: &str) -> Result<Camera, SceneError> {
    let default = pg1_camera();
    let fov_x_degrees = match entry.fov {
        None => default.fov_x_degrees,
        Some(radians) if radians > 0.0 && radians < PI => (radians * (180.0 / PI)) as f32,
        Some(radians) => {
            let message = format!("fov: {radians} must be over 0 and under 3.1415; it is in radians");
            return Err(at(path, fault::line_of_key(text, "fov"), message));
        }
    };
    Ok(Camera {
        position: scene.point_of_file(entry.pos.unwrap_or_else(|| double(default.position))),
        direction: entry.dir.unwrap_or(default.direction),
        up: entry.up.unwrap_or(default.up),
        fov_x_degrees,
        ..default
    })
}

fn set_renderer(settings: &mut RenderSettings, renderer: &Renderer) {
    if let Some(kind) = renderer.render_type {
        settings.lighting = match kind {
            RenderType::Distance => LightingModel::Distance,
            RenderType::Diffusion => LightingModel::Diffuse,
            RenderType::Phong => LightingModel::Phong,
            RenderType::BlinnPhong => LightingModel::BlinnPhong,
        };
    }
    if let Some(shading) = renderer.shading_type {
        settings.normals = match shading {
            ShadingType::Flat => NormalMode::Flat,
            ShadingType::Smooth => NormalMode::Smooth,
        };
    }
    settings.depth = renderer.max_depth.unwrap_or(settings.depth);
    settings.light_samples = renderer.samples_per_triangle.unwrap_or(settings.light_samples);
    settings.max_distance = renderer.max_distance.or(settings.max_distance);
    settings.cull_back_faces = renderer.cull_backfaces.unwrap_or(settings.cull_back_faces);
    settings.background = renderer.background_color.unwrap_or(settings.background);
}

fn set_film(settings: &mut RenderSettings, camera: &CameraEntry) {
    let [width, height] = settings.size;
    settings.size = [camera.width.unwrap_or(width), camera.height.unwrap_or(height)];
    settings.samples = camera.samples_per_pixel.unwrap_or(settings.samples);
    // One sample lies in the middle; PG1's "fuzzysampling" spreads several.
    settings.pixel_sampling =
        if settings.samples > 1 { PixelSampling::Random } else { PixelSampling::Center };
}

/// What the file asks for besides the picture.
pub(in crate::files) fn requests(bytes: &[u8]) -> SceneRequests {
    serde_json::from_slice(bytes).map(|config| requests_of(&config)).unwrap_or_default()
}

/// A structure has the limits beside it; PG1 ignores those beside "none", as this does.
fn requests_of(config: &Config) -> SceneRequests {
    let renderer = &config.renderer;
    let mut device = DeviceSettings {
        backend: renderer.render_mode.map(|mode| match mode {
            RenderMode::Cpu => DeviceKind::Cpu,
            RenderMode::Gpu => DeviceKind::Cuda,
        }),
        ..DeviceSettings::default()
    };
    if let Some(structure) = &renderer.acceleratied_data_structure {
        device.accel = Some(match structure.name {
            StructureName::None => Structure::None,
            StructureName::Octree => Structure::Octree,
            StructureName::OctreeParametric => Structure::OctreeParametric,
        });
        if structure.name != StructureName::None {
            (device.leaf_size, device.tree_depth) = (structure.max_triangles, structure.max_depth);
        }
    }
    let output = config.output.as_ref().or(renderer.output.as_ref());
    SceneRequests { device, output: output.and_then(|output| output.filename.clone()), is_pg1: true }
}
