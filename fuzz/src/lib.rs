//! What all targets share: files in memory, loaded and flattened; worlds under every structure.

mod hits;
#[path = "../../crates/accel/tests/support/mod.rs"]
mod support;

pub use hits::{build, traverse};

use eosphor_scene::{LoadOptions, SceneData, load_from_memory};
use eosphor_viewer::PageView;
use std::path::PathBuf;
use std::sync::OnceLock;

/// Files that the fuzzed one may name.
const COMPANIONS: [(&str, &[u8]); 5] = [
    (
        "a.obj",
        b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red\nf 1/1 2/2 3/3\n",
    ),
    ("m.mtl", b"newmtl red\nKd 1 0 0\nmap_Kd t.ppm\n"),
    ("t.ppm", b"P3\n1 1\n255\n1 2 3\n"),
    ("b.bin", &[0x3f; 256]),
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
    files.extend(COMPANIONS.map(|(name, bytes)| (PathBuf::from(name), bytes.to_vec())));
    let error = match load_from_memory(files, start, &LoadOptions::default()) {
        Ok(loaded) => match SceneData::flatten(&loaded.scene) {
            Ok((data, _)) => return data.check().expect("flattened scenes hold together"),
            Err(error) => error,
        },
        Err(error) => error,
    };
    let text = error.to_string();
    assert!(!text.is_empty() && !text.contains('\n'), "{text:?}");
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
