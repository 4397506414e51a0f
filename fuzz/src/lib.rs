//! What all targets share: files in memory, loaded and flattened; worlds under every structure.

mod hits;
#[path = "../../crates/accel/tests/support/mod.rs"]
mod support;

pub use hits::{build, traverse};

use eosphor_scene::{
    EnvironmentMap, EnvironmentSource, FrameStates, LoadOptions, Scene, SceneData, SceneError, ShapedArrays,
    load_from_memory,
};
use eosphor_viewer::PageView;
use std::path::PathBuf;
use std::sync::OnceLock;

/// Files that the fuzzed one may name.
const COMPANIONS: [(&str, &[u8]); 6] = [
    (
        "a.obj",
        b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red\nf 1/1 2/2 3/3\n",
    ),
    ("m.mtl", b"newmtl red\nKd 1 0 0\nmap_Kd t.ppm\n"),
    ("t.ppm", b"P3\n1 1\n255\n1 2 3\n"),
    ("b.bin", &[0x3f; 256]),
    ("s.gltf", include_bytes!("../seeds/skin.gltf")),
    (
        "b.json",
        br#"{"eosphor": 2, "meshes": [{"file": "a.obj"}], "lights": [{"point": {"position": [0, 2, 0], "color": [1, 1, 1]}}],
            "animation": {"frames": 2, "camera": {"orbit": {}}}}"#,
    ),
];

/// Loads `start` among the companions, of which `name` has the fuzzed bytes. What loads is flattened too. Errors must say
/// something, in one line.
pub fn load(start: &str, name: &str, bytes: &[u8]) {
    load_files(start, &[(name, bytes)]);
}

/// As [`load`], with several fuzzed files.
pub fn load_files(start: &str, fuzzed: &[(&str, &[u8])]) {
    let mut files: Vec<_> =
        fuzzed.iter().map(|(name, bytes)| (PathBuf::from(name), bytes.to_vec())).collect();
    let others = COMPANIONS.into_iter().filter(|(name, _)| fuzzed.iter().all(|(own, _)| own != name));
    files.extend(others.map(|(name, bytes)| (PathBuf::from(name), bytes.to_vec())));
    let error = match load_from_memory(files, start, &LoadOptions::default()) {
        // A sky is a picture of 4 million texels, made by arithmetic alone: few are.
        Ok(loaded) if has_sky(&loaded.scene) && !is_chosen(fuzzed) => return,
        Ok(loaded) => match SceneData::flatten(&loaded.scene) {
            Ok((data, _)) => {
                data.check().expect("flattened scenes hold together");
                return frames(&loaded.scene, &data);
            }
            Err(error) => error,
        },
        Err(error) => error,
    };
    says_something(&error);
}

fn says_something(error: &SceneError) {
    let text = error.to_string();
    assert!(!text.is_empty() && !text.contains('\n'), "{text:?}");
}

/// Some frames of what moves: skins and morph targets at several times.
fn frames(scene: &Scene, data: &SceneData) {
    let Some(animation) = &scene.animation else { return };
    let states = FrameStates::new(scene, data);
    let mut arrays = ShapedArrays::new(data);
    for frame in [0, 1, animation.frames / 2, animation.frames - 1] {
        match states.at(frame) {
            Ok(state) => {
                if let Some(shapes) = &state.shapes {
                    arrays.take(shapes, data).expect("frames have the scene's triangles");
                    assert!(arrays.has(shapes));
                }
            }
            Err(error) => says_something(&error),
        }
    }
}

fn has_sky(scene: &Scene) -> bool {
    matches!(scene.environment, Some(EnvironmentMap { source: EnvironmentSource::Sky(_), .. }))
}

/// One of 64, by the bytes alone.
fn is_chosen(fuzzed: &[(&str, &[u8])]) -> bool {
    let hash = |hash: u32, byte: &u8| (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193);
    let all = fuzzed.iter().flat_map(|(_, bytes)| *bytes).fold(0x811c_9dc5, hash);
    (all >> 16).is_multiple_of(64)
}

/// A message of the viewer's page, about a built-in scene.
pub fn message(bytes: &[u8]) {
    static SHOWN: OnceLock<(eosphor_scene::Scene, SceneData, PageView)> = OnceLock::new();
    let (scene, data, own) = SHOWN.get_or_init(|| {
        let scene = eosphor_scene::load("builtin:cornell", &LoadOptions::default()).expect("a built-in scene").scene;
        let data = SceneData::flatten(&scene).expect("it can be flattened").0;
        let own = r#"{ "size": [64, 36], "camera": { "eye": [0, 0.795, 4.42], "look-at": [0, 0.795, 0], "up": [0, 1, 0], "fov": 40, "aperture": 0 },
            "samples": 8, "light-samples": 16, "depth": 10, "lighting": "blinn-phong", "shadows": "coloured", "exposure": 1.9, "tone-curve": "none",
            "frame": 0, "show": "picture" }"#;
        (scene, data, serde_json::from_str(own).expect("a view"))
    });
    eosphor_viewer::fuzz_message(scene, data, own, bytes);
}
