//! Nodes that move, against positions computed by hand.

use super::{CORNERS, F32, File, bytes, read, read_with, triangle};
use crate::files::{LoadOptions, LoadedScene};
use crate::model::{CameraMotion, Light, Scene};
use crate::{FrameStates, SceneData};
use eosphor_core::math::{Affine, Vec3, vec3};
use serde_json::{Value, json};
use std::f32::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

/// A file of these nodes, whose first mesh is a triangle, and an animation without channels.
pub(super) fn file(nodes: Value) -> File {
    triangle(json!({"nodes": nodes, "animations": [{"channels": [], "samplers": []}]}))
}

impl File {
    /// Adds a sampler and a channel.
    pub(super) fn animate<const N: usize>(
        &mut self,
        (node, path): (usize, &str),
        kind: &str,
        times: &[f32],
        values: &[[f32; N]],
    ) {
        let input = self.accessor(F32, "SCALAR", times.len(), &bytes(times));
        let output = self.floats(values);
        let animation = &mut self.root["animations"][0];
        let sampler = super::push(
            &mut animation["samplers"],
            json!({"input": input, "interpolation": kind, "output": output}),
        );
        let target = json!({"node": node, "path": path});
        super::push(&mut animation["channels"], json!({"sampler": sampler, "target": target}));
    }
}

/// Where the instances are in a frame.
pub(super) fn places(scene: &Scene, frame: u32) -> Vec<Affine> {
    let (data, _) = SceneData::flatten(scene).unwrap_or_else(|e| panic!("{e}"));
    let state = FrameStates::new(scene, &data).at(frame).unwrap_or_else(|e| panic!("{e}"));
    state.places.unwrap().instances[1..].iter().map(|instance| instance.world_from_object).collect()
}

pub(super) fn near(a: Vec3, b: Vec3) {
    assert!((a - b).length() < 1e-5, "{a:?}, not {b:?}");
}

/// About z.
pub(super) fn turn(degrees: f32) -> [f32; 4] {
    let half = 0.5 * degrees.to_radians();
    [0.0, 0.0, half.sin(), half.cos()]
}

/// 0 is animated and twice as large, 1 stays in it, 2 is animated in 1, 3 stays in 0, 4 is on its own.
fn tree() -> File {
    let mut file = file(json!([
        {"children": [1, 3], "scale": [2, 2, 2], "translation": [9, 9, 9]},
        {"children": [2], "translation": [1, 0, 0]},
        {"mesh": 0},
        {"mesh": 0, "translation": [0, 3, 0]},
        {"mesh": 0, "translation": [0, 0, 7], "scale": [1, 2, 3]},
    ]));
    file.animate((0, "rotation"), "LINEAR", &[0.0, 1.0], &[turn(0.0), turn(90.0)]);
    file.animate((0, "translation"), "LINEAR", &[0.0, 1.0], &[[0.0; 3], [4.0, 0.0, 0.0]]);
    file.animate((2, "translation"), "LINEAR", &[0.0, 2.0], &[[0.0; 3], [0.0, 4.0, 0.0]]);
    file
}

#[test]
fn nodes_carry_the_nodes_below() {
    let loaded = tree().load();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = loaded.scene;
    let animation = scene.animation.as_ref().unwrap();
    assert_eq!((animation.frames, animation.fps), (48, 24.0));
    assert!(animation.camera.is_none() && animation.lights.is_empty());

    // After half a second 2 is at (0, 1, 0), in 1 at (1, 1, 0), times 2, turned by 45 degrees, moved by (2, 0, 0).
    let diagonal = FRAC_1_SQRT_2;
    let half = places(&scene, 12);
    near(half[0].point(Vec3::ZERO), vec3(2.0, 4.0 * diagonal, 0.0));
    near(half[0].direction(vec3(1.0, 0.0, 0.0)), vec3(2.0 * diagonal, 2.0 * diagonal, 0.0));
    near(half[1].point(Vec3::ZERO), vec3(2.0 - 6.0 * diagonal, 6.0 * diagonal, 0.0));
    // After one, at (0, 2, 0), (1, 2, 0), (2, 4, 0), (-4, 2, 0); from then on 0 stays.
    near(places(&scene, 24)[0].point(Vec3::ZERO), vec3(0.0, 2.0, 0.0));
    near(places(&scene, 36)[0].point(Vec3::ZERO), vec3(-2.0, 2.0, 0.0));
    near(places(&scene, 100)[0].point(Vec3::ZERO), vec3(-4.0, 2.0, 0.0));
    near(places(&scene, 0)[1].point(Vec3::ZERO), vec3(0.0, 6.0, 0.0));

    // What does not move is as without the animation, and motions are shared.
    let mut still = tree();
    still.root.as_object_mut().unwrap().remove("animations");
    let still = still.load().scene;
    assert!(still.animation.is_none() && !still.has_moving_instances());
    assert!(scene.instances[2].moves.is_empty());
    assert_eq!(scene.instances[2].world_from_object, still.instances[2].world_from_object);
    let [a, b] = [&scene.instances[0].moves, &scene.instances[1].moves];
    // One of 2, 1 with the scale of 0, rotation and translation of 0.
    assert_eq!((a.len(), b.len()), (4, 2));
    assert!(Arc::ptr_eq(&a[2], &b[0]) && Arc::ptr_eq(&a[3], &b[1]));
}

#[test]
fn what_no_channel_animates_is_the_nodes_own() {
    let own = json!({"mesh": 0, "scale": [2, 1, 1], "rotation": turn(90.0), "translation": [5, 0, 0]});
    let p = vec3(1.0, 0.0, 0.0);
    let at = |path: &str, value: &[f32]| {
        let mut file = file(json!([own]));
        match value {
            &[x, y, z] => file.animate((0, path), "LINEAR", &[0.0], &[[x, y, z]]),
            _ => file.animate((0, path), "LINEAR", &[0.0], &[turn(0.0)]),
        }
        let scene = file.load().scene;
        assert_eq!(scene.animation.as_ref().unwrap().frames, 1);
        places(&scene, 0)[0].point(p)
    };
    near(at("translation", &[0.0, 0.0, 1.0]), vec3(0.0, 2.0, 1.0));
    near(at("rotation", &[]), vec3(7.0, 0.0, 0.0));
    near(at("scale", &[3.0, 1.0, 1.0]), vec3(5.0, 3.0, 0.0));
}

#[test]
fn rotations_go_the_shorter_way() {
    let mut file = file(json!([{"mesh": 0}]));
    // The second says the same as 190 degrees, and the way from 100 is not over 0.
    file.animate((0, "rotation"), "LINEAR", &[0.0, 1.0], &[turn(100.0), turn(190.0).map(|x| -x)]);
    let axis = places(&file.load().scene, 12)[0].direction(vec3(1.0, 0.0, 0.0));
    near(axis, vec3(145f32.to_radians().cos(), 145f32.to_radians().sin(), 0.0));
}

/// A node that goes from the origin to (4, 0, 0) in a second and turns there, with a child that holds these.
fn carrying(child: Value, more: Value) -> File {
    let mut file = file(json!([{"children": [1]}, child, {"mesh": 0}]));
    for (key, value) in more.as_object().unwrap() {
        file.root[key] = value.clone();
    }
    file.animate((0, "translation"), "LINEAR", &[0.0, 1.0], &[[0.0; 3], [4.0, 0.0, 0.0]]);
    let about_y = [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];
    file.animate((0, "rotation"), "STEP", &[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], about_y]);
    file
}

#[test]
fn cameras_are_carried() {
    let perspective = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}]);
    let child = json!({"camera": 0, "translation": [0, 0, 2]});
    let loaded = carrying(child, json!({"cameras": perspective})).load();
    let scene = loaded.scene;
    let animation = scene.animation.as_ref().unwrap();
    assert!(matches!(&animation.camera, Some(CameraMotion::Moves(moves)) if moves.len() == 2));
    assert_eq!(animation.frames, 24);
    let [half, end] = [12, 24].map(|frame| scene.camera_at(frame).unwrap());
    near(half.position, vec3(2.0, 0.0, 2.0));
    near(half.direction, vec3(0.0, 0.0, -1.0));
    // A quarter about y takes z to x.
    near(end.position, vec3(6.0, 0.0, 0.0));
    near(end.direction, vec3(-1.0, 0.0, 0.0));
    near(end.up, vec3(0.0, 1.0, 0.0));
    let (data, _) = SceneData::flatten(&scene).unwrap();
    assert_eq!(FrameStates::new(&scene, &data).at(12).unwrap().camera.eye, half.position);

    // One that is not chosen, and stays.
    let mut file = carrying(json!({"camera": 0}), json!({"cameras": perspective}));
    file.root["nodes"][2]["camera"] = 0.into();
    let options = LoadOptions { camera: Some("1".into()), ..LoadOptions::default() };
    let scene = read_with(&[("a.glb", &file.glb())], &options).unwrap().scene;
    assert!(scene.camera.is_some() && scene.animation.is_none());
}

#[test]
fn lights_are_carried() {
    let child = json!({"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 1, 2]});
    let light = |kind: &str| {
        let extensions = json!({"KHR_lights_punctual": {"lights": [{"type": kind}]}});
        let scene = carrying(child.clone(), json!({"extensions": extensions})).load().scene;
        assert_eq!(scene.animation.as_ref().map(|a| (a.frames, a.lights.len())), Some((24, 1)));
        [12, 24].map(|frame| scene.lights_at(frame)[0])
    };
    let [Light::Point { position: half, .. }, Light::Point { position: end, .. }] = light("point") else {
        panic!()
    };
    near(half, vec3(2.0, 1.0, 2.0));
    near(end, vec3(6.0, 1.0, 0.0));
    let [Light::Directional { direction: half, .. }, Light::Directional { direction: end, .. }] =
        light("directional")
    else {
        panic!()
    };
    near(half, vec3(0.0, 0.0, -1.0));
    near(end, vec3(-1.0, 0.0, 0.0));
}

#[test]
fn instances_of_the_extension_all_move() {
    let mut file = file(json!([{"mesh": 0, "scale": [2, 2, 2], "extensions":
        {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}}]));
    file.animate((0, "translation"), "LINEAR", &[0.0, 1.0], &[[0.0; 3], [4.0, 0.0, 0.0]]);
    // The corners are where the three are.
    let found = places(&file.load().scene, 12);
    assert_eq!(found.len(), 3);
    for (place, corner) in found.iter().zip(CORNERS) {
        near(place.translation, vec3(2.0, 0.0, 0.0) + Vec3::from(corner) * 2.0);
    }
}

#[test]
fn the_first_of_several_animations_is_played() {
    let mut file = tree();
    file.root["animations"][0]["name"] = "walk".into();
    push_animation(&mut file, json!({"name": "run", "channels": [], "samplers": []}));
    push_animation(&mut file, json!({"channels": [], "samplers": []}));
    let loaded = file.load();
    assert_eq!(loaded.scene.animation.unwrap().frames, 48);
    let warnings: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(warnings, ["a.glb: there are 3 animations: 0 \"walk\", 1 \"run\", 2; the first is played"]);
}

fn push_animation(file: &mut File, animation: Value) {
    super::push(&mut file.root["animations"], animation);
}

#[test]
fn channels_of_other_kinds_are_left_out() {
    let mut file = file(json!([{"mesh": 0}, {"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]}]));
    file.root["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    file.animate((0, "translation"), "STEP", &[0.0, 1.0], &[[1.0; 3], [2.0; 3]]);
    for target in [
        json!({"node": 0, "path": "weights"}),
        json!({"node": 0, "path": "mood"}),
        json!({"path": "translation"}),
        json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/materials/0"}}}),
        json!({"node": 1, "path": "scale"}),
    ] {
        let channel = json!({"sampler": 99, "target": target});
        super::push(&mut file.root["animations"][0]["channels"], channel);
    }
    let loaded = file.load();
    assert_eq!(places(&loaded.scene, 24)[0].translation, Vec3::splat(2.0));
    let warnings: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(
        warnings,
        [
            "a.glb: animation 0: 5 channels are left out: only translation, rotation and scale of nodes that have no \
          matrix are animated, and weights of morph targets"
        ]
    );
}

#[test]
fn nothing_that_is_shown_moves() {
    let mut file = file(json!([{"mesh": 0}, {"name": "bone"}]));
    file.animate((1, "translation"), "STEP", &[0.0, 1.0], &[[1.0; 3], [2.0; 3]]);
    let loaded = file.load();
    assert!(loaded.scene.animation.is_none() && loaded.warnings.is_empty());
}

#[test]
fn scales_of_zero_hide() {
    // In a motion: for as long as it lasts.
    let mut keyed = file(json!([{"mesh": 0}, {"mesh": 0}]));
    keyed.animate((0, "scale"), "STEP", &[0.0, 1.0], &[[0.0; 3], [1.0; 3]]);
    let scene = keyed.load().scene;
    assert!(places(&scene, 0)[0].direction(Vec3::ONE).length() < 1e-5);
    assert_eq!(places(&scene, 24)[0].direction(Vec3::ONE), Vec3::ONE);
    // Between motions, before and after them: for good.
    for (scaled, lamp) in [(0, 1), (1, 2), (2, 3)] {
        let mut file = file(json!([{"children": [1]}, {"children": [2]}, {"children": [3]},
            {"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}, {"mesh": 0}]));
        file.root["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
        file.root["nodes"][scaled]["scale"] = json!([1, 0, 1]);
        for node in [0, lamp] {
            file.animate((node, "translation"), "LINEAR", &[0.0, 1.0], &[[0.0; 3], [1.0; 3]]);
        }
        let loaded = file.load();
        assert_eq!((loaded.scene.instances.len(), loaded.scene.lights.len()), (1, 1), "{scaled}");
        assert!(loaded.warnings[0].to_string().contains("node 3 is squashed flat"), "{:?}", loaded.warnings);
        assert!(SceneData::flatten(&loaded.scene).is_ok());
    }
}

/// A JSON scene with these entries and the tree as `m.glb`.
fn json_scene(rest: Value) -> LoadedScene {
    let mut scene = rest;
    scene["eosphor"] = 1.into();
    let text = scene.to_string();
    read(&[("s.json", text.as_bytes()), ("m.glb", &tree().glb())]).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn models_move_within_json_scenes() {
    let loaded = json_scene(json!({
        "meshes": [{"file": "m.glb", "name": "m", "transform": {"rotate-degrees": [0, 0, 90]}}],
        "instances": [{"mesh": "m", "transform": {"scale": 2, "translate": [0, 0, 10]}, "moves": [
            {"keys": [{"seconds": 0, "translate": [0, 0, 0]}, {"seconds": 3, "translate": [0, 0, 6]}],
                "interpolation": "linear"}]}],
    }));
    let scene = loaded.scene;
    // As long as the last key, at 3 seconds.
    assert_eq!(scene.animation.as_ref().map(|a| (a.frames, a.fps)), Some((72, 24.0)));
    // The point of the tree after one second, (0, 2, 0), is turned to (-2, 0, 0), then twice as far, and above.
    near(places(&scene, 24)[0].point(Vec3::ZERO), vec3(-4.0, 0.0, 12.0));
    // What stays in the model moves as the scene says.
    assert_eq!(scene.instances[2].moves.len(), 1);
    near(places(&scene, 24)[2].point(Vec3::ZERO), vec3(0.0, 0.0, 26.0));

    let moved = json!({"file": "m.glb", "transform": {"translate": [0, 0, 1]},
        "moves": [{"keys": [{"seconds": 0, "scale": 3}]}]});
    let scene = json_scene(json!({"meshes": [moved]})).scene;
    assert_eq!(scene.animation.as_ref().unwrap().frames, 48);
    near(places(&scene, 24)[0].point(Vec3::ZERO), vec3(0.0, 6.0, 3.0));

    // The scene's own animation counts.
    let scene =
        json_scene(json!({"meshes": [{"file": "m.glb"}], "animation": {"frames": 5, "fps": 1}})).scene;
    assert_eq!(scene.animation.as_ref().unwrap().frames, 5);
    near(places(&scene, 1)[0].point(Vec3::ZERO), vec3(0.0, 2.0, 0.0));
}
