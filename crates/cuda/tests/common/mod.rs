//! Scenes that are rendered on both backends, and how the films are compared.

mod surfaces;

use eosphor_core::math::{Vec3, vec3};
use eosphor_render::{Backend, BackendError, Film, RenderControl, Rendered};
use eosphor_scene::{
    Camera, Instance, Lens, Light, LoadOptions, Material, MaterialKind, Mesh, NO_INDEX, Parallelogram,
    Preset, Scene, SceneData, SceneError, Sphere, Transform, Triangle, load,
};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// A scene by its name: `glass` and `surfaces`, which are made here, or what [`load`] reads.
pub(crate) fn scene(name: &str, preset: Option<Preset>) -> Result<Scene, SceneError> {
    let mut scene = match name {
        "glass" => glass(),
        "surfaces" => surfaces::scene(),
        _ => load(name, &LoadOptions::default())?.scene,
    };
    if let Some(preset) = preset {
        preset.apply(&mut scene);
    }
    Ok(scene)
}

/// Glass, mirror and glossy spheres and coloured panes over a floor, through a lens, under all kinds of light; and a
/// mesh placed often enough to be instanced.
fn glass() -> Scene {
    let kinds = [
        MaterialKind::Matte { color: vec3(0.6, 0.55, 0.5) },
        MaterialKind::Dielectric { ior: 1.5, tint: vec3(0.97, 0.99, 0.98) },
        MaterialKind::Mirror { reflectance: vec3(0.9, 0.85, 0.8) },
        MaterialKind::Glossy {
            reflectance: Vec3::splat(0.6),
            exponent: 60.0,
            rays: 3,
            color: vec3(0.2, 0.1, 0.05),
        },
        MaterialKind::Transparent {
            color: vec3(0.9, 0.3, 0.2),
            transparency: 0.6,
            reflection: 0.2,
            shininess: 32.0,
            diffuse: 1.0,
        },
        MaterialKind::Emissive { radiance: vec3(6.0, 6.0, 7.0) },
    ];
    let material = |kind| Material::new("", kind);
    let sphere = |x, y, z, radius, material| Sphere { center: vec3(x, y, z), radius, material };
    let pane = |corner, edge_u, edge_v, material| Parallelogram { corner, edge_u, edge_v, material };
    let placed = |i: u32| Instance {
        mesh: 0,
        material: None,
        world_from_object: Transform {
            scale: vec3(0.5, 0.3, 0.5),
            rotate_degrees: vec3(10.0, 40.0 * i as f32, 5.0),
            ..Transform::translation(vec3(i as f32 * 1.2 - 2.5, 0.1, -2.5))
        },
        moves: Vec::new(),
    };
    let mut scene = Scene {
        meshes: vec![waves(2)],
        instances: (0..5).map(placed).collect(),
        spheres: vec![
            sphere(-1.2, 0.8, 0.0, 0.8, 1),
            sphere(0.6, 0.6, -0.6, 0.6, 2),
            sphere(1.4, 0.4, 0.9, 0.4, 3),
            sphere(-0.1, 0.25, 1.2, 0.25, 1),
        ],
        parallelograms: vec![
            pane(vec3(-6.0, 0.0, 6.0), vec3(12.0, 0.0, 0.0), vec3(0.0, 0.0, -12.0), 0),
            pane(vec3(-0.6, 0.0, 1.8), vec3(1.2, 0.0, 0.3), vec3(0.0, 1.0, 0.0), 4),
            pane(vec3(-1.0, 4.0, -1.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 0.0, 2.0), 5),
        ],
        materials: kinds.map(material).into(),
        lights: vec![
            Light::Point { position: vec3(3.0, 3.0, 3.0), color: vec3(6.0, 5.0, 4.0) },
            Light::Directional { direction: vec3(-0.3, -1.0, -0.4), color: Vec3::splat(0.4) },
            Light::Spot {
                position: vec3(-3.0, 4.0, 2.0),
                direction: vec3(2.0, -4.0, -2.0),
                inner_degrees: 15.0,
                outer_degrees: 25.0,
                color: vec3(10.0, 12.0, 14.0),
            },
        ],
        camera: Some(Camera {
            position: vec3(0.3, 1.6, 5.5),
            look_at: Some(vec3(0.0, 0.6, 0.0)),
            lens: Some(Lens { aperture_radius: 0.05, focus_distance: None }),
            ..Camera::default()
        }),
        ..Scene::default()
    };
    scene.settings.size = [213, 121];
    scene.settings.samples = 3;
    scene.settings.light_samples = 3;
    scene.settings.depth = 6;
    scene.settings.ambient = 0.05;
    scene.settings.background = vec3(0.2, 0.3, 0.5);
    scene.settings.light_from_behind = true;
    scene.settings.shadows = eosphor_core::settings::ShadowMode::Coloured;
    scene
}

/// A bumpy square of 512 triangles: more than are baked into the world.
fn waves(material: u32) -> Mesh {
    const SIDE: u32 = 16;
    let height = |x: u32, z: u32| ((x * x + 3 * z * z + x * z) % 7) as f32 * 0.05;
    let at = |x: u32, z: u32| vec3(x as f32 / 8.0 - 1.0, height(x, z), z as f32 / 8.0 - 1.0);
    let corner = |x: u32, z: u32| z * (SIDE + 1) + x;
    let triangle = |positions| Triangle { positions, normals: [NO_INDEX; 3], uvs: [NO_INDEX; 3], material };
    let square = |x: u32, z: u32| {
        let [a, b, c, d] = [corner(x, z), corner(x, z + 1), corner(x + 1, z + 1), corner(x + 1, z)];
        [triangle([a, b, c]), triangle([a, c, d])]
    };
    Mesh {
        name: "waves".into(),
        positions: (0..=SIDE).flat_map(|z| (0..=SIDE).map(move |x| at(x, z))).collect(),
        triangles: (0..SIDE).flat_map(|z| (0..SIDE).flat_map(move |x| square(x, z))).collect(),
        ..Mesh::default()
    }
}

/// A finished picture whose queries were counted.
#[allow(dead_code, reason = "examples count nothing")]
pub(crate) fn render_counted(
    backend: &dyn Backend,
    scene: &Arc<SceneData>,
) -> Result<Rendered, BackendError> {
    let cancel = &AtomicBool::new(false);
    let control = RenderControl { on_progress: &|_| {}, cancel, count_work: true, frame: None };
    backend.prepare(scene.clone())?.render(&control)
}

/// A finished picture, and the seconds that preparing and rendering took.
pub(crate) fn render(
    backend: &dyn Backend,
    scene: &Arc<SceneData>,
) -> Result<(Rendered, [f64; 2]), BackendError> {
    let start = Instant::now();
    let prepared = backend.prepare(scene.clone())?;
    let prepare_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let control = RenderControl {
        on_progress: &|_| {},
        cancel: &AtomicBool::new(false),
        count_work: false,
        frame: None,
    };
    let rendered = prepared.render(&control)?;
    assert!(rendered.complete, "nobody cancelled");
    Ok((rendered, [prepare_seconds, start.elapsed().as_secs_f64()]))
}

/// Where and how films differ in their bits; `None` where they are identical.
pub(crate) fn difference(a: &Film, b: &Film) -> Option<String> {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let bits = |c: &Vec3| [c.x, c.y, c.z].map(f32::to_bits);
    let differing = || (0..a.pixels.len()).filter(|&i| bits(&a.pixels[i]) != bits(&b.pixels[i]));
    let first = differing().next()?;
    let worst = differing().map(|i| (a.pixels[i] - b.pixels[i]).abs().max_component()).fold(0.0, f32::max);
    let (x, y) = (first % a.width as usize, first / a.width as usize);
    Some(format!(
        "{} of {} pixels differ, by at most {worst:e}; first ({x}, {y}): {:?} and {:?}",
        differing().count(),
        a.pixels.len(),
        a.pixels[first],
        b.pixels[first]
    ))
}
