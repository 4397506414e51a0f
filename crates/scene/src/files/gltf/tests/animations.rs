//! Nodes that move, against positions computed by hand.

use super::{CORNERS, F32, File, I16, bytes, read, read_with, triangle};
use crate::files::{LoadOptions, LoadedScene};
use crate::model::{CameraMotion, Light, Scene};
use crate::{Moments, SceneData};
use eosphor_core::math::{Affine, Vec3, vec3};
use serde_json::{Value, json};
use std::f32::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

/// A file of these nodes, whose first mesh is a triangle, and an animation without channels.
fn file(nodes: Value) -> File {
    triangle(json!({"nodes": nodes, "animations": [{"channels": [], "samplers": []}]}))
}

impl File {
    /// Adds a sampler and a channel.
    fn animate<const N: usize>(
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
fn places(scene: &Scene, frame: u32) -> Vec<Affine> {
    let (data, _) = SceneData::flatten(scene).unwrap_or_else(|e| panic!("{e}"));
    let moment = Moments::new(scene, &data).at(frame).unwrap_or_else(|e| panic!("{e}"));
    moment.places.unwrap().instances[1..].iter().map(|instance| instance.world_from_object).collect()
}

fn near(a: Vec3, b: Vec3) {
    assert!((a - b).length() < 1e-5, "{a:?}, not {b:?}");
}

/// About z.
fn turn(degrees: f32) -> [f32; 4] {
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
fn steps_stay_until_the_next_key() {
    let mut file = file(json!([{"mesh": 0}]));
    // Of two at the same time, the last.
    let values = [[1.0; 3], [8.0; 3], [2.0; 3], [3.0; 3]];
    file.animate((0, "translation"), "STEP", &[0.5, 1.0, 1.0, 1.5], &values);
    let scene = file.load().scene;
    assert_eq!(scene.animation.as_ref().unwrap().frames, 36);
    for (frame, x) in [(0, 1.0), (12, 1.0), (23, 1.0), (24, 2.0), (35, 2.0), (36, 3.0), (99, 3.0)] {
        assert_eq!(places(&scene, frame)[0].translation, Vec3::splat(x), "{frame}");
    }
}

/// The formula of the specification, appendix C.5.
fn spline<const N: usize>(keys: &[[f32; N]; 6], span: f64, t: f64) -> [f64; N] {
    let [_, v0, b0, a1, v1, _] = keys.map(|key| key.map(f64::from));
    std::array::from_fn(|k| {
        (2.0 * t.powi(3) - 3.0 * t.powi(2) + 1.0) * v0[k]
            + span * (t.powi(3) - 2.0 * t.powi(2) + t) * b0[k]
            + (-2.0 * t.powi(3) + 3.0 * t.powi(2)) * v1[k]
            + span * (t.powi(3) - t.powi(2)) * a1[k]
    })
}

#[test]
fn cubic_splines_follow_the_formula() {
    let moves = [[9.0; 3], [1.0, 2.0, 3.0], [2.0, -1.0, 0.0], [0.0, 3.0, 1.0], [2.0, 0.0, 5.0], [9.0; 3]];
    let turns =
        [[9.0; 4], [0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.5, 0.0], [0.0; 4], [0.0, 0.6, 0.0, 0.8], [9.0; 4]];
    let mut file = file(json!([{"mesh": 0}]));
    file.animate((0, "translation"), "CUBICSPLINE", &[1.0, 3.0], &moves);
    file.animate((0, "rotation"), "CUBICSPLINE", &[1.0, 3.0], &turns);
    let scene = file.load().scene;
    assert_eq!(scene.animation.as_ref().unwrap().frames, 72);
    for frame in 0..80 {
        let t = ((f64::from(frame) / 24.0 - 1.0) / 2.0).clamp(0.0, 1.0);
        let place = places(&scene, frame)[0];
        // Parts are straight: keys are every sixteenth of a second.
        let tolerance = if frame % 3 == 0 { 1e-6 } else { 5e-3 };
        let expected = Vec3::from(spline(&moves, 2.0, t).map(|x| x as f32));
        assert!((place.translation - expected).length() < tolerance, "{frame}");
        let [x, y, z, w] = spline(&turns, 2.0, t);
        let length = (x * x + y * y + z * z + w * w).sqrt();
        let [x, y, z, w] = [x, y, z, w].map(|part| part / length);
        // Where the x axis goes.
        let axis = [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)];
        let axis = Vec3::from(axis.map(|x| x as f32));
        assert!((place.direction(vec3(1.0, 0.0, 0.0)) - axis).length() < tolerance, "{frame}");
    }
}

#[test]
fn short_curves_have_keys_at_different_times() {
    let mut file = file(json!([{"mesh": 0}]));
    let next = f32::from_bits(1000f32.to_bits() + 3);
    let values: Vec<[f32; 3]> = (0..9).map(|i| [i as f32; 3]).collect();
    file.animate((0, "scale"), "CUBICSPLINE", &[1000.0, next, 1001.0], &values);
    let scene = file.load().scene;
    let keys = &scene.instances[0].moves[0].keys;
    assert_eq!(keys.len(), 1 + 3 + 32);
    assert_eq!((keys[0].scale, keys[3].scale), (Some(Vec3::splat(1.0)), Some(Vec3::splat(4.0))));
}

#[test]
fn rotations_go_the_shorter_way() {
    let mut file = file(json!([{"mesh": 0}]));
    // The second says the same as 190 degrees, and the way from 100 is not over 0.
    file.animate((0, "rotation"), "LINEAR", &[0.0, 1.0], &[turn(100.0), turn(190.0).map(|x| -x)]);
    let axis = places(&file.load().scene, 12)[0].direction(vec3(1.0, 0.0, 0.0));
    near(axis, vec3(145f32.to_radians().cos(), 145f32.to_radians().sin(), 0.0));
}

#[test]
fn values_may_be_normalised_integers() {
    let mut file = file(json!([{"mesh": 0}]));
    file.animate((0, "rotation"), "LINEAR", &[0.0, 1.0], &[turn(0.0), turn(90.0)]);
    let quarter = [0i16, 0, 23_170, 23_170].map(i16::to_le_bytes).concat();
    let output = file.accessor(I16, "VEC4", 2, &[quarter.clone(), quarter].concat());
    file.root["accessors"][output]["normalized"] = true.into();
    file.root["animations"][0]["samplers"][0]["output"] = output.into();
    near(places(&file.load().scene, 0)[0].direction(vec3(1.0, 0.0, 0.0)), vec3(0.0, 1.0, 0.0));
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
    assert_eq!(Vec3::from(Moments::new(&scene, &data).at(12).unwrap().camera.eye), half.position);

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
            "a.glb: animation 0: 5 channels are left out: weights of morph targets, pointers, and nodes that have a \
          matrix are not animated, only translation, rotation and scale of nodes"
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

#[test]
fn samplers_that_are_wrong() {
    let message = |change: &dyn Fn(&mut File)| {
        let mut file = file(json!([{"mesh": 0}]));
        file.animate((0, "rotation"), "LINEAR", &[0.0, 1.0], &[turn(0.0), turn(90.0)]);
        change(&mut file);
        let message = file.error();
        assert!(!message.contains('\n'), "{message}");
        message
    };
    let of_times = |times: &[f32]| {
        message(&|file| {
            let input = file.accessor(F32, "SCALAR", times.len(), &bytes(times));
            file.root["animations"][0]["samplers"][0]["input"] = input.into();
        })
    };
    let of_values = |values: &[[f32; 4]]| {
        message(&|file| {
            file.root["animations"][0]["samplers"][0]["output"] = file.floats(values).into();
        })
    };
    let of_json = |pointer: &str, value: Value| {
        message(&|file| *file.root.pointer_mut(pointer).unwrap() = value.clone())
    };
    let at = "a.glb: animation 0, sampler 0: ";
    for (found, expected) in [
        (of_times(&[]), "it has no keys; export it again"),
        (of_times(&[-1.0, 1.0]), "the time of key 0 is -1; it must be 0 to 1e9 seconds; export it again"),
        (
            of_times(&[0.0, f32::NAN]),
            "the time of key 1 is NaN; it must be 0 to 1e9 seconds; export it again",
        ),
        (
            of_times(&[0.0, 2e9]),
            "the time of key 1 is 2000000000; it must be 0 to 1e9 seconds; export it again",
        ),
        (of_times(&[2.0, 1.5]), "its times must increase: 2 is followed by 1.5; export it again"),
        (of_times(&[1.0]), "there are 2 values for 1 times, not one for each; export it again"),
        (of_values(&[turn(0.0); 3]), "there are 3 values for 2 times, not one for each; export it again"),
        (
            of_json("/animations/0/samplers/0/interpolation", json!("CUBICSPLINE")),
            "there are 2 values for 2 times, not three for each; export it again",
        ),
        (
            of_json("/animations/0/samplers/0/interpolation", json!("BEZIER")),
            "its interpolation is unknown; it must be LINEAR, STEP or CUBICSPLINE",
        ),
        (of_values(&[turn(0.0), [0.0; 4]]), "the rotation of key 1 has no length; export it again"),
        (
            of_values(&[[0.0, f32::INFINITY, 0.0, 0.0], turn(0.0)]),
            "the values of key 0 are not finite; export it again",
        ),
        (
            of_json("/animations/0/channels/0/target/path", json!("scale")),
            "its values: accessor 2: it has 4 components, not 3; export it again",
        ),
        (
            of_json("/animations/0/samplers/0/input", json!(9)),
            "its times: accessor 9 does not exist; there are 3",
        ),
    ] {
        assert_eq!(found.strip_prefix(at), Some(expected), "{found}");
    }
    assert_eq!(
        of_json("/animations/0/channels/0/target/node", json!(7)),
        "a.glb: animation 0, channel 0: node 7 does not exist; there are 1; mend the file"
    );
    let message = message(&|file| {
        file.root["animations"][0]["name"] = "walk\n".into();
        file.root["animations"][0]["channels"][0]["sampler"] = 3.into();
    });
    assert_eq!(
        message,
        "a.glb: animation \"walk \", channel 0: sampler 3 does not exist; there are 1; mend the file"
    );
    // Tangents have no length where nothing turns.
    let mut file = file(json!([{"mesh": 0}]));
    let keys = [[0.0; 4], turn(0.0), [0.0; 4], [0.0; 4], turn(180.0).map(|x| -x), [0.0; 4]];
    file.animate((0, "rotation"), "CUBICSPLINE", &[0.0, 1.0], &keys);
    let opposite = [[0.0; 4], turn(0.0), [0.0; 4], [0.0; 4], turn(0.0).map(|x| -x), [0.0; 4]];
    file.animate((0, "rotation"), "CUBICSPLINE", &[0.0, 1.0], &opposite);
    assert!(SceneData::flatten(&file.load().scene).is_ok());
}

#[test]
fn small_files_do_not_make_large_scenes() {
    let spent = "far more elements than its buffers have bytes; mend the file";
    // A chain, and at each of its ends something to see.
    let chain = |length: usize, mesh: &dyn Fn(usize) -> bool| {
        let mut nodes: Vec<Value> = (1..=length).map(|i| json!({"children": [i]})).collect();
        nodes.push(json!({}));
        for (i, node) in nodes.iter_mut().enumerate().filter(|(i, _)| mesh(*i)) {
            node["mesh"] = 0.into();
            node["name"] = i.to_string().into();
        }
        let mut file = file(nodes.into());
        file.animate((0, "translation"), "STEP", &[0.0, 1.0], &[[0.0; 3], [1.0; 3]]);
        let channel = |node| json!({"sampler": 0, "target": {"node": node, "path": "translation"}});
        file.root["animations"][0]["channels"] = (0..length).map(channel).collect();
        file
    };
    let deep = chain(50_000, &|i| i == 50_000).load().scene;
    assert_eq!(deep.instances[0].moves.len(), 50_000);
    assert!(chain(5_000, &|_| true).error().ends_with(spent));
    // One sampler's keys for very many others, and for the camera's own.
    let times: Vec<f32> = (0..2000).map(|i| i as f32).collect();
    let mut many = file(json!([{"mesh": 0}]));
    many.animate((0, "scale"), "CUBICSPLINE", &times, &vec![[1.0; 3]; 6000]);
    assert!(SceneData::flatten(&many.load().scene).is_ok());
    let mut file = chain(1_000, &|i| i == 0);
    let input = file.accessor(F32, "SCALAR", 2000, &bytes(&times));
    let output = file.floats(&vec![[1.0; 3]; 2000]);
    file.root["animations"][0]["samplers"][0] = json!({"input": input, "output": output});
    assert_eq!(file.load().scene.animation.unwrap().frames, 1999 * 24);
    file.root["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}]);
    file.root["nodes"][999]["camera"] = 0.into();
    assert!(file.error().ends_with(spent));
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
