//! What is written loads as what was saved.

use super::save::{CannotSave, scene_over_base};
use crate::files::{LoadOptions, Preset, load, load_from_memory};
use crate::flatten::SceneData;
use crate::model::{
    Animation, Camera, CameraMotion, DeviceKind, DeviceSettings, Lens, Light, PixelSampling, RenderSettings,
    Scene, Structure,
};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::ShadowMode;
use proptest::prelude::*;
use std::path::PathBuf;

const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0.25\nf 1 2 3\n";
const FAR: &[u8] = b"v 500000 5000000 0\nv 500001 5000000 0\nv 500000 5000001 0.25\nf 1 2 3\n";
const BASES: [&str; 5] = ["builtin:cornell", "builtin:glass", "builtin:solids", "near.obj", "far.obj"];

fn load_files(text: &str, path: &str) -> Scene {
    let files = [("s.json", text.as_bytes()), ("near.obj", OBJ), ("far.obj", FAR)];
    let files = files.map(|(name, bytes)| (PathBuf::from(name), bytes.to_vec())).to_vec();
    load_from_memory(files, path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}: {text}")).scene
}

fn alone(base: &str) -> Scene {
    match base.starts_with("builtin:") {
        true => load(base, &LoadOptions::default()).unwrap().scene,
        false => load_files("", base),
    }
}

/// The camera of a frame without what does not count.
fn camera_at(scene: &Scene, frame: u32) -> Option<Camera> {
    let default = Camera::default();
    let mut camera = scene.camera_at(frame)?;
    if camera.look_at.is_some() {
        camera.direction = default.direction;
    }
    if camera.fov_y_degrees.is_some() || camera.orthographic_height.is_some() {
        camera.fov_x_degrees = default.fov_x_degrees;
    }
    Some(camera)
}

/// Writes a scene over its base, and reads it; the text.
fn check(base: &str, before: &Scene, after: &Scene) -> String {
    let text = scene_over_base(base, before, after).unwrap();
    let read = load_files(&text, "s.json");
    for frame in [0, 3] {
        assert_eq!(camera_at(&read, frame), camera_at(after, frame), "{text}");
    }
    assert_eq!(read.settings, after.settings, "{text}");
    assert_eq!(
        (&read.lights, read.device, &read.output),
        (&after.lights, after.device, &after.output),
        "{text}"
    );
    let flat = |scene: &Scene| SceneData::flatten(scene).unwrap().0;
    let (read, after) = (flat(&read), flat(after));
    assert_eq!(format!("{:?}", read.camera), format!("{:?}", after.camera), "{text}");
    assert_eq!(format!("{:?}", read.lights), format!("{:?}", after.lights), "{text}");
    text
}

#[test]
fn what_is_as_in_the_base_is_not_written() {
    for base in BASES {
        let scene = alone(base);
        let text = check(base, &scene, &scene);
        let [width, height] = scene.settings.size;
        let RenderSettings { samples, seed, .. } = scene.settings;
        let expected = format!(
            "{{\n  \"eosphor\": 2,\n  \"base\": \"{base}\",\n  \"settings\": {{\n    \"size\": [{width}, {height}],\n    \
             \"samples\": {samples},\n    \"seed\": {seed}\n  }}\n}}\n"
        );
        assert_eq!(text, expected);
    }
}

#[test]
fn all_that_differs_is_written() {
    let before = alone("builtin:cornell");
    let mut after = before.clone();
    after.camera = Some(Camera {
        position: vec3(0.1, 0.0, 4.42),
        up: vec3(-0.0, 1.0, 0.0),
        look_at: Some(vec3(1e-9, 0.795, 0.0)),
        fov_y_degrees: Some(33.3),
        lens: Some(Lens { aperture_radius: 0.05, focus_distance: None }),
        ..before.camera.unwrap()
    });
    after.lights = vec![Light::Spot {
        position: vec3(0.0, 1.5, 0.3),
        direction: vec3(0.0, -1.0, 0.0),
        inner_degrees: 10.5,
        outer_degrees: 20.0,
        color: vec3(9.0, 8.1, 7.0),
    }];
    after.settings.pixel_sampling = PixelSampling::Grid(3);
    (after.settings.exposure, after.settings.seed) = (-0.3, u32::MAX);
    after.device =
        DeviceSettings { backend: Some(DeviceKind::Cpu), accel: Some(Structure::Bvh), ..before.device };
    after.output = Some("a \"b\".png".into());
    let text = check("builtin:cornell", &before, &after);
    let expected = r#"{
  "eosphor": 2,
  "base": "builtin:cornell",
  "camera": {
    "position": [0.1, 0, 4.42],
    "look-at": [1e-9, 0.795, 0],
    "up": [-0.0, 1, 0],
    "fov-y-degrees": 33.3,
    "lens": { "aperture-radius": 0.05 }
  },
  "lights": [
    { "spot": { "position": [0, 1.5, 0.3], "direction": [0, -1, 0], "inner-degrees": 10.5, "outer-degrees": 20, "color": [9, 8.1, 7] } }
  ],
  "settings": {
    "size": [800, 640],
    "samples": 8,
    "pixel-sampling": { "grid": 3 },
    "exposure": -0.3,
    "seed": 4294967295
  },
  "device": {
    "backend": "cpu",
    "accel": "bvh"
  },
  "output": "a \"b\".png"
}
"#;
    assert_eq!(text, expected);
    // From there back: what the base says and the scene does not is null.
    let back = Scene { lights: after.lights.clone(), output: after.output.clone(), ..before.clone() };
    let text = scene_over_base("x.json", &after, &back).unwrap();
    assert!(text.contains("\"backend\": null") && !text.contains("\"lights\""), "{text}");
}

#[test]
fn a_scene_without_light_is_dark_and_stays_so() {
    for base in ["near.obj", "builtin:glass"] {
        let before = alone(base);
        let mut after = before.clone();
        after.settings.headlight = false;
        let text = check(base, &before, &after);
        assert!(text.contains("\"headlight\": false"), "{text}");
        // The grey surroundings of the model are kept, though it would not get them now.
        assert_eq!(load_files(&text, "s.json").settings.ambient, before.settings.ambient);
        after.lights.clear();
        after.settings.ambient = 0.5;
        check(base, &before, &after);
    }
    let before = alone("builtin:solids");
    let after = Scene { lights: Vec::new(), ..before.clone() };
    let words = scene_over_base("builtin:solids", &before, &after).unwrap_err().to_string();
    assert!(words.starts_with("all lights were taken away"), "{words}");
}

#[test]
fn far_coordinates_keep_all_their_digits() {
    let before = alone("far.obj");
    let mut after = before.clone();
    let position = before.point_of_file([500_000.125, 5_000_000.375, 7.5]);
    after.camera = Some(Camera {
        position,
        look_at: Some(before.point_of_file([500_000.25, 5e6, 0.0])),
        ..Camera::default()
    });
    after.lights.push(Light::Point { position, color: Vec3::ONE });
    let text = check("far.obj", &before, &after);
    assert!(text.contains("\"position\": [500000.125, 5000000.375, 7.5]"), "{text}");
    assert!(text.contains("\"look-at\": [500000.25, 5000000, 0]"), "{text}");
    // What is nearer to the origin than the file has digits.
    after.camera = Some(Camera { position: vec3(1.0, 1.234_567e-9, 4.0), ..Camera::default() });
    let error = scene_over_base("far.obj", &before, &after).unwrap_err();
    assert!(error.to_string().starts_with("the camera is so near the point"), "{error}");
}

#[test]
fn what_a_file_over_a_base_does_not_say_is_refused() {
    type Change = fn(&mut Scene);
    let led: Change = |scene| {
        scene.animation.as_mut().unwrap().camera = Some(CameraMotion::Orbit { turns: 1.0, around: None })
    };
    let changes: [(&str, Change); 9] = [
        ("the geometry was moved", |scene| scene.move_geometry([1.0, 0.0, 0.0])),
        ("the geometry was moved", |scene| drop(scene.instances.pop())),
        ("materials were changed", |scene| scene.materials[0].single_sided ^= true),
        ("meshes were changed", |scene| scene.meshes[0].positions[0].x += 1.0),
        ("textures were changed", |scene| scene.textures[0].uv_set ^= 1),
        ("pictures of textures were changed", |scene| scene.images[0].name.push('x')),
        ("the animation was changed", |scene| scene.animation = Some(Animation::of_frames(3))),
        ("the motion of the camera was changed", led),
        ("the camera was changed, and it moves as before", |scene| {
            scene.camera = Some(Camera { fov_x_degrees: 12.0, ..Camera::default() });
        }),
    ];
    let before = alone("builtin:solids");
    for (words, change) in changes {
        let mut after = before.clone();
        change(&mut after);
        let error = scene_over_base("builtin:solids", &before, &after).unwrap_err();
        assert!(
            matches!(error, CannotSave::NotSaid { .. }) && error.to_string().starts_with(words),
            "{words}: {error}"
        );
    }
    let mut after = alone("builtin:cornell");
    let before = after.clone();
    after.settings.samples = 0;
    let error = scene_over_base("builtin:cornell", &before, &after).unwrap_err();
    assert!(matches!(error, CannotSave::Problem(_)), "{error}");
    after = Scene { camera: None, ..before.clone() };
    let error = scene_over_base("builtin:cornell", &before, &after).unwrap_err();
    assert!(error.to_string().starts_with("the camera was taken away"), "{error}");
    // A camera that looks nowhere.
    after.camera = Some(Camera { look_at: Some(Camera::default().position), ..Camera::default() });
    scene_over_base("builtin:cornell", &before, &after).unwrap_err();
    // The preset changes materials, too.
    let before = alone("near.obj");
    let mut after = before.clone();
    Preset::Eos.apply(&mut after);
    scene_over_base("near.obj", &before, &after).unwrap_err();
}

fn place() -> impl Strategy<Value = [f64; 3]> {
    [-50.0..50.0, -50.0..50.0, -50.0..50.0]
}

fn vector() -> impl Strategy<Value = Vec3> {
    place().prop_map(|p| Vec3::from(p.map(|x| x as f32)))
}

/// What a person may change of a scene.
#[derive(Clone, Debug)]
struct Change {
    camera: Option<(Camera, [f64; 3], Option<[f64; 3]>)>,
    light: Option<([f64; 3], Vec3)>,
    settings: RenderSettings,
    keeps_settings: bool,
}

fn cameras() -> impl Strategy<Value = (Camera, [f64; 3], Option<[f64; 3]>)> {
    let views = (1e-3..179.0f32, 0..3u8, proptest::option::of((0.0..1.0f32, 0.1..9.0f32)));
    (vector(), vector(), views, place(), proptest::option::of(place())).prop_map(
        |(direction, up, (size, kind, lens), position, look_at)| {
            let camera = Camera {
                direction,
                up,
                fov_x_degrees: size,
                fov_y_degrees: (kind == 1).then_some(size),
                orthographic_height: (kind == 2).then_some(size),
                lens: lens.map(|(aperture_radius, d)| Lens { aperture_radius, focus_distance: Some(d) }),
                ..Camera::default()
            };
            (camera, position, look_at)
        },
    )
}

fn changes() -> impl Strategy<Value = Change> {
    let settings = (
        ([1..2000u32, 1..2000u32], 1..200u32, 0..64u32, any::<u32>()),
        (0.0..1.0f32, -9.0..9.0f32, proptest::option::of(1e-6..1e6f32), vector()),
        any::<[bool; 4]>(),
    )
        .prop_map(|((size, samples, depth, seed), (share, exposure, max_distance, v), [a, b, c, d])| {
            RenderSettings {
                size,
                samples,
                depth,
                seed,
                ambient: share,
                energy_threshold: share * share,
                exposure,
                max_distance,
                background: v.abs(),
                cull_back_faces: a,
                headlight: b,
                pixel_sampling: if c { PixelSampling::Grid(samples) } else { PixelSampling::Center },
                shadows: if d { ShadowMode::Coloured } else { ShadowMode::None },
                ..RenderSettings::default()
            }
        });
    let lights = proptest::option::of((place(), vector().prop_map(Vec3::abs)));
    (proptest::option::of(cameras()), lights, settings, any::<bool>()).prop_map(
        |(camera, light, settings, keeps_settings)| Change { camera, light, settings, keeps_settings },
    )
}

/// Changes that can be rendered and said.
fn changed(before: &Scene, change: Change) -> Option<Scene> {
    let here = before.origin;
    let at = |p: [f64; 3]| before.point_of_file([p[0] + here[0], p[1] + here[1], p[2] + here[2]]);
    let mut after = before.clone();
    if !change.keeps_settings {
        after.settings = change.settings;
    }
    if let Some((camera, position, look_at)) = change.camera {
        after.camera = Some(Camera { position: at(position), look_at: look_at.map(at), ..camera });
        after.animation.iter_mut().for_each(|animation| animation.camera = None);
    }
    if let Some((position, color)) = change.light {
        after.lights.push(Light::Point { position: at(position), color });
    }
    after.check_view().is_ok().then_some(after)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn any_changes_are_read_back(changes in proptest::collection::vec(changes(), BASES.len())) {
        for (base, change) in BASES.into_iter().zip(changes) {
            let before = alone(base);
            if let Some(after) = changed(&before, change) {
                check(base, &before, &after);
            }
        }
    }
}
