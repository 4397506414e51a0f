//! The octree of PG1 (a thesis of CTU FIT, 2025) over its Cornell box: the numbers that it publishes.

use eosphor_accel::{Octree, OctreeOptions, SceneGeometry};
use eosphor_scene::{LoadOptions, Preset, SceneData, load};

#[test]
fn pg1s_options_make_pg1s_tree() {
    let mut scene = load("builtin:cornell".as_ref(), &LoadOptions::default()).unwrap().scene;
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
