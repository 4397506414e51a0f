//! The example scenes of the repository load without a word and keep their promises.

use eosphor_scene::{LoadOptions, SceneData, load};
use std::path::PathBuf;

#[test]
fn every_example_scene_loads_without_warnings_and_notes() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    if !folder.is_dir() {
        println!("skipped: {} is not there", folder.display());
        return;
    }
    let mut count = 0;
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "json") || path.ends_with("schema.json") {
            continue;
        }
        let loaded = load(&path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let (data, notes) =
            SceneData::flatten(&loaded.scene).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(loaded.warnings.is_empty() && notes.is_empty(), "{}", path.display());
        assert!(!data.lights.is_empty() && data.spheres.len() + data.triangles.len() > 2);
        assert_eq!(loaded.files_read[0], path);
        // The floor of the solids is built in.
        let images = if path.ends_with("solids.json") { 0 } else { loaded.scene.images.len() };
        assert_eq!(loaded.files_read.len(), 1 + images);
        count += 1;
    }
    assert!(count >= 4);
}
