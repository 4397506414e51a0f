//! The octree of PG1 (a thesis of CTU FIT, 2025) over its Cornell box: the numbers that it publishes.

use eosphor_accel::{Octree, OctreeOptions, SceneGeometry};
use eosphor_scene::{LoadOptions, Preset, SceneData, load};
use std::path::Path;

#[test]
fn pg1s_options_make_pg1s_tree() {
    // Among the test scenes beside the checkout, which a clone alone does not have.
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/scenes/cornell-box-pg1/CornellBox-Sphere.obj");
    if !path.is_file() {
        eprintln!("SKIPPED: {} is not there", path.display());
        return;
    }
    let mut scene = load(&path, &LoadOptions::default()).unwrap().scene;
    Preset::Pg1.apply(&mut scene);
    let (data, _) = SceneData::flatten(&scene).unwrap();
    let geometry = SceneGeometry {
        triangles: &data.triangles,
        spheres: &data.spheres,
        geometries: &data.geometries,
        instances: &data.instances,
    };
    let s = Octree::build(&geometry, &OctreeOptions::pg1()).statistics();
    let hundredths = |x: f64| (x * 100.0).round() as u32;
    assert_eq!((s.primitives, s.nodes, s.leaves), (2_188, 1_584, 1_300));
    assert_eq!((hundredths(s.mean_leaf_primitives), s.max_leaf_primitives), (703, 34));
    assert_eq!(hundredths(s.mean_leaf_depth), 522);
}
