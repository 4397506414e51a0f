//! No bytes make the reader panic; what loads also passes flattening or fails with an error.

use super::{CORNERS, F32, File, U16, bytes, read};
use crate::{FrameStates, SceneData};
use proptest::prelude::*;
use proptest::sample::Index;
use serde_json::json;
use std::sync::LazyLock;

/// A file that uses nearly everything.
static WHOLE: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let info = json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2], "rotation": 1}}});
    let mut file = File::new(json!({
        "scene": 0, "scenes": [{"nodes": [0, 2, 3]}], "cameras": [
            {"type": "perspective", "perspective": {"yfov": 0.6, "znear": 1}},
            {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 2, "znear": 1}}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}},
                {"sampler": 1, "target": {"node": 0, "path": "scale"}},
                {"sampler": 2, "target": {"node": 2, "path": "rotation"}},
                {"sampler": 3, "target": {"node": 1, "path": "weights"}}],
            "samplers": [{"input": 4, "output": 0}, {"input": 4, "interpolation": "STEP", "output": 0},
                {"input": 5, "interpolation": "CUBICSPLINE", "output": 6}, {"input": 5, "output": 7}]}],
        "skins": [{"joints": [0, 1], "inverseBindMatrices": 10}],
        "nodes": [{"children": [1], "scale": [1, 2, 3]}, {"mesh": 0, "rotation": [0, 0, 1, 0], "weights": [0.5]},
            {"mesh": 1, "camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0},
                "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}}, {"mesh": 2, "skin": 0}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"innerConeAngle": 0.1}}]}},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0, "TEXCOORD_0": 2, "COLOR_0": 0},
                "indices": 1, "material": 0, "mode": 5, "targets": [{"POSITION": 0}]}]},
            {"primitives": [{"attributes": {"POSITION": 3}, "mode": 6}, {"attributes": {"POSITION": 0}, "mode": 1}]},
            {"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 8, "WEIGHTS_0": 9}}]}],
        "images": [{"bufferView": 3}, {"uri": "data:,P3%0A1%201%0A9%0A1%201%201%0A"}], "samplers": [{"wrapS": 33071}],
        "textures": [{"source": 0, "sampler": 0}, {"source": 1}],
        "materials": [{"alphaMode": "MASK", "emissiveTexture": info, "normalTexture": {"index": 1},
            "pbrMetallicRoughness": {"baseColorTexture": info, "metallicFactor": 0.5},
            "extensions": {"KHR_materials_volume": {"thicknessFactor": 1}, "KHR_materials_ior": {"ior": 1.3}}}],
    }));
    file.floats(&CORNERS);
    file.indices(&[0, 1, 2, 1]);
    file.floats(&[[0.0, 1.0]; 3]);
    file.view(b"P3\n1 1\n255\n255 0 0\n", None);
    let sparse = json!({"count": 1, "indices": {"bufferView": 1, "componentType": U16},
                        "values": {"bufferView": 0}});
    let view = file.view(&bytes(&[0.5; 13]), Some(16));
    file.raw_accessor(
        json!({"bufferView": view, "componentType": F32, "type": "VEC3", "count": 3, "sparse": sparse}),
    );
    file.floats(&[[0.0], [1.0], [2.5]]);
    file.floats(&[[1.0], [2.0]]);
    file.floats(&[[0.0, 1.0, 0.0, 1.0]; 6]);
    file.floats(&[[0.25], [1.0]]);
    file.floats(&[[0.0, 1.0, 0.0, 0.0]; 3]);
    file.floats(&[[0.5, 0.25, 0.0, 0.0]; 3]);
    let identity =
        [[1.0f32, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    file.accessor(F32, "MAT4", 2, &bytes([identity; 2].as_flattened().as_flattened()));
    file.glb()
});

/// The JSON of [`WHOLE`].
fn json() -> &'static str {
    let length = u32::from_le_bytes(WHOLE[12..16].try_into().unwrap()) as usize;
    std::str::from_utf8(&WHOLE[20..20 + length]).unwrap()
}

/// Which numbers of the JSON become which of some others.
pub(super) fn edits(others: &[&'static str]) -> impl Strategy<Value = Vec<(Index, &'static str)>> + use<> {
    proptest::collection::vec((any::<Index>(), proptest::sample::select(others.to_vec())), 1..4)
}

/// JSON with these edits.
pub(super) fn renumbered(json: &str, edits: Vec<(Index, &str)>) -> String {
    let mut json = json.to_string();
    for (at, number) in edits {
        let is_part = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
        // Digits that stand behind a mark, not within a name.
        let starts: Vec<usize> = json
            .char_indices()
            .zip(json.chars().skip(1))
            .filter(|((_, before), c)| ":[,".contains(*before) && is_part(*c))
            .map(|((i, _), _)| i + 1)
            .collect();
        if starts.is_empty() {
            break;
        }
        let start = starts[at.index(starts.len())];
        let end = json[start..].find(|c| !is_part(c)).map_or(json.len(), |n| start + n);
        json.replace_range(start..end, number);
    }
    json
}

fn run(bytes: &[u8]) -> bool {
    match read(&[("a.glb", bytes)]) {
        Ok(loaded) => {
            let scene = &loaded.scene;
            let frames = scene.animation.as_ref().map_or(1, |animation| animation.frames);
            SceneData::flatten(scene).is_ok_and(|(data, _)| {
                let states = FrameStates::new(scene, &data);
                [0, frames / 2, frames - 1].into_iter().all(|frame| states.at(frame).is_ok())
            })
        }
        Err(error) => {
            let message = error.to_string();
            assert!(!message.is_empty() && !message.contains('\n'), "{message}");
            false
        }
    }
}

#[test]
fn the_unchanged_file_loads() {
    let loaded = read(&[("a.glb", &WHOLE)]).unwrap();
    assert_eq!(
        (loaded.scene.instances.len(), loaded.scene.lights.len(), loaded.scene.images.len()),
        (5, 1, 2)
    );
    let animation = loaded.scene.animation.as_ref().unwrap();
    assert_eq!((animation.frames, animation.lights.len()), (60, 1));
    assert!(animation.camera.is_some() && run(&WHOLE));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        run(&bytes);
        run(&[b"glTF\x02\0\0\0", bytes.as_slice()].concat());
    }

    /// Some bytes replaced by ones that matter to JSON, by numbers above all. The length stays, so that most edits do
    /// more than cut the file.
    #[test]
    fn mutated(edits in proptest::collection::vec(
        (any::<Index>(),
         prop_oneof![
             8 => proptest::sample::select(b"0123456789".to_vec()),
             2 => proptest::sample::select(b" -.,:[]{}\"eE".to_vec()),
             1 => any::<u8>(),
         ]), 1..6)) {
        let mut bytes = WHOLE.clone();
        for (at, byte) in edits {
            let i = at.index(bytes.len());
            bytes[i] = byte;
        }
        run(&bytes);
    }

    /// Numbers of the JSON replaced by others.
    #[test]
    fn other_numbers(edits in edits(&[
        "0", "1", "2", "3", "4", "5", "7", "255", "-1", "1e30", "1e-30", "5120", "5121", "5125", "4294967295",
        "4294967296", "18446744073709551615", "1000000000", "0.5", "1e400", "null", "[]",
    ])) {
        run(&super::glb(&renumbered(json(), edits), &WHOLE[28 + json().len()..]));
    }
}
