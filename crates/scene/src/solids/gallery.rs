//! The built-in scene `solids`.

use super::body::{Body, BodyLighting};
use super::parquet::parquet;
use super::solid::Solid;
use crate::error::Problem;
use crate::model::{
    Animation, Camera, CameraMotion, Law, Light, LightSelection, Material, MaterialKind, MaterialTextures,
    Parallelogram, PixelSampling, RenderSettings, Scene, Texture,
};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::{LightingModel, ShadowMode};

/// Three solids over a parquet, lit from within, and a flight around them.
pub(crate) fn gallery() -> Result<Scene, Problem> {
    let mut scene = Scene { settings: settings(), ..Scene::default() };
    for body in bodies() {
        body.add_to(&mut scene)?;
    }
    floor(&mut scene);
    scene.lights.extend([
        Light::Point { position: vec3(-7.0, -5.0, 9.0), color: vec3(40.0, 35.0, 28.0) },
        Light::Point { position: vec3(6.0, 7.0, 8.0), color: vec3(16.0, 21.0, 30.0) },
    ]);
    let (position, look_at) = flight();
    let camera = Camera {
        position: position.point(0.0),
        look_at: Some(look_at.point(0.0)),
        up: vec3(0.0, 0.0, 1.0),
        fov_x_degrees: 52.0,
        ..Camera::default()
    };
    scene.camera = Some(camera);
    let motion = CameraMotion::Laws { position, look_at };
    scene.animation = Some(Animation { camera: Some(motion), ..Animation::of_frames(120) });
    Ok(scene)
}

/// Around the vertical axis, at equal distances.
pub(super) fn bodies() -> [Body; 3] {
    let body = |shape, center, radius, color, lights_per_edge| Body {
        center,
        radius,
        color,
        reflection: 0.8,
        transparency: 0.4,
        lights_per_edge,
        lighting: BodyLighting::Diodes { power: 1.4 },
        ..Body::new(shape)
    };
    [
        body(Solid::Tetrahedron, vec3(0.0, 2.1, 0.85), 1.5, vec3(1.0, 0.32, 0.12), 3),
        body(Solid::Octahedron, vec3(-1.8, -1.05, 1.45), 1.25, vec3(0.25, 1.0, 0.35), 2),
        body(Solid::Dodecahedron, vec3(1.8, -1.05, 1.3), 1.15, vec3(0.2, 0.5, 1.0), 1),
    ]
}

/// Where the camera is, and where it looks.
fn flight() -> (Law, Law) {
    let position = Law {
        r: 7.9,
        z: 3.1,
        phi: -1.51,
        r_amplitude: 0.8,
        z_amplitude: 0.9,
        r_frequency: 2.0,
        z_frequency: 3.0,
        phi_frequency: 1.0,
        r_phase: 0.6,
        z_phase: 0.0,
    };
    let look_at = Law { r: 0.2, z: 1.0, phi: -1.51, phi_frequency: 1.0, ..Law::default() };
    (position, look_at)
}

fn floor(scene: &mut Scene) {
    scene.images.push(parquet());
    let texture = Texture {
        // The picture once in 6 units.
        picture_from_mesh_uv: [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0]],
        ..Texture::of_image(scene.images.len() as u32 - 1)
    };
    scene.textures.push(texture);
    let textures =
        MaterialTextures { color: Some(scene.textures.len() as u32 - 1), ..MaterialTextures::NONE };
    let kind = MaterialKind::Transparent {
        color: Vec3::ONE,
        transparency: 0.0,
        reflection: 0.12,
        shininess: 64.0,
        diffuse: 0.9,
    };
    scene.materials.push(Material { textures, ..Material::new("parquet", kind) });
    scene.parallelograms.push(Parallelogram {
        corner: vec3(-12.0, -12.0, 0.0),
        edge_u: vec3(24.0, 0.0, 0.0),
        edge_v: vec3(0.0, 24.0, 0.0),
        material: scene.materials.len() as u32 - 1,
    });
}

fn settings() -> RenderSettings {
    RenderSettings {
        size: [960, 540],
        samples: 16,
        pixel_sampling: PixelSampling::Random,
        // Its 72 small lamps are few enough, and quieter together.
        lights: Some(LightSelection::All),
        light_samples: 1,
        depth: 10,
        energy_threshold: 0.02,
        lighting: LightingModel::Phong,
        shadows: ShadowMode::Coloured,
        ambient: 0.0064,
        exposure: 2.45,
        background: vec3(0.0019, 0.0025, 0.0045),
        ..RenderSettings::default()
    }
}
