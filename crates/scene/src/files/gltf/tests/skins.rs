//! Skins and morph targets, against positions computed by hand.

use super::animations::{near, turn};
use super::{CORNERS, F32, File, U8, U16, bytes, read, triangle};
use crate::model::{Camera, Deformation, Move, Poses, Scene, Transform};
use crate::{FrameStates, SceneData, ShapedArrays};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::Integrator;
use serde_json::{Value, json};
use std::sync::Arc;

/// Corners of all triangles of a frame in the world, each triangle from the corner with the smallest coordinates on.
fn world(scene: &Scene, frame: u32) -> Vec<Vec3> {
    let (data, _) = SceneData::flatten(scene).unwrap_or_else(|e| panic!("{e}"));
    let state = FrameStates::new(scene, &data).at(frame).unwrap_or_else(|e| panic!("{e}"));
    let (shapes, places) = (state.shapes.unwrap(), state.places.unwrap());
    let mut all = Vec::new();
    for instance in &places.instances[1..] {
        let geometry = &shapes.geometries[instance.geometry as usize - data.first_deforming()];
        let first = geometry.first_triangle as usize - (data.triangles.len() - shapes.triangles.len());
        for corners in &shapes.triangles[first..first + geometry.triangle_count as usize] {
            let mut corners = corners.map(|p| instance.world_from_object.point(p));
            let key = |p: &Vec3| [p.x, p.y, p.z].map(|x| (x * 1e4).round() as i64);
            let least = (0..3).min_by_key(|&k| key(&corners[k])).unwrap();
            corners.rotate_left(least);
            all.extend(corners);
        }
    }
    all
}

fn assert_world(scene: &Scene, frame: u32, expected: &[[f32; 3]]) {
    let found = world(scene, frame);
    assert_eq!(found.len(), expected.len());
    found.iter().zip(expected).for_each(|(&p, &e)| near(p, Vec3::from(e)));
}

/// A triangle whose first corner follows joint 0, the second joint 1, the third both alike. Joint 1 is 2 above joint 0, which is at
/// the origin. The mesh is in a node that is moved and large, as are all: that counts for joints alone.
fn bar() -> File {
    let mut file = File::new(json!({
        "nodes": [
            {"mesh": 0, "skin": 0, "translation": [50, 60, 70], "scale": [9, 9, 9]},
            {"children": [2]},
            {"translation": [0, 2, 0]},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}}]}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": 3}],
        "animations": [{"channels": [], "samplers": []}],
    }));
    file.floats(&[[0.0, 0.0, 0.0], [1.0, 3.0, 0.0], [0.0, 2.0, 4.0]]);
    file.accessor(U8, "VEC4", 3, &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = file.accessor(U8, "VEC4", 3, &[255, 0, 0, 0, 255, 0, 0, 0, 100, 100, 0, 0]);
    file.root["accessors"][weights]["normalized"] = true.into();
    let column = |x: f32, y: f32, z: f32, w: f32| [x, y, z, w];
    let matrix = |y: f32| {
        [
            column(1.0, 0.0, 0.0, 0.0),
            column(0.0, 1.0, 0.0, 0.0),
            column(0.0, 0.0, 1.0, 0.0),
            column(0.0, y, 0.0, 1.0),
        ]
    };
    let both = [matrix(0.0), matrix(-2.0)];
    file.accessor(F32, "MAT4", 2, &bytes(both.as_flattened().as_flattened()));
    file
}

/// [`bar`], whose joint 1 turns by a quarter about z within a second; and joint 0 moves by 8 along x in the next.
fn moving_bar() -> File {
    let mut file = bar();
    file.animate((2, "rotation"), "LINEAR", &[0.0, 1.0], &[turn(0.0), turn(90.0)]);
    file.animate((1, "translation"), "LINEAR", &[1.0, 2.0], &[[0.0; 3], [8.0, 0.0, 0.0]]);
    file
}

#[test]
fn vertices_follow_their_joints_alone() {
    let loaded = moving_bar().load();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = loaded.scene;
    assert_eq!(scene.animation.as_ref().unwrap().frames, 48);
    assert!(scene.has_moving_vertices() && !scene.has_moving_instances() && scene.moves_by_seconds());
    assert_world(&scene, 0, &[[0.0, 0.0, 0.0], [1.0, 3.0, 0.0], [0.0, 2.0, 4.0]]);
    // What is (1, 1) from the joint is (-1, 1) from it.
    assert_world(&scene, 24, &[[-1.0, 3.0, 0.0], [0.0, 2.0, 4.0], [0.0, 0.0, 0.0]]);
    assert_world(&scene, 36, &[[3.0, 3.0, 0.0], [4.0, 2.0, 4.0], [4.0, 0.0, 0.0]]);
    assert_world(&scene, 99, &[[7.0, 3.0, 0.0], [8.0, 2.0, 4.0], [8.0, 0.0, 0.0]]);
    // The mesh itself is as in the first frame.
    assert_eq!(scene.meshes[0].positions, [vec3(0.0, 0.0, 0.0), vec3(1.0, 3.0, 0.0), vec3(0.0, 2.0, 4.0)]);
}

#[test]
fn joints_that_stay_make_a_mesh_that_stays() {
    let mut file = bar();
    file.root["nodes"][2]["rotation"] = json!(turn(90.0));
    let scene = file.load().scene;
    assert!(scene.animation.is_none() && !scene.has_moving_vertices());
    assert!(scene.meshes[0].deformation.is_none());
    near(scene.meshes[0].positions[1], vec3(-1.0, 3.0, 0.0));
    // The flat normal is that of the triangle where it stands.
    let n = scene.meshes[0].normals[0].normalize();
    near(n, vec3(12.0, 4.0, -2.0).normalize());
    // Matrices are the identity where there are none.
    let mut file = bar();
    file.root["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    near(file.load().scene.meshes[0].positions[1], vec3(1.0, 5.0, 0.0));
}

#[test]
fn shares_have_the_sum_one_and_there_may_be_more_sets() {
    // A vertex without weights follows the first joint; a second set counts as much.
    let mut file = moving_bar();
    let joints = [1u16, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0];
    let joints: Vec<u8> = joints.iter().flat_map(|x| x.to_le_bytes()).collect();
    let joints = file.accessor(U16, "VEC4", 3, &joints);
    let zero = file.floats(&[[0.0f32; 4]; 3]);
    let second = file.floats(&[[0.0; 4], [0.0; 4], [3.0, 0.0, 0.0, -1e-9]]);
    let attributes = &mut file.root["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (joints.into(), zero.into());
    // The first follows joint 1, and is 2 below it: 2 to its right after a second.
    assert_world(&file.load().scene, 24, &[[0.0, 2.0, 4.0], [2.0, 2.0, 0.0], [1.0, 3.0, 0.0]]);
    let attributes = &mut file.root["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_1"], attributes["WEIGHTS_1"]) = (joints.into(), second.into());
    let half = file.floats(&[[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]);
    file.root["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = half.into();
    // The third: a fourth of joint 0, which leaves (0, 2, 4), and three of joint 1, which does, too.
    assert_world(&file.load().scene, 24, &[[0.0, 2.0, 4.0], [2.0, 2.0, 0.0], [1.0, 3.0, 0.0]]);
}

/// A triangle whose third corner goes up by 4 in one target, and whose first goes aside by 2 in the other.
fn morphing(kind: &str, times: &[f32], weights: &[f32]) -> File {
    let mut file = triangle(json!({"animations": [{"channels": [], "samplers": []}]}));
    let up = file.floats(&[[0.0; 3], [0.0; 3], [0.0, 0.0, 4.0]]);
    // The other one is sparse.
    let places = file.view(&[0], None);
    let values = file.view(&bytes(&[-2.0, 0.0, 0.0]), None);
    let sparse = json!({"count": 1, "indices": {"bufferView": places, "componentType": U8}, "values": {"bufferView": values}});
    let aside =
        file.raw_accessor(json!({"componentType": F32, "type": "VEC3", "count": 3, "sparse": sparse}));
    file.root["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": up}, {"POSITION": aside}]);
    let weights: Vec<[f32; 1]> = weights.iter().map(|&w| [w]).collect();
    file.animate((0, "weights"), kind, times, &weights);
    file
}

#[test]
fn weights_of_morph_targets_are_animated() {
    let mut file = morphing("LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.5, 1.0]);
    let loaded = file.load();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_world(&loaded.scene, 0, &CORNERS);
    assert_world(&loaded.scene, 12, &[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]]);
    assert_world(&loaded.scene, 24, &[[-2.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 2.0]]);
    // Flat normals follow: half way, of the edges (2, 0, 0) and (1, 1, 1).
    let (data, _) = SceneData::flatten(&loaded.scene).unwrap();
    let state = FrameStates::new(&loaded.scene, &data).at(12).unwrap();
    near(state.shapes.unwrap().triangle_shading[0].normals[0], vec3(0.0, -1.0, 1.0).normalize());
    // The node goes its own way at the same time, and places it twice as large.
    file.root["nodes"][0]["scale"] = json!([2, 2, 2]);
    file.animate((0, "translation"), "LINEAR", &[0.0, 2.0], &[[0.0; 3], [0.0, 0.0, 8.0]]);
    let scene = file.load().scene;
    assert!(scene.has_moving_instances());
    assert_eq!(scene.animation.as_ref().unwrap().frames, 48);
    assert_world(&scene, 24, &[[-4.0, 0.0, 4.0], [2.0, 0.0, 4.0], [0.0, 2.0, 8.0]]);

    let scene = morphing("STEP", &[0.0, 1.0], &[0.0, 0.0, 0.5, 1.0]).load().scene;
    assert_world(&scene, 23, &CORNERS);
    // The parabola t^2 between its tangents, and nothing: keys are in-tangents, weights, out-tangents.
    let cubic = [9.0, 9.0, 1.0, 0.0, 2.0, 0.0, 6.0, 0.0, 9.0, 0.0, 9.0, 9.0];
    let scene = morphing("CUBICSPLINE", &[1.0, 3.0], &cubic).load().scene;
    assert_world(&scene, 48, &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 16.0]]);
    assert_world(&scene, 36, &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 9.0]]);
}

#[test]
fn targets_are_added_before_the_skin() {
    let mut file = moving_bar();
    let aside = file.floats(&[[0.0; 3], [0.0, 2.0, 0.0], [0.0; 3]]);
    file.root["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": aside}]);
    // (1, 3) and half of (0, 2) is (1, 2) from the joint, which becomes (-2, 1).
    let turned = [[-2.0, 3.0, 0.0], [0.0, 2.0, 4.0], [0.0, 0.0, 0.0]];
    file.root["meshes"][0]["weights"] = json!([0.5]);
    assert_world(&file.load().scene, 24, &turned);
    file.animate((0, "weights"), "LINEAR", &[0.0, 2.0], &[[0.0], [1.0]]);
    assert_world(&file.load().scene, 24, &turned);
}

#[test]
fn meshes_are_shared_where_all_that_moves_them_is_the_same() {
    let mut file = moving_bar();
    let nodes = file.root["nodes"].as_array_mut().unwrap();
    nodes.push(json!({"mesh": 0, "skin": 0}));
    nodes.push(json!({"mesh": 0, "skin": 1}));
    nodes.push(json!({"mesh": 0}));
    file.root["skins"].as_array_mut().unwrap().push(json!({"joints": [2, 1]}));
    let scene = file.load().scene;
    assert_eq!(scene.instances.iter().map(|i| i.mesh).collect::<Vec<_>>(), [0, 0, 1, 2]);
    let moves: Vec<bool> = scene.meshes.iter().map(|mesh| mesh.deformation.is_some()).collect();
    assert_eq!(moves, [true, true, false]);
    // The last one stays, and comes first among the geometries.
    let (data, _) = SceneData::flatten(&scene).unwrap();
    assert_eq!((data.geometries.len(), data.deforming_geometries, data.first_deforming()), (3, 2, 1));
    assert_eq!(data.geometries.iter().map(|g| g.triangle_count).collect::<Vec<_>>(), [1, 1, 1]);
    let prints: Vec<u64> = scene.placed_deformations().map(|d| d.fingerprint()).collect();
    assert!(prints[0] == prints[1] && prints[1] != prints[2]);
}

/// The state of a frame is what flattening a scene makes whose vertices are there.
#[test]
fn shapes_are_what_flattening_makes() {
    let mut file = moving_bar();
    file.root["materials"] = json!([{"emissiveFactor": [1, 0.5, 0.25]}]);
    let shining = json!({"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}, "material": 0});
    let still = json!({"primitives": [{"attributes": {"POSITION": 0}}]});
    let skinned =
        json!({"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}}, shining]});
    // One shines and stays, one moves, one shines and moves.
    file.root["meshes"] =
        json!([skinned, {"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}, still]);
    let nodes = file.root["nodes"].as_array_mut().unwrap();
    nodes.extend([json!({"mesh": 1, "translation": [0, 0, 9]}), json!({"mesh": 2})]);
    file.animate((4, "translation"), "LINEAR", &[0.0, 2.0], &[[0.0; 3], [0.0, 5.0, 0.0]]);
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let mut scene = file.load().scene;
        scene.settings.integrator = integrator;
        scene.settings.max_distance = None;
        scene.camera = Some(Camera::default());
        let (data, _) = SceneData::flatten(&scene).unwrap();
        assert_eq!((data.geometries.len(), data.lights.len()), (3, 2));
        let states = FrameStates::new(&scene, &data);
        for frame in [0, 5, 24, 31, 47] {
            let state = states.at(frame).unwrap();
            let mut frozen = scene.clone();
            let seconds = f64::from(frame) / 24.0;
            for mesh in &mut frozen.meshes {
                let Some(posed) = mesh.posed(&mut Poses::at(seconds)) else { continue };
                let old = mesh.deformation.as_deref().unwrap().clone();
                let (positions, normals) = (posed.positions, posed.normals);
                let deformation = Deformation { positions, normals, skin: None, ..old };
                mesh.deformation = Some(Arc::new(deformation));
            }
            for instance in frozen.instances.iter_mut().filter(|instance| !instance.moves.is_empty()) {
                let moved = Move::map_of_all(instance.moves.iter().map(|motion| &**motion), seconds);
                let transform = Transform::from_affine(&moved.affine());
                instance.moves = vec![Arc::new(Move { transform, ..Move::default() })];
            }
            let (expected, _) = SceneData::flatten(&frozen).unwrap();
            assert_eq!(state.lights, expected.lights, "{frame}");
            assert_eq!(state.light_nodes, expected.light_nodes);
            assert_eq!(state.settings, expected.settings);
            assert_eq!(state.places.as_ref().unwrap().instances, expected.instances);
            let shapes = state.shapes.as_ref().unwrap();
            assert_eq!(shapes.geometries, expected.geometries[2..]);
            let mut arrays = ShapedArrays::new(&data);
            assert_eq!(arrays.has(shapes), frame == 0);
            arrays.take(shapes, &data).unwrap();
            assert!(arrays.has(shapes));
            let view = arrays.view(&data);
            assert_eq!(view.triangles, expected.triangles);
            assert_eq!(view.triangle_shading, expected.triangle_shading);
            assert_eq!(view.geometries, expected.geometries);
            // What is of another scene is refused.
            let mut other = shapes.clone();
            other.triangles.pop();
            assert!(arrays.take(&other, &data).is_err() && arrays.has(shapes));
        }
        let at = |frame| states.at(frame).unwrap();
        assert!(at(5).lights != at(24).lights && at(5).shapes != at(24).shapes);
    }
}

#[test]
fn json_scenes_place_what_its_joints_move() {
    let scene = json!({"eosphor": 1, "meshes": [{"file": "m.glb", "transform": {"scale": 2}, "moves":
        [{"keys": [{"seconds": 0, "translate": [0, 0, 0]}, {"seconds": 2, "translate": [0, 0, 2]}], "interpolation": "linear"}]}]});
    let loaded = read(&[("s.json", scene.to_string().as_bytes()), ("m.glb", &moving_bar().glb())]);
    let scene = loaded.unwrap_or_else(|e| panic!("{e}")).scene;
    assert_eq!(scene.animation.as_ref().unwrap().frames, 48);
    assert_world(&scene, 24, &[[-2.0, 6.0, 1.0], [0.0, 4.0, 9.0], [0.0, 0.0, 1.0]]);
}

/// Millions from 0, and where single precision has no digits left.
#[test]
fn far_joints_keep_their_digits() {
    let mut file = moving_bar();
    file.root["nodes"]
        .as_array_mut()
        .unwrap()
        .push(json!({"children": [1], "translation": [4_000_000.125, 7e6, 0]}));
    let scene = file.load().scene;
    assert!(scene.origin[0] != 0.0);
    let place = |p: [f32; 3]| {
        scene.point_of_file([4_000_000.125 + f64::from(p[0]), 7e6 + f64::from(p[1]), f64::from(p[2])])
    };
    let expected = [[-1.0, 3.0, 0.0], [0.0, 2.0, 4.0], [0.0, 0.0, 0.0]].map(place);
    assert_world(&scene, 24, &expected.map(<[f32; 3]>::from));
}

/// A file with one thing changed.
fn changed(change: impl Fn(&mut File)) -> String {
    let mut file = moving_bar();
    change(&mut file);
    file.error()
}

fn attribute(file: &mut File, name: &str, accessor: usize) {
    file.root["meshes"][0]["primitives"][0]["attributes"][name] = accessor.into();
}

#[test]
fn skins_that_are_wrong_say_what_is() {
    let skin =
        |key: &'static str, value: Value| changed(move |file| file.root["skins"][0][key] = value.clone());
    let mut all = vec![
        (skin("joints", json!([1])), "a vertex follows joint 1, and its skin has 1"),
        (skin("joints", json!([])), "skin 0: it has no joints"),
        (skin("joints", json!([1, 2, 1])), "skin 0: there are 2 inverseBindMatrices for 3 joints"),
        (skin("joints", json!([1, 77])), "skin 0: its joint, node 77, is not in the scene that is shown"),
        (
            skin("inverseBindMatrices", json!(0)),
            "inverseBindMatrices: accessor 0: it must hold matrices of 4 x 4 floats",
        ),
        (changed(|file| file.root["nodes"][0]["skin"] = 3.into()), "skin 3 does not exist; there are 1"),
        (
            changed(|file| {
                file.root["nodes"][2]["children"] = json!([1]);
                file.root["scenes"] = json!([{"nodes": [0, 1]}]);
            }),
            "node 1 is reached twice",
        ),
    ];
    all.push((
        changed(|file| {
            let nan = file.accessor(F32, "MAT4", 2, &bytes(&[f32::NAN; 32]));
            file.root["skins"][0]["inverseBindMatrices"] = nan.into();
        }),
        "skin 0: matrix 0 of its inverseBindMatrices is not finite",
    ));
    for (name, values, expected) in [
        ("JOINTS_0", [0.5; 4], "vertex 0: 0.5 is no number of a joint"),
        ("JOINTS_0", [f32::NAN; 4], "is no number of a joint"),
        ("JOINTS_0", [9.0; 4], "a vertex follows joint 9, and its skin has 2"),
        ("WEIGHTS_0", [f32::INFINITY; 4], "vertex 0: a weight of a joint is not finite"),
    ] {
        let wrong = changed(|file| {
            let accessor = file.floats(&[values; 3]);
            attribute(file, name, accessor);
        });
        all.push((wrong, expected));
    }
    let fewer = changed(|file| {
        let accessor = file.floats(&[[1.0; 4]; 2]);
        attribute(file, "WEIGHTS_0", accessor);
    });
    all.push((fewer, "WEIGHTS_0 has 2 elements for 3 vertices"));
    all.push((changed(|file| attribute(file, "JOINTS_1", 1)), "there is JOINTS_1 and no WEIGHTS_1"));
    all.push((changed(|file| attribute(file, "WEIGHTS_5", 2)), "there is WEIGHTS_5 and no JOINTS_5"));
    let gap = changed(|file| {
        attribute(file, "JOINTS_2", 1);
        attribute(file, "WEIGHTS_2", 2);
    });
    all.push((gap, "there is no JOINTS_1, though there are later ones"));
    for (error, expected) in all {
        assert!(error.contains(expected) && error.starts_with("a.glb: ") && !error.contains('\n'), "{error}");
    }
}

#[test]
fn morph_targets_that_are_wrong_say_what_is() {
    let wrong = |times: &[f32], weights: &[f32]| morphing("LINEAR", times, weights).error();
    let few = wrong(&[0.0, 1.0], &[0.0, 0.0, 1.0]);
    let expected =
        "animation 0, sampler 0: there are 3 weights for 2 times and 2 morph targets, not 2 for each time";
    assert!(few.contains(expected), "{few}");
    let nan = wrong(&[0.0, 1.0], &[0.0, 0.0, 1.0, f32::NAN]);
    assert!(nan.contains("the weights of key 1 are not finite"), "{nan}");
    let back = wrong(&[1.0, 0.0], &[0.0; 4]);
    assert!(back.contains("its times must increase"), "{back}");
    let mut file = morphing("LINEAR", &[0.0], &[0.0, 0.0]);
    let offsets = file.floats(&[[f32::INFINITY; 3]; 3]);
    file.root["meshes"][0]["primitives"][0]["targets"][1]["POSITION"] = offsets.into();
    assert!(file.error().contains("a morph target has numbers that are not finite"), "{}", file.error());
    let offsets = file.floats(&[[0.0; 3]; 2]);
    file.root["meshes"][0]["primitives"][0]["targets"][1]["POSITION"] = offsets.into();
    assert!(
        file.error().contains("a morph target's POSITION has 2 elements for 3 vertices"),
        "{}",
        file.error()
    );
    // In a frame: one line that names it.
    let scene = morphing("LINEAR", &[0.0, 1.0], &[0.0, 0.0, 1e38, 0.0]).load().scene;
    let (data, _) = SceneData::flatten(&scene).unwrap();
    let error = FrameStates::new(&scene, &data).at(12).unwrap_err().to_string();
    assert!(error.contains("mesh 0") && error.contains("out of range") && !error.contains('\n'), "{error}");
}
