//! What lies far from 0 is the same as what lies near: the arrays that devices read are equal, bit by bit.

use super::{LoadOptions, LoadedScene, load_from_memory};
use crate::error::SceneError;
use crate::files::reference_systems::Preset;
use crate::flatten::{FrameStates, SceneData};
use crate::model::{Camera, Light, Scene};
use eosphor_core::math::{Vec3, vec3};
use proptest::prelude::*;
use std::path::PathBuf;

/// As UTM coordinates are; on the grid of models of 2 to 4.
const UTM: [f64; 3] = [500_000.0, 5_000_000.0, 96.0];
const HERE: [f64; 3] = [0.0; 3];

/// A tetrahedron with details of a millimetre or so, which are exact in double precision at UTM.
const CORNERS: [[f64; 3]; 4] = [
    [0.25, -0.5, 0.125],
    [2.5 + 1.0 / 1024.0, -0.5, 0.0],
    [1.0, 1.5 - 3.0 / 1024.0, 0.25],
    [1.0, 0.0, 2.0 + 1.0 / 512.0],
];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

type Files = Vec<(PathBuf, Vec<u8>)>;

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn obj(corners: &[[f64; 3]], at: [f64; 3]) -> Vec<u8> {
    let vertex = |c: &[f64; 3]| {
        let [x, y, z] = add(*c, at);
        format!("v {x} {y} {z}\n")
    };
    let faces: String = FACES.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)).collect();
    (corners.iter().map(vertex).collect::<String>() + &faces).into_bytes()
}

fn ply(format: &str, at: [f64; 3]) -> Vec<u8> {
    let mut file = format!(
        "ply\nformat {format} 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
         element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let little = format.contains("little");
    let turned = |bytes: &[u8]| -> Vec<u8> {
        if little { bytes.to_vec() } else { bytes.iter().rev().copied().collect() }
    };
    for corner in CORNERS {
        let p = add(corner, at);
        match format {
            "ascii" => file.extend(format!("{} {} {}\n", p[0], p[1], p[2]).bytes()),
            _ => p.iter().for_each(|x| file.extend(turned(&x.to_le_bytes()))),
        }
    }
    for face in FACES {
        match format {
            "ascii" => file.extend(format!("3 {} {} {}\n", face[0], face[1], face[2]).bytes()),
            _ => {
                file.push(3);
                face.iter().for_each(|&i| file.extend(turned(&(i as u32).to_le_bytes())));
            }
        }
    }
    file
}

/// A glTF file of the tetrahedron: its node is at `at` by a parent, and moves where `moves`. It has a camera and a light.
fn gltf(vertices_at: [f64; 3], at: [f64; 3], moves: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    for corner in CORNERS {
        add(corner, vertices_at).iter().for_each(|&x| bytes.extend((x as f32).to_le_bytes()));
    }
    for face in FACES {
        face.iter().for_each(|&i| bytes.extend((i as u16).to_le_bytes()));
    }
    for x in [0.0f32, 1.0, 0.0, 0.0, 0.0, 0.25, 0.5, -1.0] {
        bytes.extend(x.to_le_bytes());
    }
    let buffer: String = bytes.iter().map(|b| format!("%{b:02x}")).collect();
    let [x, y, z] = at;
    let animation = match moves {
        false => "",
        true => {
            r#""animations": [{"channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}},
            {"sampler": 0, "target": {"node": 2, "path": "translation"}},
            {"sampler": 0, "target": {"node": 3, "path": "translation"}}],
            "samplers": [{"input": 2, "output": 3}]}],"#
        }
    };
    format!(
        r#"{{"asset": {{"version": "2.0"}}, {animation} "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {{"KHR_lights_punctual": {{"lights": [{{"type": "point"}}]}}}},
        "nodes": [{{"translation": [{x}, {y}, {z}], "children": [1, 2, 3], "scale": [2, 2, 2]}},
            {{"mesh": 0, "rotation": [0, 0.6, 0, 0.8], "translation": [0.5, 0, 0]}},
            {{"camera": 0, "translation": [0.25, 1, 6]}},
            {{"translation": [1, 5, 2], "extensions": {{"KHR_lights_punctual": {{"light": 0}}}}}}],
        "scenes": [{{"nodes": [0]}}],
        "cameras": [{{"type": "perspective", "perspective": {{"yfov": 0.7, "znear": 1}}}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4}},
            {{"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 12}},
            {{"bufferView": 2, "componentType": 5126, "type": "SCALAR", "count": 2}},
            {{"bufferView": 3, "componentType": 5126, "type": "VEC3", "count": 2}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 24}},
            {{"buffer": 0, "byteOffset": 72, "byteLength": 8}}, {{"buffer": 0, "byteOffset": 80, "byteLength": 24}}],
        "buffers": [{{"byteLength": {}, "uri": "data:application/octet-stream,{buffer}"}}]}}"#,
        bytes.len()
    )
    .into_bytes()
}

fn load(files: Files) -> Result<LoadedScene, SceneError> {
    let first = files[0].0.clone();
    load_from_memory(files, first, &LoadOptions::default())
}

fn scene(files: Files) -> Scene {
    let loaded = load(files).unwrap_or_else(|e| panic!("{e}"));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.scene
}

fn one(name: &str, bytes: Vec<u8>) -> Scene {
    scene(vec![(name.into(), bytes)])
}

/// All that reaches a pixel, as text; -0 is not 0 there.
fn arrays(scene: &Scene) -> String {
    let (data, _) = SceneData::flatten(scene).unwrap();
    let states = FrameStates::new(scene, &data);
    let frames = scene.animation.as_ref().map_or(1, |animation| animation.frames);
    let states: Vec<_> = (0..frames).map(|frame| states.at(frame).unwrap()).collect();
    format!("{data:?}\n{states:?}").replace("-0.0,", "0.0,").replace("-0.0 ", "0.0 ")
}

fn assert_same(near: &Scene, far: &Scene, name: &str) {
    assert_eq!(near.origin, HERE, "{name}");
    let (near, far) = (arrays(near), arrays(far));
    let at = near.bytes().zip(far.bytes()).position(|(a, b)| a != b).unwrap_or(near.len().min(far.len()));
    let part = |text: &str| text[at.saturating_sub(200)..text.len().min(at + 100)].to_string();
    assert!(near == far, "{name}:\nnear {}\nfar  {}", part(&near), part(&far));
}

#[test]
fn models_are_the_same_far_away() {
    let camera = |scene: &mut Scene, at: [f64; 3]| {
        let position = scene.point_of_file(add(at, [1.0, 0.5, 7.0 + 1.0 / 1024.0]));
        scene.camera = Some(Camera { position, ..Camera::default() });
    };
    for (name, file) in [
        ("a.obj", (|at| obj(&CORNERS, at)) as fn([f64; 3]) -> Vec<u8>),
        ("a.ply", |at| ply("ascii", at)),
        ("b.ply", |at| ply("binary_little_endian", at)),
        ("c.ply", |at| ply("binary_big_endian", at)),
    ] {
        let [mut near, mut far] = [HERE, UTM].map(|at| one(name, file(at)));
        assert_eq!(far.origin, UTM, "{name}");
        // The camera that sees the whole is the same, too.
        assert_same(&near, &far, name);
        camera(&mut near, HERE);
        camera(&mut far, UTM);
        assert_same(&near, &far, name);
        let notes = SceneData::flatten(&far).unwrap().1;
        let note = "the scene lies far from 0: it is rendered about (500000, 5000000, 96); camera, lights and flags \
                    keep the coordinates of the file";
        assert!(notes.iter().any(|n| n.to_string() == note), "{notes:?}");
    }
}

#[test]
fn gltf_nodes_are_the_same_far_away() {
    for moves in [false, true] {
        let [near, far] = [HERE, UTM].map(|at| one("a.gltf", gltf(HERE, at, moves)));
        assert_eq!((far.origin, far.has_moving_instances()), (UTM, moves));
        assert_same(&near, &far, "nodes");
    }
    // Vertices have single precision, and that they keep: half metres here.
    let half = UTM.map(|x| (x as f32).into());
    let far = one("a.gltf", gltf(half, half.map(|x: f64| -2.0 * x), false));
    let largest = |p: Vec3| p.abs().max_component();
    assert!(far.meshes[0].positions.iter().all(|&p| largest(p) < 16.0), "{:?}", far.meshes[0].positions);
}

/// A scene of all that has a place; `more` are further keys.
fn json(at: [f64; 3], more: &str) -> Files {
    let p = |x: f64, y: f64, z: f64| {
        let [x, y, z] = add(at, [x, y, z]);
        format!("[{x}, {y}, {z}]")
    };
    let back = at.map(|x| -x);
    let text = format!(
        r#"{{"eosphor": 2, {more}
        "camera": {{"position": {}, "look-at": {}}},
        "lights": [{{"point": {{"position": {}, "color": [9, 9, 9]}}}},
                   {{"spot": {{"position": {}, "direction": [0, -1, 0], "inner-degrees": 10, "outer-degrees": 40,
                    "color": [5, 5, 5]}}}}, {{"directional": {{"direction": [0, -1, 0], "color": [1, 1, 1]}}}}],
        "meshes": [{{"file": "far.obj"}}, {{"file": "near.obj"}},
            {{"file": "far.ply", "transform": {{"translate": {back:?}}}}},
            {{"file": "far.obj", "name": "turning", "moves": [{{"around": {}, "interpolation": "linear", "keys": [
                {{"seconds": 0, "rotate-degrees": [0, 0, 0], "translate": [0, 0, 0]}},
                {{"seconds": 2, "rotate-degrees": [10, 95, 3], "translate": [1, 2, 0.5]}}]}}]}},
            {{"file": "near.obj", "name": "coming", "moves": [{{"keys": [{{"seconds": 0, "translate": {}}},
                {{"seconds": 2, "translate": {}}}]}}]}}],
        "instances": [{{"mesh": "far"}},
            {{"mesh": "near", "transform": {{"scale": [1, 1.1, 1], "rotate-degrees": [0, 33, 5], "translate": {}}}}},
            {{"mesh": "far.ply", "transform": {{"rotate-degrees": [11, 0, 5], "translate": {}}}}},
            {{"mesh": "turning", "moves": [{{"keys": [{{"seconds": 1, "translate": [0, 0.3, 0]}}]}}]}}],
        "spheres": [{{"center": {}, "radius": 0.25}}],
        "parallelograms": [{{"corner": {}, "edge-u": [10, 0, 0], "edge-v": [0, 0, -10]}}]}}"#,
        p(1.0, 2.0, 7.0 + 1.0 / 1024.0),
        p(1.0, 0.5, 0.0),
        p(3.0, 4.0, 5.0 - 1.0 / 512.0),
        p(-3.0, 4.0, 5.0),
        p(1.0 + 1.0 / 1024.0, 0.0, 0.5),
        p(-2.0, 0.25, 0.0),
        p(-2.0, 4.0 + 1.0 / 1024.0, 0.0),
        p(3.0 + 1.0 / 1024.0, 0.0, -1.0),
        p(0.0, 3.0, -1.0 / 1024.0),
        p(0.5, 1.0 / 1024.0, 2.0),
        p(-5.0, -0.5, 5.0),
    )
    .replace("\"mesh\": \"far.ply\"", "\"mesh\": \"shape\"")
    .replace("\"file\": \"far.ply\",", "\"file\": \"far.ply\", \"name\": \"shape\",");
    vec![
        ("s.json".into(), text.into_bytes()),
        ("far.obj".into(), obj(&CORNERS, at)),
        ("near.obj".into(), obj(&CORNERS, HERE)),
        ("far.ply".into(), ply("ascii", at)),
    ]
}

#[test]
fn scenes_are_the_same_far_away_whatever_moves() {
    let p = |at: [f64; 3], x: f64| format!("[{}, {}, {}]", at[0] + x, at[1] + 1.0, at[2] + 8.0);
    let lights = |at| {
        format!(
            r#""lights": [{{"light": 0, "keys": [{{"seconds": 0, "position": {}}}, {{"seconds": 2, "position": {}}}],
            "moves": [{{"around": {}, "keys": [{{"seconds": 0, "rotate-degrees": [0, 0, 0]}},
                {{"seconds": 2, "rotate-degrees": [0, 50, 0]}}]}}]}}]"#,
            p(at, 2.0),
            p(at, 3.0 + 1.0 / 1024.0),
            p(at, 0.5)
        )
    };
    let cameras: [&dyn Fn([f64; 3]) -> String; 5] = [
        &|_| String::new(),
        &|_| r#""camera": {"orbit": {"turns": 1}},"#.into(),
        &|at| format!(r#""camera": {{"orbit": {{"turns": 1, "around": {}}}}},"#, p(at, 1.0 / 1024.0)),
        &|at| {
            let key = |s, x| {
                format!(r#"{{"seconds": {s}, "position": {}, "look-at": {}}}"#, p(at, x), p(at, -3.0 * x))
            };
            format!(
                r#""camera": {{"keys": {{"keys": [{}, {}]}}}},"#,
                key(0, 0.25 + 1.0 / 1024.0),
                key(2, 4.0)
            )
        },
        &|at| {
            let keys =
                r#"[{"seconds": 0, "scale": 1}, {"seconds": 2, "scale": 2, "rotate-degrees": [0, 70, 0]}]"#;
            format!(r#""camera": {{"moves": [{{"around": {}, "keys": {keys}}}]}},"#, p(at, 2.0))
        },
    ];
    for (number, camera) in cameras.into_iter().enumerate() {
        let more = |at| format!(r#""animation": {{"frames": 7, "fps": 3, {} {}}},"#, camera(at), lights(at));
        let [near, far] = [HERE, UTM].map(|at| scene(json(at, &more(at))));
        assert_eq!(far.origin, UTM);
        assert_same(&near, &far, &format!("camera {number}"));
    }
}

#[test]
fn a_stated_origin_counts_at_any_distance() {
    let at = [5120.0, -64.0, 0.0];
    let state = |at: [f64; 3]| format!("\"origin\": {at:?},");
    // Near by itself, so that 0 would be the origin.
    assert_eq!(scene(json(at, "")).origin, HERE);
    let far = scene(json(at, &state(at)));
    assert_eq!(far.origin, at);
    assert_same(&scene(json(HERE, "")), &far, "stated");
    // It may also say that there is to be none.
    assert_eq!(scene(json(UTM, &state(HERE))).origin, HERE);
    let message = |origin: &str| load(json(HERE, &format!("\"origin\": {origin},"))).unwrap_err().to_string();
    for origin in ["[1e13, 0, 0]", "[0, -1e308, 0]", "[0, 1e999, 0]"] {
        assert!(message(origin).contains("out of range"), "{}", message(origin));
    }
    assert!(message("[1, 2]").contains("\"origin\"") && !message("[1, 2]").contains('\n'));
}

/// Single precision has steps of 1/64 there.
#[test]
fn a_stated_origin_keeps_the_digits_of_large_models() {
    let corners = CORNERS.map(|c| c.map(|x| (x * 1000.0 * 1024.0).round() / 1024.0));
    let made = |at: [f64; 3], origin: &str| {
        let json = format!(r#"{{"eosphor": 2, {origin} "meshes": [{{"file": "m.obj"}}]}}"#);
        scene(vec![("s.json".into(), json.into_bytes()), ("m.obj".into(), obj(&corners, at))])
    };
    let at = [229_376.0, 0.0, 0.0];
    let (near, far) = (made(HERE, ""), made(at, "\"origin\": [229376, 0, 0],"));
    assert_eq!(far.origin, at);
    assert_same(&near, &far, "large");
    assert_eq!(made(at, "").origin, HERE);
}

/// Far away by its vertices, and moved back by whoever uses it.
#[test]
fn a_far_model_that_is_moved_to_0_is_as_if_made_there() {
    let text = |back: [f64; 3], more: &str| {
        let back = format!(r#"{{"file": "m.obj", "transform": {{"translate": {back:?}}}}}"#);
        format!(r#"{{"eosphor": 2, "meshes": [{back}], "instances": [{{"mesh": "m"{more}}}]}}"#)
    };
    for more in ["", r#", "transform": {"rotate-degrees": [0, 30, 0], "scale": 0.3}"#] {
        let made = |at: [f64; 3]| {
            let json = text(at.map(|x| -x), more).into_bytes();
            scene(vec![("s.json".into(), json), ("m.obj".into(), obj(&CORNERS, at))])
        };
        let (near, back) = (made(HERE), made(UTM));
        assert_eq!(back.origin, HERE);
        assert_same(&near, &back, more);
    }
}

#[test]
fn what_comes_later_does_not_move_the_origin() {
    let with = |objects: &str| {
        let text = format!(r#"{{"eosphor": 2, "meshes": [{{"file": "m.obj"}} {objects}]}}"#);
        let [near, far, large] = [HERE, UTM, [1e9, 0.0, 0.0]].map(|at| obj(&CORNERS, at));
        let files = [("s.json", text.into_bytes()), ("n.obj", near), ("m.obj", far), ("x.obj", large)];
        scene(files.map(|(name, bytes)| (PathBuf::from(name), bytes)).into())
    };
    let alone = with("");
    assert_eq!(alone.origin, UTM);
    for more in ["n.obj", "x.obj"] {
        let both = with(&format!(r#", {{"file": "{more}"}}"#));
        assert_eq!(both.origin, UTM, "{more}");
        let [alone, both] = [&alone, &both].map(|scene| SceneData::flatten(scene).unwrap().0);
        assert_eq!(alone.triangles[..4], both.triangles[..4], "{more}");
    }
    // Nor does something far make a scene far that is near.
    let text = r#"{"eosphor": 2, "meshes": [{"file": "n.obj"}, {"file": "x.obj"}]}"#;
    let files = [("s.json", text.into()), ("n.obj", obj(&CORNERS, HERE)), ("x.obj", obj(&CORNERS, UTM))];
    assert_eq!(scene(files.map(|(name, bytes)| (PathBuf::from(name), bytes)).into()).origin, HERE);
}

#[test]
fn only_beyond_65536_sizes_there_is_an_origin() {
    // The largest side of the tetrahedron is 2.25 and a bit.
    for (distance, is_far) in [(1000.0, false), (140_000.0, false), (160_000.0, true), (1e9, true)] {
        let scene = one("a.obj", obj(&CORNERS, [0.0, 0.0, -distance]));
        assert_eq!(scene.origin != HERE, is_far, "{distance}");
    }
}

#[test]
fn small_things_keep_all_that_double_precision_holds() {
    // A coin of 1/64 with steps of 2^-27: single precision has steps of a half there.
    let step = 2f64.powi(-27);
    let coin = CORNERS.map(|c| c.map(|x| (x / 256.0 / step).round() * step));
    let far = one("a.obj", obj(&coin, UTM));
    let p = &far.meshes[far.instances[0].mesh as usize].positions;
    for (k, corner) in coin.iter().enumerate() {
        let expected = [0, 1, 2].map(|axis| (corner[axis] - coin[0][axis]) as f32);
        assert_eq!(p[k] - p[0], Vec3::from(expected));
    }
}

#[test]
fn hostile_numbers_give_one_line() {
    let error = |name: &str, text: String| {
        let message = load(vec![(name.into(), text.into_bytes())]).unwrap_err().to_string();
        assert!(!message.contains('\n'), "{message}");
        message
    };
    let rest = "v 5e5 5e6 0\nv 500001 5e6 0\nf 1 2 3\n";
    for bad in ["1e308", "nan", "inf", "-1e13", "1e400"] {
        let message = error("a.obj", format!("v 5e5 5e6 {bad}\n{rest}"));
        assert!(message.starts_with("a.obj:1: "), "{message}");
        let ply = String::from_utf8(ply("ascii", UTM)).unwrap();
        let message = error("a.ply", ply.replacen("96.125", bad, 1));
        assert!(message.starts_with("a.ply:10: "), "{message}");
    }
    let text = String::from_utf8(gltf(HERE, UTM, false)).unwrap();
    for bad in ["1e308", "1e39", "1e13", "-1e30"] {
        let message = error("a.gltf", text.replacen("[500000,", &format!("[{bad},"), 1));
        assert!(message.starts_with("a.gltf: "), "{message}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    /// Any tetrahedron in steps of 2^-10, at any place of the grid.
    #[test]
    fn any_model_is_the_same_far_away(
        corners in prop::array::uniform4(prop::array::uniform3(-2048i32..2048)),
        cell in prop::array::uniform3(-500_000i32..500_000),
    ) {
        let size = |axis: usize| {
            let all = corners.map(|c| c[axis]);
            all.iter().max().unwrap() - all.iter().min().unwrap()
        };
        // Sizes of 2 to 4, so that cells are 16.
        prop_assume!((2048 < size(0).max(size(1)).max(size(2))) && cell.iter().any(|x| x.abs() > 20_000));
        let at = cell.map(|x| f64::from(x) * 16.0);
        let corners = corners.map(|c| c.map(|x| f64::from(x) / 1024.0));
        let [near, far] = [HERE, at].map(|at| one("a.obj", obj(&corners, at)));
        prop_assert_eq!(far.origin, at);
        prop_assert_eq!(arrays(&near), arrays(&far));
    }
}

#[test]
fn origins_are_moved_and_moved_back() {
    let more = r#""animation": {"frames": 3, "camera": {"orbit": {"turns": 1}}},"#;
    let mut moved = scene(json(HERE, more));
    let before = arrays(&moved);
    // Steps of all its coordinates are exact here.
    moved.set_origin([16.0, -32.0, 64.0]);
    assert_eq!(moved.camera.unwrap().position, vec3(-15.0, 34.0, -57.0 + 1.0 / 1024.0));
    assert_ne!(arrays(&moved), before);
    moved.set_origin(HERE);
    assert_eq!(arrays(&moved), before);
}

/// Laws, turntables without a middle and presets have coordinates of the file.
#[test]
fn what_is_about_the_0_of_the_file_stays_there() {
    let law = r#"{"r": 5, "z": 2, "phi-frequency": 1, "r-amplitude": 1, "r-frequency": 2}"#;
    let motions = [
        format!(
            r#""animation": {{"frames": 5, "camera": {{"laws": {{"position": {law}, "look-at": {law}}}}}}}"#
        ),
        r#""camera": {"position": [1, 2, 3]}, "animation": {"frames": 5, "camera": {"orbit": {"turns": 1}}}"#
            .into(),
        r#""animation": {"frames": 5, "camera": {"orbit": {"turns": 1}}}"#.into(),
        String::new(),
    ];
    for motion in motions {
        let with = |origin: &str| {
            let comma = if motion.is_empty() { "" } else { "," };
            let text = format!(
                r#"{{"eosphor": 2, {origin} "spheres": [{{"center": [0, 1, 0], "radius": 1}}]{comma} {motion}}}"#
            );
            let mut scene = scene(vec![("s.json".into(), text.into_bytes())]);
            Preset::Eos.apply(&mut scene);
            scene
        };
        let (plain, other) = (with(""), with("\"origin\": [8, -32, 16],"));
        assert_eq!(other.origin, [8.0, -32.0, 16.0]);
        for frame in 0..5 {
            let [a, b] = [&plain, &other].map(|scene| scene.camera_at(frame).unwrap());
            let b = Vec3::from(other.point_in_file(b.position).map(|x| x as f32));
            assert!((a.position - b).length() < 1e-5, "{motion}, frame {frame}: {:?} {b:?}", a.position);
        }
        let near = |a: Light, b: Light| match (a, b) {
            (Light::Point { position: a, .. }, Light::Point { position: b, .. }) => {
                other.point_in_file(b) == plain.point_in_file(a)
            }
            _ => false,
        };
        assert!(plain.lights.len() == 2 && (0..2).all(|i| near(plain.lights[i], other.lights[i])));
    }
}
