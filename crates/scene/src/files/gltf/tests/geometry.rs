//! Accessors, primitives, meshes and where they are placed.

use super::{CORNERS, F32, File, I8, I16, U8, U16, U32, bytes, triangle};
use crate::model::{Mesh, NO_INDEX};
use eosphor_core::math::{Vec3, vec3};
use serde_json::json;

fn mesh(file: &File) -> Mesh {
    file.load().scene.meshes[0].clone()
}

fn corners(mesh: &Mesh) -> Vec<[u32; 3]> {
    mesh.triangles.iter().map(|t| t.positions).collect()
}

const FIVE: [[f32; 3]; 5] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0]];

#[test]
fn strips_alternate_and_fans_turn_about_the_first() {
    for (mode, expected) in [
        (4, vec![[0, 1, 2]]),
        (5, vec![[0, 1, 2], [1, 3, 2], [2, 3, 4]]),
        (6, vec![[1, 2, 0], [2, 3, 0], [3, 4, 0]]),
    ] {
        let mut file = File::of_primitive(json!({"attributes": {"POSITION": 0}, "mode": mode}));
        file.floats(&FIVE);
        assert_eq!(corners(&mesh(&file)), expected, "mode {mode}");
        // The same through indices.
        let mut file = File::of_primitive(json!({"attributes": {"POSITION": 0}, "mode": mode, "indices": 1}));
        file.floats(&FIVE);
        file.indices(&[0, 1, 2, 3, 4]);
        assert_eq!(corners(&mesh(&file)), expected, "mode {mode}");
    }
    // All of a strip face the same way, and there are no normals in the file: flat ones.
    let mut file = File::of_primitive(json!({"attributes": {"POSITION": 0}, "mode": 5}));
    file.floats(&FIVE);
    let mesh = mesh(&file);
    assert_eq!(mesh.normals, [vec3(0.0, 0.0, 1.0); 3]);
    assert_eq!(mesh.triangles[1].normals, [1; 3]);
}

#[test]
fn indices_of_all_widths() {
    for (component, bytes) in
        [(U8, vec![2, 1, 0]), (U16, vec![2, 0, 1, 0, 0, 0]), (U32, vec![2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0])]
    {
        let mut file = File::of_primitive(json!({"attributes": {"POSITION": 0}, "indices": 1}));
        file.floats(&CORNERS);
        file.accessor(component, "SCALAR", 3, &bytes);
        assert_eq!(corners(&mesh(&file)), [[2, 1, 0]]);
    }
}

#[test]
fn sparse_accessors_replace_some_elements() {
    let mut file = File::of_primitive(json!({"attributes": {"POSITION": 0}}));
    let base = file.view(&bytes(CORNERS.as_flattened()), None);
    let places = file.view(&[1, 0, 2, 0], None);
    let values = file.view(&bytes(&[5.0, 6.0, 7.0, 8.0, 9.0, 10.0]), None);
    let sparse = json!({"count": 2, "indices": {"bufferView": places, "componentType": U16},
                        "values": {"bufferView": values}});
    file.raw_accessor(
        json!({"bufferView": base, "componentType": F32, "type": "VEC3", "count": 3, "sparse": sparse}),
    );
    let expected = [Vec3::ZERO, vec3(5.0, 6.0, 7.0), vec3(8.0, 9.0, 10.0)];
    assert_eq!(mesh(&file).positions, expected);
    // Without a base all else is zero.
    file.root["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(mesh(&file).positions, expected);
    file.root["accessors"][0]["sparse"]["indices"]["byteOffset"] = 2.into();
    file.root["accessors"][0]["sparse"]["count"] = 1.into();
    assert_eq!(mesh(&file).positions, [Vec3::ZERO, Vec3::ZERO, vec3(5.0, 6.0, 7.0)]);
    file.root["accessors"][0]["count"] = 2.into();
    assert_eq!(
        file.error(),
        "a.glb: mesh 0, primitive 0: POSITION: accessor 0: its sparse part: place 2 does not exist; there are 2"
    );
}

#[test]
fn strides_interleave_attributes() {
    let mut file = File::of_primitive(json!({"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}}));
    let mut all = Vec::new();
    for (i, corner) in CORNERS.iter().enumerate() {
        all.extend([corner[0], corner[1], corner[2], 0.0, i as f32, 2.0, 0.25, i as f32 / 4.0]);
    }
    let view = file.view(&bytes(&all), Some(32));
    for (offset, kind) in [(0, "VEC3"), (12, "VEC3"), (24, "VEC2")] {
        file.raw_accessor(json!({"bufferView": view, "byteOffset": offset, "componentType": F32,
                                 "type": kind, "count": 3}));
    }
    let mesh = mesh(&file);
    assert_eq!(mesh.positions, CORNERS.map(Vec3::from));
    assert_eq!(mesh.normals, [0.0, 1.0, 2.0].map(|y| vec3(0.0, y, 2.0)));
    // v runs up here, down there.
    assert_eq!(mesh.uvs, [[0.25, 1.0], [0.25, 0.75], [0.25, 0.5]]);
    assert_eq!(mesh.triangles[0].uvs, [0, 1, 2]);
}

#[test]
fn normalised_and_quantised_components() {
    let mut file = File::of_primitive(
        json!({"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "TEXCOORD_1": 3, "COLOR_0": 4}}),
    );
    file.root["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    file.root["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    let i16s = |values: [i16; 9]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    file.accessor(I16, "VEC3", 3, &i16s([0, 0, 0, 300, 0, 0, 0, -300, 7]));
    let normals = file.view(&[0, 0, 127, 9, 0, 0x81, 0, 9, 0x80, 0, 0, 9], Some(4));
    file.raw_accessor(json!({"bufferView": normals, "componentType": I8, "normalized": true, "type": "VEC3",
                             "count": 3}));
    let uvs = file.view(&[0, 255, 51, 102, 255, 0], None);
    file.raw_accessor(json!({"bufferView": uvs, "componentType": U8, "normalized": true, "type": "VEC2",
                             "count": 3}));
    let uvs1 = file.view(&[0, 0, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0, 0, 0], None);
    file.raw_accessor(json!({"bufferView": uvs1, "componentType": U16, "normalized": true, "type": "VEC2",
                             "count": 3}));
    let colors = file.view(&[255, 0, 51, 255, 255, 255, 0, 0, 0], None);
    file.raw_accessor(json!({"bufferView": colors, "componentType": U8, "normalized": true, "type": "VEC3",
                             "count": 3}));
    let mesh = mesh(&file);
    assert_eq!(mesh.positions, [Vec3::ZERO, vec3(300.0, 0.0, 0.0), vec3(0.0, -300.0, 7.0)]);
    assert_eq!(mesh.normals, [vec3(0.0, 0.0, 1.0), vec3(0.0, -1.0, 0.0), vec3(-1.0, 0.0, 0.0)]);
    assert_eq!(mesh.uvs, [[0.0, 0.0], [0.2, 0.6], [1.0, 1.0]]);
    assert_eq!(mesh.uvs1, [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert_eq!(mesh.colors, [[1.0, 0.0, 0.2, 1.0], [1.0; 4], [0.0, 0.0, 0.0, 1.0]]);
}

#[test]
fn primitives_join_and_what_some_lack_is_filled_up() {
    let mut file = File::new(json!({"nodes": [{"mesh": 0}], "materials": [{}, {}], "meshes": [{"name": "m",
        "primitives": [
            {"attributes": {"POSITION": 0}, "material": 1},
            {"attributes": {"POSITION": 0, "COLOR_0": 1, "TEXCOORD_0": 2, "NORMAL": 0}, "material": 0},
            {"attributes": {"POSITION": 0}, "indices": 3}]}]}));
    file.floats(&CORNERS);
    file.floats(&[[0.5, 2.0, -1.0, 0.25]; 3]);
    file.floats(&[[0.0, f32::NAN], [0.0, 1.0], [0.0, 0.0]]);
    file.indices(&[0, 2, 1, 0]);
    let loaded = file.load();
    let mesh = &loaded.scene.meshes[0];
    // The first and the last primitive share their vertices.
    assert_eq!((mesh.name.as_str(), mesh.positions.len()), ("m", 6));
    assert_eq!(corners(mesh), [[0, 1, 2], [3, 4, 5], [0, 2, 1]]);
    assert_eq!(mesh.triangles.iter().map(|t| t.material).collect::<Vec<_>>(), [1, 0, 2]);
    assert_eq!(mesh.colors[..3], [[1.0; 4]; 3]);
    assert_eq!(mesh.colors[3..], [[0.5, 1.0, 0.0, 0.25]; 3]);
    assert_eq!(mesh.uvs, [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 1.0]]);
    assert_eq!(mesh.triangles[0].uvs, [NO_INDEX; 3]);
    assert_eq!(mesh.triangles[1].uvs, [3, 4, 5]);
    let normal = |t: usize| mesh.normals[mesh.triangles[t].normals[1] as usize];
    assert_eq!(
        [normal(0), normal(1), normal(2)],
        [[0.0, 0.0, 1.0], CORNERS[1], [0.0, 0.0, -1.0]].map(Vec3::from)
    );
    let warnings: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(
        warnings,
        [
            "a.glb: normals or texture coordinates that are not finite are taken for 0",
            "a.glb: a list of triangles does not end with a whole one; the rest is left out",
        ]
    );
}

#[test]
fn meshes_that_differ_by_their_material_are_one() {
    let primitive =
        |material: u32| json!({"attributes": {"POSITION": 0}, "indices": 1, "material": material});
    let mut file = File::new(json!({
        "materials": [{"name": "a"}, {"name": "b"}, {"name": "c"}],
        "nodes": [{"mesh": 0}, {"mesh": 1}, {"mesh": 2}, {"mesh": 3}, {"mesh": 0}, {"mesh": 4}, {"mesh": 5}],
        "meshes": [
            {"primitives": [primitive(0)]}, {"primitives": [primitive(1)]}, {"primitives": [primitive(0)]},
            // Another order of indices, and two primitives in two materials.
            {"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]},
            {"primitives": [primitive(0), primitive(1)]}, {"primitives": [primitive(2), primitive(2)]}],
    }));
    file.floats(&CORNERS);
    file.indices(&[0, 2, 1]);
    let scene = file.load().scene;
    let shown: Vec<_> = scene.instances.iter().map(|i| (i.mesh, i.material)).collect();
    assert_eq!(shown, [(0, None), (0, Some(1)), (0, None), (1, None), (0, None), (2, None), (2, Some(2))]);
    assert_eq!(scene.meshes.len(), 3);
}

#[test]
fn a_few_vertices_of_a_large_array_are_taken_alone() {
    let primitive = |indices: u32| json!({"attributes": {"POSITION": 0}, "indices": indices});
    let mut file = File::new(json!({"nodes": [{"mesh": 0}, {"mesh": 1}],
        "meshes": [{"primitives": [primitive(1)]}, {"primitives": [primitive(2)]}]}));
    let many: Vec<[f32; 3]> = (0..100).map(|i| [i as f32, (i * i) as f32, 0.0]).collect();
    file.floats(&many);
    file.indices(&[90, 10, 50, 90, 50, 11]);
    file.indices(&[97, 98, 99]);
    let scene = file.load().scene;
    let xs = |m: usize| scene.meshes[m].positions.iter().map(|p| p.x).collect::<Vec<_>>();
    assert_eq!((xs(0), xs(1)), (vec![10.0, 11.0, 50.0, 90.0], vec![97.0, 98.0, 99.0]));
    assert_eq!(corners(&scene.meshes[0]), [[3, 0, 2], [3, 2, 1]]);
}

#[test]
fn morph_targets_are_applied_by_their_weights() {
    let mut file = File::new(json!({"nodes": [{"mesh": 0}, {"mesh": 0, "weights": [0.0, 2.0]}],
        "meshes": [{"weights": [0.5, 0.0], "primitives": [
            {"attributes": {"POSITION": 0, "NORMAL": 1}, "targets": [{"POSITION": 2}, {"POSITION": 2, "NORMAL": 2}]}]}]}));
    file.floats(&CORNERS);
    file.floats(&[[0.0, 0.0, 1.0]; 3]);
    file.floats(&[[0.0, 0.0, 4.0], [0.0; 3], [0.0; 3]]);
    let scene = file.load().scene;
    let first = |m: usize| (scene.meshes[m].positions[0].z, scene.meshes[m].normals[0].z);
    assert_eq!((first(0), first(1)), ((2.0, 1.0), (8.0, 9.0)));
    assert_eq!(scene.instances.iter().map(|i| i.mesh).collect::<Vec<_>>(), [0, 1]);
}

#[test]
fn nodes_multiply_down_the_tree() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let file = triangle(json!({"scene": 1, "scenes": [{"nodes": [3]}, {"nodes": [0]}], "nodes": [
        {"children": [1, 2], "translation": [10, 0, 0], "scale": [2, 2, 2]},
        {"mesh": 0, "rotation": [0, 0, half, half], "translation": [1, 0, 0]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]},
        {"mesh": 0}, {"mesh": 0}]}));
    let scene = file.load().scene;
    let at = |i: usize, p: Vec3| scene.instances[i].world_from_object.affine().point(p);
    assert_eq!(scene.instances.len(), 2);
    assert!((at(0, vec3(1.0, 0.0, 0.0)) - vec3(12.0, 2.0, 0.0)).length() < 1e-6);
    assert_eq!(at(1, vec3(1.0, 0.0, 0.0)), vec3(12.0, 0.0, 10.0));
    // Without scenes every node without a parent is shown.
    let mut file = file;
    for key in ["scene", "scenes"] {
        file.root.as_object_mut().unwrap().remove(key);
    }
    assert_eq!(file.load().scene.instances.len(), 4);
}

#[test]
fn one_node_places_many() {
    let mut file = triangle(json!({"extensionsRequired": ["EXT_mesh_gpu_instancing"]}));
    let places = file.floats(&[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let scales = file.floats(&[[1.0; 3], [3.0; 3]]);
    file.root["nodes"][0] = json!({"mesh": 0, "translation": [0, 7, 0], "extensions": {
        "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places, "SCALE": scales}}}});
    let scene = file.load().scene;
    let at = |i: usize| scene.instances[i].world_from_object.affine().point(vec3(1.0, 0.0, 0.0));
    assert_eq!([at(0), at(1)], [vec3(2.0, 7.0, 0.0), vec3(5.0, 7.0, 0.0)]);
}
