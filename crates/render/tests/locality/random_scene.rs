//! Scenes of anything.

use super::far::Random;
use crate::shapes::{Closed, cube, icosphere, torus};
use crate::vector::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::{FresnelMode, LightingModel, ShadowMode};
use eosphor_scene::{
    Camera, Instance, Light, Material, MaterialKind, Mesh, Mtl, NO_INDEX, NormalMode, Parallelogram, Pbr,
    RenderSettings, Scene, Sphere, Transform, Triangle,
};

/// Of this size, and this far from the origin.
struct Frame {
    size: f32,
    shift: Vec3,
}

impl Frame {
    fn point(&self, p: Vec3) -> Vec3 {
        p * self.size + self.shift
    }
}

fn settings(random: &mut Random, size: f32) -> RenderSettings {
    let models =
        [LightingModel::Lambert, LightingModel::Phong, LightingModel::BlinnPhong, LightingModel::Distance];
    let shadows = [ShadowMode::Opaque, ShadowMode::Opaque, ShadowMode::Coloured, ShadowMode::None];
    RenderSettings {
        size: [24, 16],
        samples: 1 + random.below(2) as u32,
        light_samples: 1 + random.below(3) as u32,
        depth: random.below(6) as u32,
        lighting: models[random.below(models.len())],
        shadows: shadows[random.below(shadows.len())],
        fresnel: [FresnelMode::Exact, FresnelMode::Schlick, FresnelMode::Constant][random.below(3)],
        normals: [NormalMode::Flat, NormalMode::Auto, NormalMode::Generated][random.below(3)],
        cull_back_faces: random.below(5) == 0,
        light_from_behind: random.below(3) == 0,
        light_falloff: false,
        max_distance: Some(6.0 * size),
        background: Vec3::splat(0.2),
        seed: random.bits() as u32,
        ..RenderSettings::default()
    }
}

fn material(random: &mut Random) -> MaterialKind {
    let color = (random.in_cube() + Vec3::ONE) * 0.45;
    match random.below(8) {
        0 | 1 => MaterialKind::Matte { color },
        2 => MaterialKind::Mirror { reflectance: color },
        3 => MaterialKind::Dielectric { ior: 1.0 + random.unit(), tint: color },
        4 => MaterialKind::Glossy { reflectance: color, exponent: 50.0, rays: 2, color },
        5 => MaterialKind::Transparent {
            color,
            transparency: 0.6,
            reflection: 0.2,
            shininess: 30.0,
            diffuse: 0.8,
        },
        6 => MaterialKind::Pbr(Pbr {
            color,
            roughness: random.unit(),
            metallic: random.unit(),
            ..Pbr::default()
        }),
        _ => MaterialKind::Mtl(Mtl { Kd: color, Ks: Vec3::splat(0.3), Ns: 40.0, ..Mtl::default() }),
    }
}

fn mesh(shape: &Closed, material: u32) -> Mesh {
    let none = [NO_INDEX; 3];
    let corners = |t: &[usize; 3]| t.map(|v| v as u32);
    let triangle = |t| Triangle { positions: corners(t), normals: none, uvs: none, material };
    Mesh {
        name: shape.name.into(),
        positions: shape.positions.iter().map(|p| single(*p)).collect(),
        triangles: shape.triangles.iter().map(triangle).collect(),
        ..Mesh::default()
    }
}

fn light(random: &mut Random, frame: &Frame) -> Light {
    let position = frame.point(random.in_cube() * 2.0 + vec3(0.0, 3.0, 0.0));
    let color = Vec3::splat(0.7);
    match random.below(3) {
        0 => Light::Point { position, color },
        1 => Light::Directional { direction: random.in_cube() - vec3(0.0, 1.5, 0.0), color },
        _ => Light::Spot {
            position,
            direction: frame.point(random.in_cube() * 0.3) - position,
            inner_degrees: 15.0,
            outer_degrees: 40.0,
            color,
        },
    }
}

/// Spheres, bodies that are baked, bodies that are placed twice, perhaps a ground and a lamp with an area, lights.
pub(crate) fn random_scene(random: &mut Random) -> Scene {
    let size = [1e-3, 1.0, 1.0, 1.0, 1e3][random.below(5)];
    let shift = [Vec3::ZERO, Vec3::ZERO, random.in_cube() * (30.0 * size)][random.below(3)];
    let frame = Frame { size, shift };
    let mut scene = Scene { settings: settings(random, size), ..Scene::default() };
    let kinds = 3 + random.below(4);
    scene.materials = (0..kinds).map(|k| Material::new(format!("m{k}"), material(random))).collect();
    for _ in 0..random.below(5) {
        let center = frame.point(random.in_cube() * 1.4);
        let (radius, material) = ((0.1 + 0.4 * random.unit()) * size, random.below(kinds) as u32);
        scene.spheres.push(Sphere { center, radius, material });
    }
    for shape in [cube(), icosphere(1), torus(20, 10)].iter().take(1 + random.below(3)) {
        scene.meshes.push(mesh(shape, random.below(kinds) as u32));
        // The torus has more triangles than are baked when it is placed twice.
        for _ in 0..1 + random.below(2) {
            let scale = vec3(0.2 + 0.4 * random.unit(), 0.2 + 0.4 * random.unit(), 0.3) * size;
            let map = Transform {
                scale: if random.below(4) == 0 { vec3(-scale.x, scale.y, scale.z) } else { scale },
                rotate_degrees: random.in_cube() * 180.0,
                ..Transform::translation(frame.point(random.in_cube() * 1.2))
            };
            scene.instances.push(Instance::new(scene.meshes.len() as u32 - 1, map));
        }
    }
    let mut flat = |y: f32, half: f32, material: u32| {
        let corner = frame.point(vec3(-half, y, -half * 1.1));
        let edge = 2.0 * half * size;
        let (edge_u, edge_v) = (vec3(0.0, 0.0, edge), vec3(edge, 0.0, 0.0));
        scene.parallelograms.push(Parallelogram { corner, edge_u, edge_v, material });
    };
    if random.below(4) > 0 {
        flat(-1.3, 3.0, random.below(kinds) as u32);
    }
    if random.below(2) == 0 {
        flat(2.5, 0.4, kinds as u32);
        let shining = MaterialKind::Emissive { radiance: Vec3::splat(4.0) };
        scene.materials.push(Material::new("lamp", shining));
    }
    for _ in 0..1 + random.below(2) {
        let light = light(random, &frame);
        scene.lights.push(light);
    }
    let eye = random.in_cube().normalize_or(Vec3::ONE) * 4.5;
    let position = frame.point(vec3(eye.x, eye.y.abs() * 0.6, eye.z));
    let direction = frame.point(random.in_cube() * 0.3) - position;
    scene.camera = Some(Camera { position, direction, fov_x_degrees: 45.0, ..Camera::default() });
    scene
}
