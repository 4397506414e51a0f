//! Samplers: their keys, wrong ones, and too many.

use super::animations::{file, near, places, turn};
use super::{F32, File, I16, bytes};
use crate::SceneData;
use eosphor_core::math::{Vec3, vec3};
use serde_json::{Value, json};

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
fn values_may_be_normalised_integers() {
    let mut file = file(json!([{"mesh": 0}]));
    file.animate((0, "rotation"), "LINEAR", &[0.0, 1.0], &[turn(0.0), turn(90.0)]);
    let quarter = [0i16, 0, 23_170, 23_170].map(i16::to_le_bytes).concat();
    let output = file.accessor(I16, "VEC4", 2, &[quarter.clone(), quarter].concat());
    file.root["accessors"][output]["normalized"] = true.into();
    file.root["animations"][0]["samplers"][0]["output"] = output.into();
    near(places(&file.load().scene, 0)[0].direction(vec3(1.0, 0.0, 0.0)), vec3(0.0, 1.0, 0.0));
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
