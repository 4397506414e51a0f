//! PG1 (a report of CTU FIT, 2025): its Cornell box, and the numbers that it publishes of its octree over it.

use eosphor_accel::{Octree, OctreeOptions, SceneGeometry};
use eosphor_picture::output::DevelopSettings;
use eosphor_picture::scene_hash;
use eosphor_render::{Backend, CpuBackend, CpuOptions, RenderControl};
use eosphor_scene::{LoadOptions, Preset, Scene, SceneData, load};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

#[test]
fn pg1s_options_make_pg1s_tree() {
    let scene = load("builtin:cornell-pg1", &LoadOptions::default()).unwrap().scene;
    let (data, _) = SceneData::flatten(&scene).unwrap();
    let geometry = SceneGeometry::new(&data.triangles, &data.spheres, &data.geometries, &data.instances)
        .expect("arrays that hold together");
    let s = Octree::build(&geometry, &OctreeOptions::pg1()).statistics();
    let hundredths = |x: f64| (x * 100.0).round() as u32;
    assert_eq!((s.primitives, s.nodes, s.leaves), (2_188, 1_584, 1_300));
    assert_eq!((hundredths(s.mean_leaf_primitives), s.max_leaf_primitives), (703, 34));
    assert_eq!(hundredths(s.mean_leaf_depth), 522);
}

/// The picture that it publishes figures of has some 134 rays a pixel here; `builtin:cornell` with the same settings has 91.
#[test]
fn the_built_in_box_is_pg1s_own() {
    let mut scene = load("builtin:cornell-pg1", &LoadOptions::default()).unwrap().scene;
    assert_eq!(
        (scene.settings.size, scene.settings.light_samples, scene.settings.depth),
        ([800, 800], 50, 10)
    );
    let mut again = scene.clone();
    Preset::Pg1.apply(&mut again);
    assert_eq!(
        (&again.settings, &again.camera),
        (&scene.settings, &scene.camera),
        "the preset is set already"
    );

    scene.settings.size = [100, 100];
    let (data, notes) = SceneData::flatten(&scene).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    let prepared = CpuBackend::new(CpuOptions::default()).unwrap().prepare(Arc::new(data)).unwrap();
    let cancel = AtomicBool::new(false);
    let control = RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work: false, frame: None };
    let rays = prepared.render(&control).unwrap().statistics;
    assert_eq!((rays.camera, rays.total_rays() / 10_000), (10_000, 134));

    // Where the test scenes are beside the checkout: to the last bit.
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/scenes/cornell-box-pg1/CornellBox-Sphere.obj");
    if !path.is_file() {
        eprintln!("SKIPPED: {} is not there", path.display());
        return;
    }
    let mut file = load(&path, &LoadOptions::default()).unwrap().scene;
    Preset::Pg1.apply(&mut file);
    let hash = |scene: &Scene| {
        let (data, _) = SceneData::flatten(scene).unwrap();
        scene_hash(&data, &DevelopSettings::from(&scene.settings))
    };
    assert_eq!(hash(&file), hash(&again));
}
