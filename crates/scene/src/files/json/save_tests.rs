//! Scenes that are written as files over their base.

use super::scene_over_base;
use crate::files::{LoadOptions, load, load_from_memory};
use crate::flatten::SceneData;
use crate::model::{
    Camera, CameraMotion, DeviceKind, EnvironmentMap, Image, Lens, Light, PixelSampling, Scene, Sky, Texels,
};
use eosphor_core::develop::ToneCurve;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::{Integrator, LightingModel, ShadowMode};
use proptest::prelude::*;
use std::path::PathBuf;

const FAR: &str =
    "v 500000.25 5000000.5 100\nv 500001.25 5000000.5 100\nv 500000.25 5000001.5 100\nf 1 2 3\n";

/// The scenes that are changed; the second one has a camera that moves, the third one is far from 0.
const BASES: [&str; 4] = ["builtin:cornell", "builtin:solids", "far.obj", "builtin:glass"];

fn read(base: &str, over: Option<&str>) -> Scene {
    let mut files = vec![(PathBuf::from("far.obj"), FAR.into())];
    files.extend(over.map(|text| ("a.json".into(), text.as_bytes().to_vec())));
    match over {
        None if base.starts_with("builtin:") => load(base, &LoadOptions::default()).unwrap().scene,
        None => load_from_memory(files, base, &LoadOptions::default()).unwrap().scene,
        Some(text) => {
            let loaded = load_from_memory(files, "a.json", &LoadOptions::default());
            loaded.unwrap_or_else(|error| panic!("{error}\n{text}")).scene
        }
    }
}

/// Writes a scene over its base, and compares what is read.
fn check(base: &str, before: &Scene, after: &Scene) -> String {
    let text = scene_over_base(base, before, after, None).unwrap();
    let read = read(base, Some(&text));
    assert_eq!(
        (read.settings, &read.lights, read.device),
        (after.settings, &after.lights, after.device),
        "{text}"
    );
    assert_eq!((read.origin, read.frame), (after.origin, after.frame));
    let camera = |scene: &Scene| SceneData::flatten(scene).unwrap().0.camera;
    assert_eq!(camera(&read), camera(after), "{text}");
    for frame in [0, 1, 30] {
        let of = |scene: &Scene| {
            let camera = scene.camera_at(frame)?;
            Some((camera.position, camera.look_at, camera.up, camera.lens))
        };
        assert_eq!(of(&read), of(after), "{text}");
    }
    text
}

#[test]
fn what_is_the_same_is_not_written() {
    for base in BASES {
        let scene = read(base, None);
        let text = check(base, &scene, &scene);
        let [width, height] = scene.settings.size;
        let settings = format!(
            "\"settings\": {{\n    \"size\": [{width}, {height}],\n    \"samples\": {},\n    \"seed\": {}\n  }}\n}}\n",
            scene.settings.samples, scene.settings.seed
        );
        assert_eq!(text, format!("{{\n  \"eosphor\": 2,\n  \"base\": \"{base}\",\n  {settings}"));
    }
}

#[test]
fn lights_settings_and_device_are_written_where_they_differ() {
    for base in BASES {
        let before = read(base, None);
        let mut after = before.clone();
        let position = after.point_of_file([500_000.5, 5_000_001.75, 3.1]);
        after.lights.push(Light::Point { position, color: vec3(0.1, 2.0, 3e-7) });
        after.lights.push(Light::Spot {
            position,
            direction: vec3(0.1, -1.0, 0.0),
            inner_degrees: 3.5,
            outer_degrees: 20.1,
            color: Vec3::ONE,
        });
        let settings = &mut after.settings;
        (settings.max_distance, settings.ambient, settings.background) =
            (Some(0.1), 0.3, vec3(0.1, 0.2, 1e-3));
        (settings.pixel_sampling, settings.lighting) = (PixelSampling::Grid(3), LightingModel::Distance);
        after.device.backend = Some(DeviceKind::Cpu);
        after.output = Some("a \"b\".png".into());
        let text = check(base, &before, &after);
        assert!(text.contains("\"max-distance\": 0.1,") && text.contains("\"grid\": 3"), "{text}");
        // A grid that the base has stays, also where nothing changes.
        let with_grid = Scene { settings: after.settings, ..before.clone() };
        scene_over_base(base, &with_grid, &with_grid, None).unwrap();
        // What was set can be taken away again.
        check(base, &before, &Scene { settings: before.settings, ..after });
    }
}

#[test]
fn without_a_headlight_it_stays_dark() {
    let before = read("far.obj", None);
    let mut after = before.clone();
    (after.settings.headlight, after.settings.ambient, after.settings.background) = (false, 0.0, Vec3::ZERO);
    check("far.obj", &before, &after);
    after.settings.ambient = before.settings.ambient;
    check("far.obj", &before, &after);
}

#[test]
fn frames_of_stills_are_written() {
    let before = read("builtin:solids", None);
    let text = check("builtin:solids", &before, &Scene { frame: 77, ..before.clone() });
    assert!(text.contains("\"frame\": 77"), "{text}");
    let text = scene_over_base("builtin:solids", &before, &Scene { frame: 120, ..before.clone() }, None);
    assert!(text.unwrap_err().to_string().contains("frame: 120 is out of range; it must be 0 to 119"));
}

#[test]
fn what_cannot_be_said_is_named() {
    let before = read("builtin:glass", None);
    let refused = |change: fn(&mut Scene)| {
        let mut after = before.clone();
        change(&mut after);
        scene_over_base("builtin:glass", &before, &after, None).unwrap_err().to_string()
    };
    assert!(refused(|s| s.spheres[0].radius = 0.5).contains("the geometry was moved or changed"));
    assert!(refused(|s| s.materials[0].name.push('x')).contains("materials were changed"));
    assert!(refused(|s| s.animation = Some(crate::model::Animation::of_frames(9))).contains("animation"));
    assert!(refused(|s| s.camera = None).contains("the camera was taken away"));
    assert!(refused(|s| s.settings.samples = 0).contains("samples"));
}

/// A sky is said as it is, and a picture by its file, where there is one.
#[test]
fn environments_are_written() {
    let before = read("builtin:glass", None);
    let mut after = before.clone();
    after.settings.integrator = Integrator::Path;
    let sky =
        Sky { sun_elevation_degrees: 12.3, sun_azimuth_degrees: 251.7, turbidity: 7.5, ..Sky::default() };
    after.environment = Some(EnvironmentMap {
        strength: 0.3,
        rotation_degrees: 20.0,
        up: vec3(0.0, 0.0, 1.0),
        is_seen: false,
        ..EnvironmentMap::of_sky(sky)
    });
    let text = scene_over_base("builtin:glass", &before, &after, None).unwrap();
    let with_sky = read("builtin:glass", Some(&text));
    assert_eq!(with_sky.environment, after.environment, "{text}");
    assert_eq!(with_sky.settings, after.settings);
    // What is there already is not said once more.
    let again = scene_over_base("a.json", &with_sky, &with_sky, None).unwrap();
    assert!(!again.contains("environment"), "{again}");
    let mut plain = after.clone();
    plain.environment = Some(EnvironmentMap::of_sky(Sky::default()));
    let text = scene_over_base("builtin:glass", &before, &plain, None).unwrap();
    assert!(!text.contains("strength\": 0.3") && !text.contains("seen"), "{text}");

    let picture = Image { name: "t.ppm".into(), width: 1, height: 1, texels: Texels::rgba8(vec![0]) };
    let number = before.images.len() as u32;
    after.images.push(picture);
    after.environment = Some(EnvironmentMap { strength: 2.0, ..EnvironmentMap::of_image(number) });
    let text = scene_over_base("builtin:glass", &before, &after, Some("/a/t.ppm")).unwrap();
    assert!(text.contains(r#""file": "/a/t.ppm""#) && text.contains(r#""strength": 2"#), "{text}");
    let refused =
        |after: &Scene| scene_over_base("builtin:glass", &before, after, None).unwrap_err().to_string();
    assert!(refused(&after).contains("the environment was changed"));
    after.environment = None;
    assert!(refused(&after).contains("pictures of textures were changed"));
}

#[test]
fn meshes_textures_and_motions_cannot_be_said() {
    let before = read("builtin:solids", None);
    let refused = |change: fn(&mut Scene)| {
        let mut after = before.clone();
        change(&mut after);
        scene_over_base("builtin:solids", &before, &after, None).unwrap_err().to_string()
    };
    assert!(refused(|s| s.move_geometry([1.0, 0.0, 0.0])).contains("the geometry was moved"));
    assert!(refused(|s| s.meshes[0].positions[0].x += 1.0).contains("meshes were changed"));
    assert!(refused(|s| s.textures[0].uv_set ^= 1).contains("textures were changed"));
    assert!(refused(|s| s.images[0].name.push('x')).contains("pictures of textures were changed"));
    assert!(refused(|s| s.lights.clear()).contains("all lights were taken away"));
    assert!(
        refused(|s| s.camera = Some(Camera { fov_x_degrees: 12.0, ..Camera::default() }))
            .contains("moves as before")
    );
    let orbit: fn(&mut Scene) = |s| {
        let motion = CameraMotion::Orbit { turns: 1.0, around: None };
        s.animation.iter_mut().for_each(|animation| animation.camera = Some(motion.clone()));
    };
    assert!(refused(orbit).contains("the motion of the camera was changed"));
}

#[test]
fn coordinates_far_from_0_have_all_the_digits_that_there_are() {
    let before = read("far.obj", None);
    let mut after = before.clone();
    let position = before.point_of_file([500_000.125, 5_000_000.375, 7.5]);
    let look_at = Some(before.point_of_file([500_000.25, 5e6, 0.0]));
    after.camera = Some(Camera { position, look_at, ..Camera::default() });
    let text = check("far.obj", &before, &after);
    assert!(text.contains("\"position\": [500000.125, 5000000.375, 7.5]"), "{text}");
    assert!(text.contains("\"look-at\": [500000.25, 5000000, 0]"), "{text}");
    // What is nearer to the origin than the file has digits.
    after.camera = Some(Camera { position: vec3(1.0, 1.234_567e-9, 4.0), ..Camera::default() });
    let error = scene_over_base("far.obj", &before, &after, None).unwrap_err();
    assert!(error.to_string().starts_with("the camera is so close to the scene's origin"), "{error}");
}

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![-3.0..3.0f64, -1e-3..1e-3f64, Just(0.1), Just(-0.0), -900.0..900.0f64]
}

fn point() -> impl Strategy<Value = [f64; 3]> {
    [coordinate(), coordinate(), coordinate()]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn cameras_and_settings_are_read_as_they_were_written(
        base in 0..BASES.len(),
        (eye, look_at, aims) in (point(), point(), any::<bool>()),
        fov in 1.0..170.0f32,
        kind in 0..3,
        lens in proptest::option::of((1e-4..1.0f32, proptest::option::of(0.1..50.0f32))),
        (size, samples, depth) in ([1..300u32, 1..300u32], 1..65_536u32, 0..64u32),
        (exposure, seed) in (-9.0..9.0f32, any::<u32>()),
        curve in 0..4usize,
        shadows in 0..3usize,
    ) {
        let before = read(BASES[base], None);
        let mut after = before.clone();
        let middle = if BASES[base] == "far.obj" { [500_000.0, 5_000_000.0, 100.0] } else { [0.0; 3] };
        let placed = |p: [f64; 3]| after.point_of_file([0, 1, 2].map(|k| p[k] + middle[k]));
        let (position, look_at) = (placed(eye), placed(look_at));
        prop_assume!((look_at - position).length() > 1e-2);
        let camera = Camera {
            position,
            look_at: aims.then_some(look_at),
            direction: look_at - position,
            up: vec3(0.1, 1.0, 0.3),
            fov_x_degrees: fov,
            fov_y_degrees: (kind == 1).then_some(fov * 0.7),
            orthographic_height: (kind == 2).then_some(fov),
            lens: lens.map(|(aperture_radius, focus_distance)| Lens { aperture_radius, focus_distance }),
        };
        after.camera = Some(camera);
        after.animation.iter_mut().for_each(|animation| animation.camera = None);
        let settings = &mut after.settings;
        (settings.size, settings.samples, settings.depth) = (size, samples, depth);
        (settings.exposure, settings.seed) = (exposure, seed);
        settings.tone_curve = [ToneCurve::None, ToneCurve::Aces, ToneCurve::Agx, ToneCurve::Neutral][curve];
        settings.shadows = [ShadowMode::None, ShadowMode::Opaque, ShadowMode::Coloured][shadows];
        // A view along what is up is none.
        prop_assume!(after.validate().is_ok() && SceneData::flatten(&after).is_ok());
        match scene_over_base(BASES[base], &before, &after, None) {
            Ok(_) => { check(BASES[base], &before, &after); }
            // Near the point that a far scene is counted from, coordinates of the file lack digits.
            Err(error) => prop_assert!(BASES[base] == "far.obj" && error.to_string().contains("exactly its position"), "{error}"),
        }
    }
}
