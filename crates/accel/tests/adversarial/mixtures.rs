//! Parts of one hierarchy with parts of another.

use crate::message_of;
use eosphor_accel::{
    Affine, BuildOptions, Bvh, Bvh8, BvhPairs, BvhWide, Exhaustive, Grid, GridOptions, IgnoreWork, Instance,
    KdTree, KdTreeOptions, Octree, OctreeOptions, RefitError, Scene, SceneGeometry, Vec3, vec3,
};

/// So many meshes of so many triangles, each placed once.
fn scene(meshes: usize, triangles: usize) -> Scene {
    let mut scene = Scene::new(&[triangle(0); 3], &[]).unwrap();
    for mesh in 0..meshes {
        let shapes: Vec<[Vec3; 3]> = (0..triangles).map(triangle).collect();
        let mesh_id = scene.mesh(&shapes, &[]).unwrap();
        let translation = vec3(3.0 * mesh as f32, 0.0, 0.0);
        scene.place(mesh_id, Affine { translation, ..Affine::IDENTITY }).unwrap();
    }
    scene
}

fn triangle(k: usize) -> [Vec3; 3] {
    let z = k as f32;
    [vec3(0.0, 0.0, z), vec3(1.0, 0.0, z), vec3(0.0, 1.0, z)]
}

const NO_TRACER: &str = "a hierarchy over instances alone is the top level of another";

#[test]
fn hierarchies_over_instances_alone_have_no_tracer() {
    let scene = scene(2, 5);
    let instances = scene.geometry().instances();
    let top = SceneGeometry::of_instances(instances).unwrap();
    let options = BuildOptions::default();
    let (bvh, bvh8) = (Bvh::build(&top, &options), Bvh8::build(&top, &options));
    let octree = Octree::build(&top, &OctreeOptions::default());
    let grid = Grid::build(&top, &GridOptions::default());
    let kdtree = KdTree::build(&top, &KdTreeOptions::default());
    let messages = [
        message_of(|| Exhaustive::new(&top).tracer(IgnoreWork).work),
        message_of(|| bvh.tracer(IgnoreWork)),
        message_of(|| bvh8.tracer()),
        message_of(|| bvh8.counting_tracer(IgnoreWork)),
        message_of(|| octree.tracer(IgnoreWork)),
        message_of(|| octree.parametric_tracer(IgnoreWork)),
        message_of(|| grid.tracer(IgnoreWork)),
        message_of(|| kdtree.tracer(IgnoreWork)),
    ];
    assert_eq!(messages, [NO_TRACER; 8]);
    // What they are for is there all the same.
    let trees = [bvh.instance_tree(), octree.instance_tree(), grid.instance_tree(), kdtree.instance_tree()];
    assert!(trees.iter().all(|tree| tree.order == [1, 2]));
    // No instance at all, not even the world.
    let nothing = SceneGeometry::of_instances(&[]).unwrap();
    assert_eq!(message_of(|| _ = Bvh8::build(&nothing, &options).tracer()), NO_TRACER);
}

#[test]
fn instances_of_geometries_that_a_hierarchy_lacks_are_no_top_level_of_it() {
    let (few, many) = (scene(1, 5), scene(4, 5));
    let options = BuildOptions::default();
    let top = SceneGeometry::of_instances(many.geometry().instances()).unwrap();
    let what = "instances place geometry 4, the hierarchy has 2";
    let two =
        |scene: &Scene| (Bvh::build(&scene.geometry(), &options), Bvh8::build(&scene.geometry(), &options));
    let (bvh, bvh8) = two(&few);
    assert_eq!(
        message_of(|| _ = bvh.tracer_with_instances_of(&Bvh::build(&top, &options), IgnoreWork)),
        what
    );
    assert_eq!(message_of(|| _ = bvh8.tracer().with_instances_of(&Bvh8::build(&top, &options))), what);
    let octree = |scene: &SceneGeometry| Octree::build(scene, &OctreeOptions::default());
    let (below, above) = (octree(&few.geometry()), octree(&top));
    assert_eq!(message_of(|| below.tracer_with_instances_of(&above, IgnoreWork)), what);
    assert_eq!(message_of(|| below.parametric_tracer_with_instances_of(&above, IgnoreWork)), what);
    let grid = |scene: &SceneGeometry| Grid::build(scene, &GridOptions::default());
    let (below, above) = (grid(&few.geometry()), grid(&top));
    assert_eq!(message_of(|| below.tracer_with_instances_of(&above, IgnoreWork)), what);
    let kdtree = |scene: &SceneGeometry| KdTree::build(scene, &KdTreeOptions::default());
    let (below, above) = (kdtree(&few.geometry()), kdtree(&top));
    assert_eq!(message_of(|| below.tracer_with_instances_of(&above, IgnoreWork)), what);
    let (below, above) = (Exhaustive::new(&few.geometry()), Exhaustive::new(&top));
    assert_eq!(message_of(|| below.tracer_with_instances_of(&above, IgnoreWork)), what);
    // The other way round there are geometries enough.
    let (all, all8) = two(&many);
    all.tracer_with_instances_of(&bvh, IgnoreWork);
    all8.tracer().with_instances_of(&bvh8);
}

#[test]
fn nodes_for_gpus_go_with_their_own_hierarchy() {
    let options = BuildOptions::default();
    let build = |scene: &Scene| Bvh::build(&scene.geometry(), &options);
    let bvh = build(&scene(3, 40));
    let pairs = BvhPairs::new(&bvh).unwrap();
    let wide = BvhWide::new(&pairs).unwrap();
    for other in [scene(2, 40), scene(3, 39), scene(0, 0), scene(4, 40)] {
        let other = build(&other);
        let messages = [
            message_of(|| pairs.tracer(&other)),
            message_of(|| pairs.tracer_in_step(&other)),
            message_of(|| pairs.far_tracer(&other)),
            message_of(|| pairs.world_tracer(&other, eosphor_core::device::WarpMode::AUTO)),
            message_of(|| wide.tracer(&other)),
        ];
        assert!(messages.iter().all(|m| m.contains("go with the hierarchy")), "{messages:?}");
    }
}

#[test]
fn scenes_of_other_counts_are_no_new_shapes() {
    let options = BuildOptions::default();
    let built = scene(2, 10);
    let mut bvh = Bvh::build(&built.geometry(), &options);
    let mut bvh8 = Bvh8::build(&built.geometry(), &options);
    for other in [scene(2, 9), scene(2, 11), scene(1, 10), scene(3, 10)] {
        assert!(bvh.refit(&other.geometry()).is_err() && bvh8.refit(&other.geometry()).is_err());
    }
    // Two geometries that change places.
    let mut swapped: Vec<Instance> = built.geometry().instances().to_vec();
    (swapped[1].geometry, swapped[2].geometry) = (2, 1);
    let all = built.geometry();
    let other = SceneGeometry::new(all.triangles(), all.spheres(), all.geometries(), &swapped).unwrap();
    assert_eq!(bvh.refit(&other), Err(RefitError::Instance { number: 1 }));
    assert_eq!(bvh8.refit(&other), Err(RefitError::Instance { number: 1 }));
    assert!(bvh8.refit(&SceneGeometry::of_instances(&swapped).unwrap()).is_err());
    bvh8.refit(&built.geometry()).unwrap();
    bvh8.tracer();
}
