//! Cameras, lights and the settings that suit them.

use super::{File, read_with, triangle, whitted};
use crate::files::gltf::read_model;
use crate::files::loader::Loader;
use crate::files::source::Source;
use crate::files::{LoadOptions, LoadedScene};
use crate::model::{Light, RenderSettings, Scene};
use crate::{Note, SceneData};
use eosphor_core::develop::ToneCurve;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::Integrator;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::f32::consts::{FRAC_1_SQRT_2, PI};
use std::path::{Path, PathBuf};

fn with_camera(file: &File, camera: &str) -> Result<LoadedScene, String> {
    let options = LoadOptions { camera: Some(camera.into()), ..LoadOptions::default() };
    read_with(&[("a.glb", &file.glb())], &options).map_err(|e| e.to_string())
}

/// Three nodes with cameras; the first turned a quarter about y.
fn cameras() -> File {
    let turn = [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];
    triangle(json!({"nodes": [{"mesh": 0},
            {"camera": 1, "name": "front node", "translation": [1, 2, 3], "rotation": turn},
            {"camera": 0, "name": "above"}, {"camera": 0, "name": "1"}],
        "cameras": [
            {"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2, "zfar": 9, "znear": 0}},
            {"type": "perspective", "name": "front", "perspective": {"yfov": PI / 2.0, "znear": 0.1}}]}))
}

#[test]
fn the_first_camera_is_taken_and_the_others_are_named() {
    let loaded = cameras().load();
    let camera = loaded.scene.camera.unwrap();
    assert_eq!((camera.position, camera.fov_y_degrees), (vec3(1.0, 2.0, 3.0), Some(90.0)));
    assert!((camera.direction - vec3(-1.0, 0.0, 0.0)).length() < 1e-6, "{camera:?}");
    assert_eq!(camera.up, vec3(0.0, 1.0, 0.0));
    assert_eq!(
        loaded.warnings[0].to_string(),
        "a.glb: there are 3 cameras: 0 \"front\", 1 \"above\", 2 \"1\"; the first is taken"
    );
}

#[test]
fn cameras_are_chosen_by_name_or_number() {
    let height = |choice: &str| {
        let loaded = with_camera(&cameras(), choice)?;
        assert!(loaded.warnings.is_empty());
        Ok::<_, String>(loaded.scene.camera.unwrap().orthographic_height)
    };
    for (choice, expected) in [
        ("front", None),
        ("front node", None),
        ("0", None),
        ("above", Some(4.0)),
        ("1", Some(4.0)),
        ("2", Some(4.0)),
    ] {
        assert_eq!(height(choice), Ok(expected), "{choice}");
    }
    assert_eq!(
        height("side").unwrap_err(),
        "a.glb: there is no camera \"side\"; there are 0 \"front\", 1 \"above\", 2 \"1\""
    );
    assert_eq!(
        with_camera(&triangle(json!({})), "0").unwrap_err(),
        "a.glb: there is no camera \"0\"; the file has none"
    );
}

#[test]
fn cameras_without_a_view_are_left_out() {
    for (node, camera) in [
        (json!({}), json!({"type": "perspective", "perspective": {"yfov": 0, "znear": 1}})),
        (json!({}), json!({"type": "perspective", "perspective": {"yfov": 3.2, "znear": 1}})),
        (json!({}), json!({"type": "perspective"})),
        (json!({}), json!({"type": "odd"})),
        (
            json!({}),
            json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 0, "zfar": 1, "znear": 0}}),
        ),
        (json!({"scale": [1, 1, 0]}), json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 1}})),
    ] {
        let mut node = node;
        node["camera"] = 0.into();
        let loaded = triangle(json!({"nodes": [{"mesh": 0}, node], "cameras": [camera]})).load();
        assert!(loaded.scene.camera.is_none());
        assert!(loaded.warnings[0].to_string().starts_with("a.glb: camera 0 has no view"));
    }
}

fn lit(lights: Value, node: Value) -> Result<Scene, String> {
    let mut node = node;
    node["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    let file = triangle(json!({"nodes": [{"mesh": 0}, node], "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": lights}}}));
    read_with(&[("a.glb", &file.glb())], &LoadOptions::default())
        .map(|loaded| loaded.scene)
        .map_err(|e| e.to_string())
}

#[test]
fn lights_are_what_the_file_says_and_placed_by_their_nodes() {
    let near = |a: Vec3, b: Vec3| assert!((a - b).length() < 1e-6, "{a:?}, not {b:?}");
    let placed = || json!({"translation": [0, 5, 0], "rotation": [-FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2]});
    let scene = lit(json!([{"type": "point", "color": [1, 0.5, 0], "intensity": 2.0}]), placed()).unwrap();
    let Light::Point { position, color } = scene.lights[0] else { panic!() };
    near(position, vec3(0.0, 5.0, 0.0));
    near(color, vec3(2.0, 1.0, 0.0));
    // A file that brings light is dark around it.
    assert_eq!((scene.settings.background, scene.settings.ambient), (Vec3::ZERO, 0.0));

    let scene = lit(json!([{"type": "directional", "intensity": 3.0}]), placed()).unwrap();
    let Light::Directional { direction, color } = scene.lights[0] else { panic!() };
    near(direction, vec3(0.0, -1.0, 0.0));
    near(color, Vec3::splat(3.0));

    let cone = json!({"innerConeAngle": PI / 6.0, "outerConeAngle": PI / 3.0});
    let scene = lit(json!([{"type": "spot", "spot": cone, "range": 3}]), placed()).unwrap();
    let Light::Spot { position, direction, inner_degrees, outer_degrees, color } = scene.lights[0] else {
        panic!()
    };
    near(position, vec3(0.0, 5.0, 0.0));
    near(direction, vec3(0.0, -1.0, 0.0));
    near(color, Vec3::ONE);
    assert!((inner_degrees - 30.0).abs() + (outer_degrees - 60.0).abs() < 1e-4);
    let Light::Spot { inner_degrees, outer_degrees, .. } =
        lit(json!([{"type": "spot", "spot": {}}]), placed()).unwrap().lights[0]
    else {
        panic!()
    };
    assert_eq!((inner_degrees, outer_degrees), (0.0, 45.0));
}

#[test]
fn lights_that_are_wrong() {
    assert_eq!(lit(json!([]), json!({})).unwrap_err(), "a.glb: light 0 does not exist; there are 0");
    let message = lit(json!([{"type": "area"}]), json!({})).unwrap_err();
    assert_eq!(message, "a.glb: light 0: its type is unknown; it must be point, spot or directional");
    let message = lit(json!([{"type": "spot", "name": "s"}]), json!({"scale": [0, 0, 0]})).unwrap_err();
    assert_eq!(message, "a.glb: light \"s\": its node squashes it: no scale may be 0");
}

#[test]
fn files_without_light_get_surroundings() {
    let settings = |emission: f32| {
        let file = shining(json!({"emissiveFactor": [emission, 0, 0]}));
        read_with(&[("a.glb", &file.glb())], &whitted()).unwrap().scene.settings
    };
    assert_eq!((settings(0.0).background, settings(0.0).ambient), (Vec3::splat(0.25), 0.25));
    assert_eq!((settings(1.0).background, settings(1.0).ambient), (Vec3::ZERO, 0.0));
}

/// A triangle of one material; `t.ppm` is texture 0.
fn shining(material: Value) -> File {
    let images = json!([{"uri": "data:image/x-portable-pixmap;base64,UDMKMSAxCjI1NQoyNTUgMCAwCg=="}]);
    let mut file = triangle(json!({"images": images, "textures": [{"source": 0}], "materials": [material]}));
    file.root["meshes"][0]["primitives"][0]["material"] = 0.into();
    file
}

/// Path tracing gives surroundings to what has no light at all by itself. What shines through textures is light, but none to see
/// the rest by.
#[test]
fn shining_textures_do_not_keep_surroundings_away() {
    let textured = json!({"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}});
    let light = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    let mut lit = shining(textured.clone());
    lit.root["extensions"] = light;
    lit.root["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    let dark = LoadOptions { headlight: false, ..LoadOptions::default() };
    for (file, options, radiance, notes) in [
        (shining(json!({})), LoadOptions::default(), 0.0, vec![]),
        (shining(json!({"emissiveFactor": [1, 1, 1]})), LoadOptions::default(), 0.0, vec![]),
        (
            shining(textured.clone()),
            LoadOptions::default(),
            0.5,
            vec!["a.glb: only textures shine: uniform surroundings of radiance 0.5".to_owned()],
        ),
        (shining(textured), dark, 0.0, vec![]),
        (lit, LoadOptions::default(), 0.0, vec![]),
    ] {
        let loaded = read_with(&[("a.glb", &file.glb())], &options).unwrap();
        let settings = loaded.scene.settings;
        assert_eq!((settings.background, settings.ambient), (Vec3::splat(radiance), 0.0));
        assert_eq!(loaded.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(), notes);
    }
    let flattened = |file: File| SceneData::flatten(&file.load().scene).unwrap();
    let (data, notes) = flattened(shining(json!({})));
    assert_eq!(data.settings.background, Vec3::splat(0.5));
    assert!(notes.contains(&Note::Surroundings { radiance: 0.5 }), "{notes:?}");
    // Not where a lamp is all the light.
    let (data, _) = flattened(shining(json!({"emissiveFactor": [1, 1, 1]})));
    assert_eq!(data.settings.background, Vec3::ZERO);
}

/// Materials of glTF are defined for light from everywhere. Whoever loads the file may ask for the other method, whose settings are
/// as they were.
#[test]
fn paths_are_what_files_are_rendered_by() {
    let file = cameras();
    let paths = file.load().scene.settings;
    let expected = RenderSettings {
        integrator: Integrator::Path,
        samples: 32,
        tone_curve: ToneCurve::Neutral,
        ..RenderSettings::default()
    };
    assert_eq!(paths, expected);
    let other = read_with(&[("a.glb", &file.glb())], &whitted()).unwrap().scene.settings;
    let expected =
        RenderSettings { background: Vec3::splat(0.25), ambient: 0.25, ..RenderSettings::default() };
    assert_eq!(other, expected);
}

#[test]
fn a_model_is_its_meshes_alone() {
    let mut file = cameras();
    file.root["nodes"][0]["translation"] = json!([0, 0, 7]);
    let source = Source::Memory(vec![(PathBuf::from("m.glb"), Cow::Owned(file.glb()))]);
    let mut loader = Loader::new(source, &LoadOptions::default());
    // As after another model.
    loader.default_material();
    let instances = read_model(&mut loader, Path::new("m.glb")).unwrap();
    assert_eq!(instances.len(), 1);
    assert_eq!(instances[0].world_from_object.affine().translation, vec3(0.0, 0.0, 7.0));
    let loaded = loader.finish(Path::new("m.glb")).unwrap();
    assert_eq!(loaded.scene.meshes[0].triangles[0].material, 1);
    assert!(loaded.scene.camera.is_none() && loaded.warnings.is_empty());
    assert_eq!(loaded.scene.settings, RenderSettings::default());
}

#[test]
fn extensions_within_lights_do_no_harm() {
    let scene = lit(json!([{"type": "point", "extensions": {"EXT_lights_ies": {"x": 1}}}]), json!({}));
    assert_eq!(scene.map(|s| s.lights.len()), Ok(1));
}
