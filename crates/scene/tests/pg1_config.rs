//! A configuration of PG1 is its model with the preset `pg1`, to the last bit.

use eosphor_scene::{LoadOptions, Preset, SceneData, load};
use std::path::PathBuf;

#[test]
fn the_configuration_of_the_cornell_box_is_the_preset() {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let Some(folder) = crate::support::scenes().map(|scenes| scenes.join("cornell-box-pg1")) else { return };
    let mut model = load(folder.join("CornellBox-Sphere.obj"), &LoadOptions::default()).unwrap();
    Preset::Pg1.apply(&mut model.scene);
    let (expected, _) = SceneData::flatten(&model.scene).unwrap();

    let config = here.join("tests/data/pg1-config.json");
    let text = std::fs::read_to_string(&config).unwrap();
    // The same with the words spelled right, from a folder of its own.
    let right = text.replace("acceleratied", "accelerated").replace("\"octree\"", "\"octree_parametric\"");
    let right = right.replace("../../../../../shared/scenes/cornell-box-pg1/", &folder.to_string_lossy());
    let wrong = right.replace("accelerated", "acceleratied").replace("octree_parametric", "octee_parametric");
    let temporary = std::env::temp_dir().join(format!("eosphor-pg1-{}", std::process::id()));
    std::fs::create_dir_all(&temporary).unwrap();
    let write = |name: &str, text: &str| {
        let path = temporary.join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    for path in [config, write("right.json", &right), write("wrong.json", &wrong)] {
        let loaded = load(&path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let warnings: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
        assert_eq!(warnings.len(), 1, "the stray dot of the model: {warnings:?}");
        assert_eq!(loaded.scene.settings, model.scene.settings);
        assert_eq!(loaded.scene.camera, model.scene.camera);
        let (data, notes) = SceneData::flatten(&loaded.scene).unwrap();
        assert!(notes.is_empty(), "{notes:?}");
        assert!(format!("{data:?}") == format!("{expected:?}"), "{}", path.display());
        assert_eq!(loaded.files_read[0], path);
    }
    std::fs::remove_dir_all(&temporary).unwrap();
}
