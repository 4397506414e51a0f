//! Scenes with a base.

use crate::files::{LoadOptions, LoadedScene, load, load_from_memory};
use crate::model::{
    Camera, CameraMotion, EnvironmentMap, EnvironmentSource, Light, PixelSampling, RenderSettings, Scene, Sky,
};
use crate::{SceneData, SceneError, scene_over_base, scene_requests};
use eosphor_core::develop::ToneCurve;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::Integrator;
use std::path::PathBuf;

/// Loads the first of these files.
fn read(files: &[(&str, &str)]) -> Result<LoadedScene, SceneError> {
    let all = files.iter().map(|(name, text)| (PathBuf::from(name), text.as_bytes().to_vec())).collect();
    load_from_memory(all, files[0].0, &LoadOptions::default())
}

fn scene(files: &[(&str, &str)]) -> Scene {
    read(files).unwrap_or_else(|error| panic!("{error}")).scene
}

fn error(files: &[(&str, &str)]) -> String {
    read(files).unwrap_err().to_string()
}

const BALL: &str = r#"{ "eosphor": 2,
    "materials": { "m": { "matte": { "color": [1, 0, 0] } } },
    "spheres": [{ "center": [0, 0, 0], "radius": 1, "material": "m" }],
    "camera": { "position": [0, 0, 5], "fov-y-degrees": 30 },
    "lights": [{ "point": { "position": [0, 3, 0], "color": [1, 1, 1] } }],
    "settings": { "size": [40, 30], "samples": 3, "depth": 2, "max-distance": 4, "lighting": "distance" },
    "device": { "backend": "cpu", "leaf-size": 7 },
    "output": "ball.png" }"#;

const TRIANGLE: &str = "v 500000.25 5000000.5 0\nv 500001.25 5000000.5 0\nv 500000.25 5000001.5 0\nf 1 2 3\n";

#[test]
fn a_base_alone_is_the_scene() {
    let (over, base) =
        (scene(&[("a.json", r#"{ "eosphor": 2, "base": "ball.json" }"#), ("ball.json", BALL)]), BALL);
    let base = scene(&[("ball.json", base)]);
    assert_eq!((over.settings, over.camera, over.device), (base.settings, base.camera, base.device));
    assert_eq!((&over.lights, &over.spheres, &over.output), (&base.lights, &base.spheres, &base.output));
}

#[test]
fn what_is_given_goes_over_the_base() {
    let text = r#"{ "eosphor": 2, "base": "in/ball.json",
        "camera": { "position": [1, 2, 3], "look-at": [0, 0, 0] },
        "lights": [{ "directional": { "direction": [0, -1, 0], "color": [2, 2, 2] } }],
        "settings": { "samples": 9, "max-distance": null, "seed": 5 },
        "device": { "accel": "octree" }, "output": "other.png" }"#;
    let over = scene(&[("a.json", text), ("in/ball.json", BALL)]);
    let base = scene(&[("ball.json", BALL)]);
    let mut settings = base.settings;
    (settings.samples, settings.max_distance, settings.seed) = (9, None, 5);
    assert_eq!(over.settings, settings);
    let camera = Camera { position: vec3(1.0, 2.0, 3.0), look_at: Some(Vec3::ZERO), ..Camera::default() };
    assert_eq!(over.camera, Some(camera));
    assert_eq!(
        over.lights,
        [Light::Directional { direction: vec3(0.0, -1.0, 0.0), color: Vec3::splat(2.0) }]
    );
    assert_eq!((over.device.leaf_size, over.device.accel.map(|a| a.name())), (Some(7), Some("octree")));
    assert_eq!(over.output.as_deref(), Some("other.png"));
    assert_eq!(over.spheres, base.spheres);
}

#[test]
fn a_number_of_samples_takes_the_place_of_the_bases_grid() {
    let grid = BALL.replace("\"samples\": 3", "\"pixel-sampling\": { \"grid\": 4 }");
    let with = |settings: &str| {
        let text = format!(r#"{{ "eosphor": 2, "base": "b.json", "settings": {{ {settings} }} }}"#);
        let settings = scene(&[("a.json", &text), ("b.json", &grid)]).settings;
        (settings.samples, settings.pixel_sampling)
    };
    assert_eq!(with("\"depth\": 1"), (1, PixelSampling::Grid(4)));
    assert_eq!(with("\"samples\": 9"), (9, PixelSampling::Random));
    assert_eq!(with("\"samples\": 9, \"pixel-sampling\": { \"grid\": 2 }"), (9, PixelSampling::Grid(2)));
}

#[test]
fn bases_are_files_of_any_kind() {
    let over = |base: &str| format!(r#"{{ "eosphor": 2, "base": "{base}", "settings": {{ "depth": 1 }} }}"#);
    let obj = scene(&[("a.json", &over("t.obj")), ("t.obj", TRIANGLE)]);
    assert_eq!((obj.meshes.len(), obj.settings.depth), (1, 1));
    let again = scene(&[("b.json", &over("a.json")), ("a.json", &over("t.obj")), ("t.obj", TRIANGLE)]);
    assert_eq!((again.origin, &again.instances), (obj.origin, &obj.instances));
    let builtin = scene(&[("a.json", &over("builtin:cornell"))]);
    let cornell = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
    assert_eq!((builtin.camera, &builtin.materials), (cornell.camera, &cornell.materials));
    assert_eq!(
        (builtin.settings.depth, builtin.settings.pixel_sampling, builtin.settings.exposure),
        (1, PixelSampling::Random, 1.9)
    );
}

#[test]
fn far_from_0_all_digits_count() {
    let text = r#"{ "eosphor": 2, "base": "t.obj",
        "camera": { "position": [500000.3125, 5000000.625, 4.5], "look-at": [500000.3125, 5000000.6875, 0] },
        "lights": [{ "point": { "position": [500000.0625, 5000001.125, 2], "color": [1, 1, 1] } }] }"#;
    let scene = scene(&[("a.json", text), ("t.obj", TRIANGLE)]);
    assert_ne!(scene.origin, [0.0; 3]);
    let camera = scene.camera.unwrap();
    assert_eq!(scene.point_in_file(camera.position), [500000.3125, 5000000.625, 4.5]);
    assert_eq!(scene.point_in_file(camera.look_at.unwrap()), [500000.3125, 5000000.6875, 0.0]);
    let Light::Point { position, .. } = scene.lights[0] else { panic!() };
    assert_eq!(scene.point_in_file(position), [500000.0625, 5000001.125, 2.0]);
}

#[test]
fn a_camera_stands_still_and_takes_the_place_of_one_that_moves() {
    let base = load("builtin:solids", &LoadOptions::default()).unwrap().scene;
    assert!(base.camera_is_led());
    let led = scene(&[("a.json", r#"{ "eosphor": 2, "base": "builtin:solids" }"#)]);
    assert_eq!(led.camera_at(50), base.camera_at(50));
    let text = r#"{ "eosphor": 2, "base": "builtin:solids", "camera": { "position": [3, 1, 0] } }"#;
    let still = scene(&[("a.json", text)]);
    assert_eq!(still.camera_at(0).unwrap().position, vec3(3.0, 1.0, 0.0));
    let motion = |scene: &Scene| -> Option<CameraMotion> { scene.animation.as_ref()?.camera.clone() };
    assert!(motion(&still).is_none());
    assert_eq!(still.animation.unwrap().frames, base.animation.unwrap().frames);
}

#[test]
fn darkness_reaches_the_base() {
    let over = |more: &str| format!(r#"{{ "eosphor": 2, "base": "t.obj" {more} }}"#);
    let with = |more: &str| scene(&[("a.json", &over(more)), ("t.obj", TRIANGLE)]).settings;
    assert!(with("").headlight);
    for dark in [r#", "settings": { "headlight": false }"#, r#", "lights": []"#] {
        let settings = with(dark);
        assert_eq!((settings.headlight, settings.ambient), (false, 0.0), "{dark}");
    }
    // A file that is dark itself stays so.
    let dark = r#"{ "eosphor": 2, "base": "t.obj", "settings": { "headlight": false } }"#;
    let over = r#"{ "eosphor": 2, "base": "dark.json", "settings": { "seed": 1 } }"#;
    assert!(!scene(&[("a.json", over), ("dark.json", dark), ("t.obj", TRIANGLE)]).settings.headlight);
}

#[test]
fn what_is_wrong_is_said_at_its_place() {
    for key in ["materials", "meshes", "instances", "spheres", "parallelograms", "quadrilaterals", "solids"] {
        let empty = if key == "materials" { "{}" } else { "[]" };
        let text = format!("{{ \"eosphor\": 2, \"base\": \"ball.json\",\n  \"{key}\": {empty} }}");
        let error = error(&[("a.json", &text), ("ball.json", BALL)]);
        assert!(
            error.starts_with(&format!("a.json:2:3: \"{key}\" cannot be used together with \"base\"")),
            "{error}"
        );
    }
    let with = |text: &str| error(&[("a.json", text), ("ball.json", BALL)]);
    let old = with(r#"{ "eosphor": 1, "base": "ball.json" }"#);
    assert!(old.starts_with("a.json:1:14: version 1"), "{old}");
    let missing = with(r#"{ "eosphor": 2, "base": "no.json" }"#);
    assert!(missing.starts_with("a.json:1:25: base: ") && missing.contains("No such file"), "{missing}");
    let unknown = with(r#"{ "eosphor": 2, "base": "builtin:cube" }"#);
    assert!(unknown.starts_with("a.json:1:25: base: there is no built-in scene \"cube\""), "{unknown}");
    let kind = error(&[("a.json", r#"{ "eosphor": 2, "base": "a.stl" }"#), ("a.stl", "solid")]);
    assert!(kind.starts_with("a.json:1:25: base: a.stl: \"stl\" files are not read"), "{kind}");
    // What is wrong inside the base has its own place.
    let inside = error(&[
        ("a.json", r#"{ "eosphor": 2, "base": "b.json" }"#),
        ("b.json", "{ \"eosphor\": 2,\n \"spheres\": 1 }"),
    ]);
    assert!(inside.starts_with("b.json:2:"), "{inside}");
    let blind = with(
        r#"{ "eosphor": 2, "base": "ball.json", "camera": { "position": [1, 1, 1], "look-at": [1, 1, 1] } }"#,
    );
    assert!(blind.starts_with("a.json:1:"), "{blind}");
    assert!(with(r#"{ "eosphor": 2, "base": 7 }"#).starts_with("a.json:1:25: "));
}

#[test]
fn circles_and_long_chains_end() {
    let over = |base: usize| format!(r#"{{ "eosphor": 2, "base": "{base}.json" }}"#);
    let itself = error(&[("0.json", &over(0))]);
    assert!(itself.contains("leads back to the file itself; name another one"), "{itself}");
    let texts: Vec<(String, String)> = (0..40).map(|k| (format!("{k}.json"), over((k + 1) % 3))).collect();
    let files: Vec<(&str, &str)> = texts.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let circle = error(&files[..3]);
    assert!(circle.contains("through 0.json, 1.json"), "{circle}");
    let texts: Vec<(String, String)> = (0..40).map(|k| (format!("{k}.json"), over(k + 1))).collect();
    let files: Vec<(&str, &str)> = texts.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let long = error(&files);
    assert!(long.contains("more than 16 bases of bases"), "{long}");
}

#[test]
fn what_is_asked_for_before_is_that_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("ball.json", BALL);
    write("a.json", r#"{ "eosphor": 2, "base": "ball.json", "device": { "accel": "grid" } }"#);
    let requests = scene_requests(&folder.path().join("a.json"));
    let loaded = load(folder.path().join("a.json"), &LoadOptions::default()).unwrap();
    assert_eq!((requests.device, &requests.output), (loaded.scene.device, &loaded.scene.output));
    assert_eq!((requests.device.leaf_size, requests.output.as_deref()), (Some(7), Some("ball.png")));
    let names = loaded.files_read.iter().map(|path| path.file_name().unwrap().to_owned());
    assert_eq!(names.collect::<Vec<_>>(), ["a.json", "ball.json"]);
    write("b.json", r#"{ "eosphor": 2, "base": "b.json" }"#);
    assert_eq!(scene_requests(&folder.path().join("b.json")), Default::default());
}

const PG1: &str = r#"{ "renderer": { "render_mode": "gpu", "acceleratied_data_structure": { "name": "octree", "max_depth": 4 } },
    "output": { "filename": "pg1.ppm" }, "scene": { "source_file": "t.obj", "camera": { "pos": [0, 0, 5], "width": 8 },
    "point_lights": [{ "pos": [0, 1, 5], "color": [1, 1, 1] }] } }"#;
const GLTF: &str = r#"{ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "nodes": [{ "camera": 0 }],
    "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 1 } }] }"#;

fn over(base: &str, more: &str) -> String {
    format!(r#"{{ "eosphor": 2, "base": "{base}"{more} }}"#)
}

#[test]
fn a_base_of_any_kind_alone_is_the_scene_to_the_last_bit() {
    // Scene files that name no integrator are Whitted's, whatever their base.
    let whitted = LoadOptions { integrator: Some(Integrator::Whitted), ..LoadOptions::default() };
    for (name, text) in [("c.json", PG1), ("x.gltf", GLTF), ("t.obj", TRIANGLE), ("ball.json", BALL)] {
        let files = [(name, text), ("t.obj", TRIANGLE)].map(|(name, text)| (name.into(), text.into()));
        let base = load_from_memory(files.to_vec(), name, &whitted).unwrap().scene;
        let over = scene(&[("a.json", &over(name, "")), (name, text), ("t.obj", TRIANGLE)]);
        assert_eq!(format!("{over:?}"), format!("{base:?}"), "{name}");
    }
}

#[test]
fn what_is_asked_for_where_files_are_loaded_holds_for_bases() {
    let with = |base: &str, more: &str, options: &LoadOptions| {
        let files = [("a.json", over(base, more)), ("t.obj", TRIANGLE.into())];
        let files = files.map(|(name, text)| (PathBuf::from(name), text.into_bytes())).to_vec();
        load_from_memory(files, "a.json", options).map(|loaded| loaded.scene)
    };
    let dark = LoadOptions { headlight: false, ..LoadOptions::default() };
    for base in ["t.obj", "builtin:cornell"] {
        for more in ["", r#", "settings": { "headlight": true }"#] {
            assert!(!with(base, more, &dark).unwrap().settings.headlight, "{base}{more}");
        }
    }
    let has_texture = |scene: &Scene| scene.materials.iter().any(|m| m.textures.color.is_some());
    let plain = LoadOptions { textures: false, ..LoadOptions::default() };
    assert!(!has_texture(&with("builtin:solids", "", &plain).unwrap()));
    assert!(has_texture(&with("builtin:solids", "", &LoadOptions::default()).unwrap()));
    let little = LoadOptions { texture_memory_bytes: Some(1), ..LoadOptions::default() };
    assert!(matches!(with("builtin:solids", "", &little), Err(SceneError::TextureMemory { .. })));
}

#[test]
fn null_takes_away_what_the_base_says_of_devices() {
    let device =
        scene(&[("a.json", &over("ball.json", r#", "device": { "backend": null }"#)), ("ball.json", BALL)])
            .device;
    assert_eq!((device.backend, device.leaf_size), (None, Some(7)));
}

#[test]
fn a_camera_is_checked_with_all_its_digits() {
    // Single precision takes these two for one point.
    let camera = r#", "camera": { "position": [500000, 5000000.125, 0], "look-at": [500000, 5000000, 0], "up": [0, 0, 1] }"#;
    let files = [("a.json", &*over("t.obj", camera)), ("t.obj", TRIANGLE)];
    assert_ne!(scene(&files).camera.unwrap().look_at, Some(scene(&files).camera.unwrap().position));
    // What is not said is said in coordinates of the file, too.
    let camera = r#", "camera": { "look-at": [500000, 5000000, 0] }"#;
    let scene = scene(&[("a.json", &over("t.obj", camera)), ("t.obj", TRIANGLE)]);
    assert_eq!(scene.point_in_file(scene.camera.unwrap().position), [0.0, 0.0, 5.0]);
}

#[test]
fn what_is_wrong_inside_a_model_names_the_model() {
    for (text, start) in
        [("v 0 0 0\nf 1 2 9\n", "t.obj:2: "), ("v 0 0 0\nv 1e13 0 0\nv 0 1 0\nf 1 2 3\n", "t.obj:")]
    {
        let message = error(&[("a.json", &over("t.obj", "")), ("t.obj", text)]);
        assert!(message.starts_with(start), "{message}");
    }
    let lens = r#", "camera": { "lens": { "aperture-radius": 1 } }"#;
    let message = error(&[("a.json", &over("ball.json", lens)), ("ball.json", BALL)]);
    assert!(message.starts_with("a.json:1:") && message.contains("camera.lens"), "{message}");
}

#[test]
fn sixteen_bases_are_followed_and_no_more() {
    let chain = |length: usize| {
        let mut texts: Vec<_> =
            (0..length).map(|k| (format!("{k}.json"), over(&format!("{}.json", k + 1), ""))).collect();
        texts.push((format!("{length}.json"), BALL.into()));
        let files: Vec<(&str, &str)> =
            texts.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
        read(&files).map(|loaded| loaded.scene.settings.samples).map_err(|error| error.to_string())
    };
    assert_eq!(chain(16), Ok(3));
    let message = chain(17).unwrap_err();
    assert!(message.starts_with("16.json:1:25: base: more than 16 bases"), "{message}");
}

#[test]
fn bases_of_any_kind_are_asked_for_devices_and_missing_ones_have_a_hint() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    for (name, text) in [("c.json", PG1), ("t.obj", TRIANGLE), ("ball.json", BALL)] {
        write(name, text);
    }
    let path = folder.path().join("a.json");
    for more in ["", r#", "device": { "accel": "grid", "tree-depth": null }"#, r#", "output": "o.png""#] {
        for base in ["c.json", "t.obj", "ball.json", "builtin:glass"] {
            write("a.json", &over(base, more));
            let (requests, scene) =
                (scene_requests(&path), load(&path, &LoadOptions::default()).unwrap().scene);
            assert_eq!((requests.device, requests.output), (scene.device, scene.output), "{base}{more}");
            assert!(!requests.is_pg1);
        }
    }
    write("a.json", &over("bell.json", ""));
    let message = load(&path, &LoadOptions::default()).unwrap_err().to_string();
    assert!(
        message.contains("a.json:1:25: base: ") && message.ends_with("did you mean ball.json?"),
        "{message}"
    );
}

/// What one integrator does not read is refused where the file states it; a base may have been written for the other one.
#[test]
fn settings_are_those_of_the_integrator() {
    let with =
        |settings: &str| format!(r#"{{ "eosphor": 2, "base": "ball.json", "settings": {{ {settings} }} }}"#);
    let ball = BALL.replace(r#", "max-distance": 4, "lighting": "distance""#, r#", "energy-threshold": 0.5"#);
    let paths = with(r#""integrator": "path", "roulette": 7, "clamp-indirect": 3"#);
    let settings = scene(&[("a.json", &paths), ("ball.json", &ball)]).settings;
    assert_eq!((settings.integrator, settings.roulette), (Integrator::Path, 7));
    assert_eq!((settings.clamp_indirect, settings.energy_threshold), (Some(3.0), 0.5));
    for (keys, expected) in [
        (r#""integrator": "path", "shadows": "none""#, "the integrator path does not read \"shadows\""),
        (r#""roulette": 3"#, "the integrator whitted does not read \"roulette\""),
        (r#""integrator": "path", "roulette": 65"#, "65"),
        (r#""integrator": "path", "clamp-indirect": 0"#, "over 0"),
        (r#""integrator": "paths""#, "paths"),
    ] {
        let message = error(&[("a.json", &with(keys)), ("ball.json", &ball)]);
        assert!(message.contains(expected), "{keys}: {message}");
    }
    // What the base asks for, and path tracing cannot do.
    let message = error(&[("a.json", &with(r#""integrator": "path""#)), ("ball.json", BALL)]);
    assert!(message.contains("shows surfaces without light"), "{message}");
}

/// A sky by its angles, and by a time.
#[test]
fn skies_are_read() {
    let sky = |entry: &str| {
        let text = BALL.replace(r#""output""#, &format!(r#""environment": {entry}, "output""#));
        scene(&[("ball.json", &text)]).environment.unwrap()
    };
    assert_eq!(sky(r#"{ "sky": {} }"#), EnvironmentMap::of_sky(Sky::default()));
    let expected = Sky {
        sun_elevation_degrees: 5.0,
        sun_azimuth_degrees: -20.5,
        turbidity: 4.0,
        albedo: 0.1,
        sun_strength: 0.0,
    };
    let keys = r#""sun-elevation-degrees": 5, "sun-azimuth-degrees": -20.5, "turbidity": 4, "albedo": 0.1, "sun-strength": 0"#;
    let turned = EnvironmentMap { strength: 2.0, rotation_degrees: 90.0, ..EnvironmentMap::of_sky(expected) };
    assert_eq!(sky(&format!(r#"{{ "sky": {{ {keys} }}, "strength": 2, "rotation-degrees": 90 }}"#)), turned);
    let keys = r#""sun-at": {"time": "2003-10-17T12:30:30-07:00", "latitude-degrees": 39.742476, "longitude-degrees": -105.1786}"#;
    let EnvironmentSource::Sky(at_noon) = sky(&format!(r#"{{ "sky": {{ {keys} }} }}"#)).source else {
        panic!()
    };
    assert!((at_noon.sun_elevation_degrees - 39.872).abs() < 0.01, "{at_noon:?}");
    assert!((at_noon.sun_azimuth_degrees - 194.34).abs() < 0.01, "{at_noon:?}");
}

/// A glTF file has the settings of the integrator that the scene file names whose base it is.
#[test]
fn gltf_bases_follow_the_integrator() {
    let alone = scene(&[("x.gltf", GLTF)]).settings;
    assert_eq!((alone.integrator, alone.tone_curve), (Integrator::Path, ToneCurve::Neutral));
    let none = over("x.gltf", "");
    let path = over("x.gltf", r#", "settings": { "integrator": "path" }"#);
    let few = over("x.gltf", r#", "settings": { "integrator": "path", "samples": 5, "tone-curve": "agx" }"#);
    let read = |text: &str| scene(&[("a.json", text), ("x.gltf", GLTF)]).settings;
    assert_eq!(
        read(&none),
        RenderSettings { background: Vec3::splat(0.25), ambient: 0.25, ..Default::default() }
    );
    assert_eq!(read(&path), alone);
    assert_eq!(read(&few), RenderSettings { samples: 5, tone_curve: ToneCurve::Agx, ..alone });
    // The nearest file decides what the base is, and those above it go over that.
    let above = |text: &str, more: &str| {
        scene(&[("b.json", &over("a.json", more)), ("a.json", text), ("x.gltf", GLTF)]).settings
    };
    assert_eq!(above(&path, ""), alone);
    let paths = r#", "settings": { "integrator": "path" }"#;
    assert_eq!(above(&none, paths), RenderSettings { integrator: Integrator::Path, ..read(&none) });
}

/// What is saved over a glTF file is read as it was, by either integrator.
#[test]
fn saved_scenes_over_gltf_name_the_integrator() {
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let options = LoadOptions { integrator: Some(integrator), ..LoadOptions::default() };
        let files = vec![(PathBuf::from("x.gltf"), GLTF.as_bytes().to_vec())];
        let before = load_from_memory(files, "x.gltf", &options).unwrap().scene;
        for (samples, background) in [(before.settings.samples, before.settings.background), (7, Vec3::ZERO)]
        {
            let mut after = before.clone();
            (after.settings.samples, after.settings.background) = (samples, background);
            let text = scene_over_base("x.gltf", &before, &after, None).unwrap();
            assert!(text.contains("\"integrator\""), "{text}");
            assert_eq!(scene(&[("s.json", &text), ("x.gltf", GLTF)]).settings, after.settings, "{text}");
        }
    }
}

/// An environment is a file name, or a file and how it surrounds the scene; it takes the place of the base's.
#[test]
fn environments_are_read_and_replaced() {
    let ppm = ("t.ppm", "P3\n2 1\n255\n1 2 3 4 5 6\n");
    let ball = BALL.replace(r#""output""#, r#""environment": "t.ppm", "output""#);
    let environment = scene(&[("ball.json", &ball), ppm]).environment.unwrap();
    assert_eq!(environment, EnvironmentMap::of_image(0));
    let more = r#", "environment": { "file": "t.ppm", "strength": 3, "rotation-degrees": -40, "up": [0, 0, 2], "seen": false }"#;
    let other = scene(&[("a.json", &over("ball.json", more)), ("ball.json", &ball), ppm]);
    assert_eq!((other.images.len(), other.images[0].width), (1, 2));
    let expected = EnvironmentMap {
        source: EnvironmentSource::Image(0),
        strength: 3.0,
        rotation_degrees: -40.0,
        up: vec3(0.0, 0.0, 2.0),
        is_seen: false,
    };
    assert_eq!(other.environment, Some(expected));
    for (entry, message) in [
        (r#""no.ppm""#, "a.json:1:53: environment: no.ppm: "),
        (r#"{ "file": "no.ppm" }"#, "environment: no.ppm: "),
        (r#"{ "file": "t.ppm", "up": [0, 0, 0] }"#, "environment.up: it has no length"),
        (r#"{ "file": "t.ppm", "strength": -1 }"#, "strength"),
        (r#"{ "file": "t.ppm", "turn": 1 }"#, "turn"),
        (r#"{ "strength": 1 }"#, "is of no kind; give it"),
        (r#"{ "file": "t.ppm", "sky": {} }"#, "\"file\" and \"sky\" exclude each other"),
        (r#"{ "sky": { "turbidity": 11 } }"#, "turbidity"),
        (r#"{ "sky": { "turbidity": 0.9 } }"#, "turbidity"),
        (r#"{ "sky": { "sun-elevation-degrees": -1 } }"#, "sun-elevation-degrees"),
        (r#"{ "sky": { "albedo": 1.5 } }"#, "albedo"),
        (r#"{ "sky": { "sun": 3 } }"#, "sun"),
        (r#"{ "sky": { "sun-at": { "time": "2026-06-21T12:00Z" } } }"#, "latitude-degrees"),
        (
            r#"{ "sky": { "sun-at": { "time": "noon", "latitude-degrees": 0, "longitude-degrees": 0 } } }"#,
            "environment.sky.sun-at: \"noon\" is no date",
        ),
        (
            r#"{ "sky": { "sun-at": { "time": "2026-06-21T00:00Z", "latitude-degrees": 0, "longitude-degrees": 0 } } }"#,
            "degrees below the horizon",
        ),
        (
            r#"{ "sky": { "sun-at": { "time": "2026-06-21T12:00Z", "latitude-degrees": 0, "longitude-degrees": 0 },
                          "sun-elevation-degrees": 3 } }"#,
            "does nothing beside",
        ),
    ] {
        let text = over("ball.json", &format!(r#", "environment": {entry}"#));
        let error = error(&[("a.json", &text), ("ball.json", BALL), ppm]);
        assert!(error.contains(message), "{entry}: {error}");
    }
    // It lights what path tracing shows.
    let mut lit = scene(&[("ball.json", &ball), ppm]);
    let refused = SceneData::flatten(&lit).unwrap_err().to_string();
    assert!(refused.contains("environment: the integrator whitted has none"), "{refused}");
    lit.settings = RenderSettings { integrator: Integrator::Path, ..RenderSettings::default() };
    let (data, notes) = SceneData::flatten(&lit).unwrap();
    assert_eq!((data.environment.chance, data.environment.columns, data.environment.rows), (0.5, 2, 1));
    // For each of four bands, sums of two columns and a word of index, 3 + 1; for each column the same of two cells, and corners.
    assert_eq!((data.environment_table.len(), data.textures.len()), (4 * 4 + 2 * (4 + 2), 1));
    assert!(notes.is_empty() && data.check().is_ok(), "{notes:?}");
}
