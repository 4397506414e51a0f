//! Solids and quadrilaterals of JSON scenes: what they say is what the course's text says.

use crate::files::source::Source;
use crate::files::{LoadOptions, load_from};
use crate::flatten::{FrameStates, SceneData};
use crate::model::{Light, Scene};
use crate::{CourseInput, CourseOptions, Solid};
use eosphor_core::material::{Material, NONE};
use eosphor_core::math::{Vec3, vec3};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

fn load(whole: &Value) -> Scene {
    let files = vec![(PathBuf::from("s.json"), Cow::Owned(whole.to_string().into_bytes()))];
    load_from(Source::Memory(files), Path::new("s.json"), &LoadOptions::default()).unwrap().scene
}

fn list(v: Vec3) -> Value {
    json!([v.x, v.y, v.z])
}

/// The JSON scene that says what a course's text does.
fn of_course(input: &CourseInput, options: &CourseOptions) -> Value {
    let solid = |(body, shape): (&crate::CourseBody, Option<Solid>)| {
        let lit_by = if options.diodes { "edges" } else { "center" };
        let mut solid = json!({
            "shape": shape?.name(), "center": list(body.center), "radius": body.radius, "color": list(body.color),
            "reflection": body.reflection, "transparency": body.transparency, "lights-per-edge": body.lights_per_edge,
        });
        if body.lights_per_edge > 0 {
            solid["lit-by"] = json!({ lit_by: { "power": 0.7 } });
        }
        Some(solid)
    };
    let solids: Vec<Value> = input.bodies.iter().zip(options.shapes).filter_map(solid).collect();
    let light =
        |l: &crate::CourseLight| json!({ "point": { "position": list(l.position), "color": list(l.color) } });
    let floor = &input.floor;
    let law = |law| serde_json::to_value(law).unwrap();
    json!({
        "eosphor": 2,
        "camera": { "up": [0, 0, 1], "fov-x-degrees": input.fov_x_degrees },
        "lights": input.lights.iter().map(light).collect::<Vec<_>>(),
        "materials": { "floor": {
            "transparent": { "color": list(floor.tint), "transparency": 0, "reflection": floor.reflection, "diffuse": 0.5 },
            "texture": { "file": floor.texture, "wrap": "clamp" },
        } },
        "quadrilaterals": [{ "corners": floor.corners.map(list), "material": "floor" }],
        "solids": solids,
        "settings": {
            "size": input.size, "depth": input.depth, "pixel-sampling": { "grid": input.rays_root }, "lights": "all", "light-samples": 1,
            "lighting": "phong", "shadows": "coloured", "energy-threshold": 0.005, "normals": "flat",
            "light-units": "plain", "light-falloff": false, "srgb-textures": false, "transfer": "linear",
        },
        "animation": { "frames": input.frames,
            "camera": { "laws": { "position": law(input.position), "look-at": law(input.look_at) } } },
    })
}

/// Materials of triangles, without the numbers of their textures.
fn looks(data: &SceneData) -> Vec<(Material, bool)> {
    let look = |m: &Material| {
        let textured = m.diffuse_texture != NONE;
        (Material { diffuse_texture: NONE, emission_texture: NONE, ..*m }, textured)
    };
    data.triangle_shading.iter().map(|t| look(&data.materials[t.material as usize])).collect()
}

#[test]
fn they_are_those_of_the_course() {
    let mut crooked = CourseInput::colourful();
    crooked.floor.corners[2] = vec3(6.0, 6.0, -1.5);
    crooked.bodies[1].lights_per_edge = 0;
    let defaults = CourseOptions::default();
    let diodes = CourseOptions { diodes: true, ..defaults.clone() };
    let others =
        CourseOptions { shapes: [Some(Solid::Cube), None, Some(Solid::Icosahedron)], ..defaults.clone() };
    for (input, options) in [
        (CourseInput::colourful(), &defaults),
        (CourseInput::colourful(), &diodes),
        (crooked.clone(), &defaults),
        (crooked, &others),
    ] {
        let expected = input.scene(options).unwrap().scene;
        let scene = load(&of_course(&input, options));
        assert_eq!(scene.settings, expected.settings);
        assert_eq!(scene.animation, expected.animation);
        let [found, wanted] = [&scene, &expected].map(|scene| SceneData::flatten(scene).unwrap().0);
        assert!(found.triangles == wanted.triangles && !found.triangles.is_empty());
        assert_eq!(format!("{:?}", looks(&found)), format!("{:?}", looks(&wanted)));
        assert_eq!(found.lights, wanted.lights);
        assert_eq!((found.camera, found.settings), (wanted.camera, wanted.settings));
        let at = |scene, data| FrameStates::new(scene, data).at(17).unwrap();
        assert_eq!(at(&scene, &found), at(&expected, &wanted));
    }
}

/// A file's lights keep their numbers for its animation, though those of solids come first.
#[test]
fn animated_lights_are_those_of_the_file() {
    let lamp = |x: f32| json!({ "point": { "position": [x, 0, 5], "color": [1, 1, 1] } });
    let scene = load(&json!({
        "eosphor": 2,
        "lights": [lamp(1.0), lamp(2.0)],
        "solids": [{ "shape": "cube", "center": [0, 3, 0], "radius": 1, "lights-per-edge": 1 }],
        "animation": { "frames": 2, "lights": [
            { "light": 1, "keys": [{ "seconds": 0, "color": [0, 0, 9] }] }
        ] },
    }));
    let lights = scene.lights_at(0);
    let point = |position, color| Light::Point { position, color };
    let expected = [
        point(vec3(0.0, 3.0, 0.0), Vec3::splat(0.7)),
        point(vec3(1.0, 0.0, 5.0), Vec3::ONE),
        point(vec3(2.0, 0.0, 5.0), vec3(0.0, 0.0, 9.0)),
    ];
    assert_eq!(lights, expected);
}

/// Far from 0 a scene has the corners that it has near 0.
#[test]
fn far_away_they_are_the_same() {
    let scene = |x: f64, y: f64| {
        json!({
            "eosphor": 2,
            "origin": [x, y, 0],
            "camera": { "position": [x + 1.0, y, 9.0], "look-at": [x, y, 0], "up": [0, 1, 0] },
            "solids": [{ "shape": "cube", "center": [x + 0.25, y, 0.5], "radius": 1, "lights-per-edge": 1 }],
            "quadrilaterals": [{ "corners": [[x, y, -1], [x, y + 4.0, -1], [x + 5.0, y + 4.0, -1], [x + 4.0, y, -1]] }],
        })
    };
    let flat = |whole: &Value| SceneData::flatten(&load(whole)).unwrap().0;
    let (near, far) = (flat(&scene(0.0, 0.0)), flat(&scene(500_000.0, 4_999_999.5)));
    assert_eq!(near.triangles.len(), far.triangles.len());
    // Which corner is the first may depend on rounding.
    let middles = |data: &SceneData| -> Vec<Vec3> {
        data.triangles.iter().map(|[a, b, c]| (*a + *b + *c) * (1.0 / 3.0)).collect()
    };
    let is_near = |(a, b): (&Vec3, &Vec3)| (*a - *b).length() < 1e-5;
    assert!(middles(&near).iter().zip(&middles(&far)).all(is_near));
    assert_eq!(near.lights, far.lights);
    // The same without a stated origin, but about another point: single precision would leave half a unit.
    let mut open = scene(500_000.0, 4_999_999.5);
    open.as_object_mut().unwrap().remove("origin");
    let about_first = |data: &SceneData| {
        let middles = middles(data);
        middles.iter().map(|&p| p - middles[0]).collect::<Vec<_>>()
    };
    assert!(about_first(&near).iter().zip(&about_first(&flat(&open))).all(is_near));
}

#[test]
fn few_bytes_make_no_gigabytes() {
    let solid = json!({ "shape": "icosahedron", "center": [0, 0, 0], "radius": 1, "lights-per-edge": 1000 });
    let whole = json!({ "eosphor": 2, "solids": vec![solid; 100] });
    let files = vec![(PathBuf::from("s.json"), Cow::Owned(whole.to_string().into_bytes()))];
    let error = load_from(Source::Memory(files), Path::new("s.json"), &LoadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("they may have 2000000"), "{error}");
}

/// The camera by laws looks along z where it rests, which is up here; nobody sees it rest.
#[test]
fn a_camera_by_laws_does_not_rest() {
    let laws = json!({ "laws": { "position": { "r": 4, "z": 3, "phi-frequency": 1 }, "look-at": {} } });
    let keys = json!({ "keys": { "keys": [{ "seconds": 0, "position": [4, 0, 3], "look-at": [0, 0, 0] }] } });
    for motion in [laws, keys] {
        let lens = json!({ "aperture-radius": 0.1 });
        let scene = load(&json!({
            "eosphor": 2,
            "camera": { "up": [0, 0, 1], "lens": lens },
            "animation": { "frames": 4, "camera": motion },
        }));
        let camera = scene.camera_at(0).unwrap();
        assert_eq!((camera.position, camera.look_at), (vec3(4.0, 0.0, 3.0), Some(Vec3::ZERO)));
        let (data, _) = SceneData::flatten(&scene).unwrap();
        assert_eq!(data.camera.focus_distance, 5.0);
    }
}
