//! Files that are wrong: one clear line each, and those that are merely odd: warnings.

use super::{CORNERS, F32, File, U8, U32, bytes, glb, read, triangle};
use serde_json::{Value, json};

/// A triangle with indices.
fn indexed(indices: &[u16]) -> File {
    let mut file = File::of_primitive(json!({"attributes": {"POSITION": 0}, "indices": 1, "mode": 4}));
    file.floats(&CORNERS);
    file.indices(indices);
    file
}

fn changed(mut file: File, pointer: &str, value: Value) -> String {
    *file.root.pointer_mut(pointer).unwrap() = value;
    file.error()
}

fn error(bytes: &[u8]) -> String {
    read(&[("a.gltf", bytes)]).unwrap_err().to_string()
}

#[test]
fn indices_out_of_range_name_mesh_and_primitive() {
    assert_eq!(
        indexed(&[0, 1, 3]).error(),
        "a.glb: mesh 0, primitive 0: index 3 is out of range; there are 3 vertices; mend the file"
    );
    assert_eq!(
        indexed(&[0, 1, 65_535]).error(),
        "a.glb: mesh 0, primitive 0: index 65535 is out of range; there are 3 vertices (glTF knows no restart \
         index); mend the file"
    );
    let mut file = File::of_primitive(json!({"attributes": {"POSITION": 0}, "indices": 1}));
    file.root["meshes"][0]["name"] = "box".into();
    file.floats(&CORNERS);
    file.accessor(U32, "SCALAR", 3, &[0, 0, 0, 0, 1, 0, 0, 0, 255, 255, 255, 255]);
    assert!(file.error().starts_with("a.glb: mesh \"box\", primitive 0: index 4294967295 is out of range"));
    file.accessor(F32, "SCALAR", 3, &bytes(&[0.0, 1.0, 2.0]));
    file.root["meshes"][0]["primitives"][0]["indices"] = 2.into();
    assert!(file.error().contains("accessor 2: indices must be unsigned whole numbers"));
}

#[test]
fn accessors_views_and_buffers_are_checked() {
    let whole = || indexed(&[0, 1, 2]);
    let at = |pointer: &str, value: Value| changed(whole(), pointer, value);
    for (pointer, value, expected) in [
        (
            "/accessors/0/count",
            json!(4),
            "4 elements of 12 bytes, 12 apart from byte 0 on, do not fit its bufferView",
        ),
        ("/accessors/0/count", json!(u64::MAX), "far more elements than its buffers have bytes"),
        ("/accessors/0/count", json!(1u64 << 40), "far more elements than its buffers have bytes"),
        ("/accessors/0/bufferView", json!(7), "bufferView 7 does not exist; there are 2"),
        ("/accessors/0/type", json!("VEC2"), "it has 2 components, not 3"),
        ("/accessors/0/type", json!("MAT4"), "it holds matrices, not vectors"),
        ("/accessors/0/type", json!("VEC9"), "its type is unknown"),
        ("/accessors/0/componentType", json!(5124), "its component type is unknown"),
        ("/bufferViews/0/buffer", json!(3), "bufferView 0: buffer 3 does not exist; there are 1"),
        ("/bufferViews/0/byteOffset", json!(20), "bytes 20 to 56 of buffer 0, which has 42"),
        (
            "/bufferViews/0/byteLength",
            json!(u64::MAX),
            "bytes 0 to 18446744073709551615 of buffer 0, which has 42",
        ),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(9), "accessor 9 does not exist; there are 2"),
        ("/meshes/0/primitives/0/mode", json!(7), "its mode is unknown; it must be 0 to 6"),
        ("/nodes/0/mesh", json!(1), "mesh 1 does not exist; there are 1"),
    ] {
        let message = at(pointer, value);
        assert!(message.starts_with("a.glb: ") && message.contains(expected), "{pointer}: {message}");
        assert!(!message.contains('\n'));
    }
    let mut file = whole();
    file.root["bufferViews"][0]["byteStride"] = 8.into();
    assert!(file.error().contains("its elements of 12 bytes are 8 apart"));
    let mut file = whole();
    file.root["accessors"][0]["byteOffset"] = json!(u64::MAX);
    assert!(file.error().contains("do not fit its bufferView of 36 bytes"));
    let mut file = whole();
    let normals = file.floats(&CORNERS[..2]);
    file.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normals.into();
    assert!(file.error().contains("primitive 0: NORMAL has 2 elements for 3 vertices"), "{}", file.error());
    let mut file = whole();
    file.root["meshes"][0]["primitives"][0]["material"] = 0.into();
    assert!(file.error().contains("material 0 does not exist; there are 0"));
}

#[test]
fn small_files_do_not_fill_the_memory() {
    // Zeros without bytes.
    let mut file = File::of_primitive(json!({"attributes": {"POSITION": 0}}));
    file.raw_accessor(json!({"componentType": F32, "type": "VEC3", "count": 4_000_000_000u64}));
    assert!(file.error().contains("far more elements than its buffers have bytes"), "{}", file.error());
    // One array for very many primitives.
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 1});
    let mut file =
        File::new(json!({"nodes": [{"mesh": 0}], "meshes": [{"primitives": vec![primitive; 20_000]}]}));
    file.floats(&CORNERS);
    file.accessor(U8, "SCALAR", 30_000, &[0; 30_000]);
    assert!(file.error().contains("far more elements than its buffers have bytes"), "{}", file.error());
}

#[test]
fn trees_of_nodes_are_trees() {
    let nodes = |nodes: Value| triangle(json!({"scenes": [{"nodes": [0]}], "nodes": nodes}));
    let expected = "a.glb: node 0 is reached twice: nodes must be a tree, without cycles and with one parent each; \
                    mend the file";
    assert_eq!(nodes(json!([{"children": [1]}, {"children": [0]}])).error(), expected);
    assert_eq!(nodes(json!([{"children": [0]}])).error(), expected);
    let twice = json!([{"children": [1, 2]}, {"children": [3]}, {"children": [3]}, {"name": "leg\nx"}]);
    assert!(nodes(twice).error().starts_with("a.glb: node \"leg x\" is reached twice"));
    assert_eq!(nodes(json!([{"children": [5]}])).error(), "a.glb: node 5 does not exist; there are 1");
    // Depth does no harm.
    let mut deep: Vec<Value> = (1..50_000).map(|i| json!({"children": [i]})).collect();
    deep.push(json!({"mesh": 0}));
    assert_eq!(nodes(deep.into()).load().scene.instances.len(), 1);
}

#[test]
fn containers_that_are_cut_or_old() {
    let whole = triangle(json!({})).glb();
    for (end, expected) in [
        (6, "the file ends within its header; get it again"),
        (12, "a GLB without JSON; export it again"),
        (40, "the file ends within its JSON chunk of"),
        (whole.len() - 1, "the file ends within its BIN chunk of 36 bytes; get it again"),
    ] {
        let message = error(&whole[..end]);
        assert!(message.starts_with(&format!("a.gltf: {expected}")), "{message}");
    }
    assert!(error(b"glTF\x01\0\0\0").contains("GLB version 1 is not read"));
    for (json, expected) in [
        ("", "a.gltf: the file ends within its JSON; get it again"),
        ("{\n", "a.gltf: the file ends within its JSON; get it again"),
        ("{\n\"x\": 1}", "a.gltf:2:7: missing field \"asset\"; this is no glTF, export it again"),
        (
            r#"{"asset": {"version": "1.0"}, "nodes": {}}"#,
            "a.gltf: glTF version \"1.0\" is not read, only 2.0;",
        ),
        (r#"{"asset": {"version": "3.0"}}"#, "a.gltf: glTF version \"3.0\" is not read, only 2.0;"),
    ] {
        let message = error(json.as_bytes());
        assert!(message.starts_with(expected), "{message}");
    }
    assert!(error(&glb("{", b"")).starts_with("a.gltf: the file ends within its JSON; get it again"));
    // A byte order mark, zeros for blanks.
    let empty = r#"{"asset": {"version": "2.0"}}"#;
    assert!(read(&[("a.gltf", format!("\u{feff}{empty}").as_bytes())]).is_ok());
    assert!(read(&[("a.gltf", &glb(&format!("{empty}\0\0\0"), b""))]).is_ok());
}

#[test]
fn buffers_that_are_missing_or_elsewhere() {
    let mut root = triangle(json!({})).root;
    let mut message = |buffer: Value, files: &[(&str, &[u8])]| {
        root["buffers"] = json!([buffer]);
        let text = root.to_string();
        let mut all: Vec<(&str, &[u8])> = vec![("d/a.gltf", text.as_bytes())];
        all.extend(files);
        read(&all).map(|loaded| loaded.scene.meshes[0].positions[1].x).map_err(|e| e.to_string())
    };
    let corners = bytes(CORNERS.as_flattened());
    assert_eq!(
        message(json!({"byteLength": 36, "uri": "x%20y.bin"}), &[]).unwrap_err(),
        "d/a.gltf: mesh 0, primitive 0: POSITION: accessor 0: buffer 0: \"x y.bin\" is missing; put it beside the glTF"
    );
    assert_eq!(message(json!({"byteLength": 36, "uri": "x%20y.bin"}), &[("d/x y.bin", &corners)]), Ok(1.0));
    assert_eq!(message(json!({"byteLength": 36, "uri": "s/x%y.bin"}), &[("d/s/x%y.bin", &corners)]), Ok(1.0));
    assert!(
        message(json!({"byteLength": 36, "uri": "https://x/y"}), &[])
            .unwrap_err()
            .contains("not on this machine")
    );
    assert!(
        message(json!({"byteLength": 36, "uri": "x"}), &[("d/x", &corners[1..])])
            .unwrap_err()
            .contains("bufferView 0: bytes 0 to 36 of buffer 0, which has 35")
    );
    assert!(message(json!({"byteLength": 36}), &[]).unwrap_err().contains("it has neither a uri nor bytes"));
    // Written into the file.
    let base64 = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let uri = format!("data:application/octet-stream;base64,{base64}");
    assert_eq!(message(json!({"byteLength": 36, "uri": uri}), &[]), Ok(1.0));
}

#[test]
fn extensions_that_are_required() {
    let required = |name: &str| triangle(json!({"extensionsRequired": [name], "extensionsUsed": [name]}));
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "VENDOR_odd"] {
        let expected = format!("a.glb: {name} is required and not supported; export without it");
        assert_eq!(required(name).error(), expected);
    }
    assert!(required("KHR_mesh_quantization").warnings().is_empty());
    assert_eq!(
        required("KHR_materials_clearcoat").warnings(),
        ["a.glb: KHR_materials_clearcoat is not rendered; surfaces have no coat"]
    );
    assert!(triangle(json!({"extensionsUsed": ["KHR_xmp", "VENDOR_odd"]})).warnings().is_empty());
    // Compressed without saying that it is required.
    let mut file = triangle(json!({}));
    file.root["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let draco = json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}});
    file.root["meshes"][0]["primitives"][0]["extensions"] = draco;
    assert!(file.error().contains("it is there by KHR_draco_mesh_compression alone"), "{}", file.error());
}

#[test]
fn what_is_left_out_is_said() {
    let mut file = triangle(json!({
        "animations": [{"channels": [], "samplers": []}], "skins": [{"joints": [0]}],
        "nodes": [{"mesh": 0, "skin": 0}, {"mesh": 1}, {"name": "flat", "mesh": 0, "scale": [1, 0, 1]}]}));
    file.root["meshes"] = json!([file.root["meshes"][0], {"name": "p", "primitives": [
        {"attributes": {"POSITION": 0}, "mode": 0}, {"attributes": {"POSITION": 0}, "mode": 3},
        {"attributes": {}}]}]);
    assert_eq!(
        file.warnings(),
        [
            "a.glb: mesh 0 does not follow its skin: a primitive has no JOINTS_0",
            "a.glb: mesh \"p\", primitive 2 has no positions; it is left out",
            "a.glb: 2 primitives of points or lines are not rendered: mesh \"p\", primitive 0; mesh \"p\", primitive 1",
            "a.glb: node \"flat\" is squashed flat by a scale of 0 and hidden",
        ]
    );
    let empty = read(&[("a.gltf", br#"{"asset": {"version": "2.0"}}"#)]).unwrap();
    let warnings: Vec<String> = empty.warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(warnings, ["a.gltf: there is nothing to see: the scene of the file has no triangles"]);
}

#[test]
fn json_of_another_shape_says_what_was_expected() {
    for (rest, expected) in [
        (r#""scene": -1"#, "invalid type: integer \"-1\", expected an index: a whole number from 0 on;"),
        (
            r#""scene": 0.5"#,
            "invalid type: floating point \"0.5\", expected an index: a whole number from 0 on;",
        ),
        (r#""scene": 4294967296"#, "invalid value: integer \"4294967296\", expected an index below 2^32;"),
        (
            r#""cameras": [{"type": 1}]"#,
            "invalid type: integer \"1\", expected one of \"perspective\", \"orthographic\";",
        ),
        (
            r#""samplers": [{"wrapS": "REPEAT"}]"#,
            "invalid type: string \"REPEAT\", expected one of 33071, 33648, 10497;",
        ),
        (
            r#""samplers": [{"wrapS": 1.5}]"#,
            "invalid type: floating point \"1.5\", expected one of 33071, 33648, 10497;",
        ),
        (r#""animations": [{"channels": []}]"#, "missing field \"samplers\";"),
        (r#""nodes": [{"scale": [1, 2]}]"#, "invalid length 2, expected an array of length 3;"),
        (r#""nodes": {}"#, "invalid type: map, expected a sequence;"),
    ] {
        let message = error(format!("{{\"asset\": {{\"version\": \"2.0\"}},\n{rest}}}").as_bytes());
        let (place, reason) = message.split_once(": ").unwrap();
        assert!(place.starts_with("a.gltf:2:") && reason.starts_with(expected), "{message}");
        assert!(message.ends_with("; this is no glTF, export it again"), "{message}");
    }
}

#[test]
fn members_that_are_not_read_may_hold_anything() {
    // Deeper than a thread's stack, if each level took a frame.
    let deep = "[".repeat(1_000_000) + &"]".repeat(1_000_000);
    let json = format!(
        r#"{{"asset": {{"version": "2.0", "generator": 5}}, "extras": {deep}, "scene": 0, "scenes": [{{}}],
        "cameras": [{{"type": "perspective", "perspective": {{"yfov": 1, "znear": "near"}}}}],
        "extensions": {{"VENDOR_odd": {deep}}}, "samplers": [{{"minFilter": {{}}, "magFilter": null}}]}}"#
    );
    assert!(read(&[("a.gltf", json.as_bytes())]).is_ok());
}
