//! What a ray is expected to cost in a scene of instances, against answers by hand.

use eosphor_accel::{
    Affine, Bounds, BuildOptions, Bvh, Bvh8, Exhaustive, Grid, GridOptions, KdTree, KdTreeOptions, Octree,
    OctreeOptions, Scene, SceneGeometry, Vec3, vec3,
};

type Cost = fn(&SceneGeometry) -> f64;

/// All but `none`.
const TREES: [(&str, Cost); 6] = [
    ("bvh", |scene| Bvh::build(scene, &BuildOptions::default()).statistics().sah_cost),
    ("bvh8", |scene| Bvh8::build(scene, &BuildOptions::default()).statistics().sah_cost),
    ("octree", |scene| Octree::build(scene, &OctreeOptions::default()).statistics().sah_cost),
    ("octree-parametric", |scene| Octree::build(scene, &OctreeOptions::parametric()).statistics().sah_cost),
    ("grid", |scene| Grid::build(scene, &GridOptions::default()).statistics().sah_cost),
    ("kdtree", |scene| KdTree::build(scene, &KdTreeOptions::default()).statistics().sah_cost),
];

const NONE: Cost = |scene| Exhaustive::new(scene).statistics().sah_cost;

/// Small triangles all over a cube of side 1.
fn cube_of_triangles() -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for k in 0..1000u32 {
        let [x, y, z] = [k % 10, k / 10 % 10, k / 100].map(|n| n as f32 / 10.0);
        let corner = |a: f32, b: f32, c: f32| vec3(x + a, y + b, z + c);
        triangles.push([corner(0.0, 0.0, 0.1), corner(0.1, 0.0, 0.0), corner(0.0, 0.1, 0.0)]);
    }
    triangles
}

fn moved(x: f32) -> Affine {
    Affine { translation: vec3(x, 0.0, 0.0), ..Affine::IDENTITY }
}

/// The mesh as the world, and a scene without a world that places it along x.
fn alone_and_placed(places: &[f32]) -> (Scene, Scene) {
    let mut placed = Scene::default();
    let mesh = placed.mesh(&cube_of_triangles(), &[]).unwrap();
    for &x in places {
        placed.place(mesh, moved(x)).unwrap();
    }
    (Scene::new(&cube_of_triangles(), &[]).unwrap(), placed)
}

fn assert_near(name: &str, found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 2e-3, "{name}: {found} instead of {expected}");
}

#[test]
fn a_single_instance_costs_what_its_mesh_does() {
    let (alone, placed) = alone_and_placed(&[0.0]);
    for (name, cost) in TREES {
        let own = cost(&alone.geometry());
        assert!(own > 1.0 && own < 1000.0, "{name}: {own}");
        assert_near(name, cost(&placed.geometry()), own);
        let (_, elsewhere) = alone_and_placed(&[-3.0]);
        assert_near(name, cost(&elsewhere.geometry()), own);
    }
    assert_eq!((NONE(&alone.geometry()), NONE(&placed.geometry()).round()), (1000.0, 1001.0));
}

#[test]
fn two_instances_cost_the_sum_weighted_by_their_surfaces() {
    let (alone, placed) = alone_and_placed(&[0.0, 9.0]);
    // Half the surface of a cube is 3, that of the box around both 10 + 10 + 1.
    let share = 3.0 / 21.0;
    for (name, cost) in TREES {
        let own = cost(&alone.geometry());
        let both = 2.0 * share * own;
        let found = cost(&placed.geometry());
        // The tree over the instances has one inner node, which every ray visits, or is one leaf.
        let inner = f64::from(found > both + 0.5);
        assert_near(name, found, both + inner);
    }
    assert_near("none", NONE(&placed.geometry()), 2.0 + 2.0 * share * 1000.0);
}

#[test]
fn the_world_counts_by_its_share() {
    let mut scene = Scene::new(&cube_of_triangles(), &[]).unwrap();
    let mesh = scene.mesh(&cube_of_triangles(), &[]).unwrap();
    // Twice as large, so four times the surface.
    scene
        .place(
            mesh,
            Affine {
                columns: [vec3(2.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0), vec3(0.0, 0.0, 2.0)],
                translation: vec3(8.0, 0.0, 0.0),
            },
        )
        .unwrap();
    let (alone, _) = alone_and_placed(&[]);
    let around = f64::from(Bounds { min: Vec3::ZERO, max: vec3(10.0, 2.0, 2.0) }.half_area());
    for (name, cost) in TREES {
        let own = cost(&alone.geometry());
        assert_near(name, cost(&scene.geometry()), (3.0 + 12.0) / around * own);
    }
    assert_near("none", NONE(&scene.geometry()), 1000.0 + 1.0 + 12.0 / around * 1000.0);
}

#[test]
fn a_tree_of_one_leaf_costs_its_primitives_and_nothing_costs_nothing() {
    let triangle = [Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)];
    let three = Scene::new(&[triangle; 3], &[]).unwrap();
    let empty = Scene::default();
    for (name, cost) in TREES {
        assert_eq!(cost(&empty.geometry()), 0.0, "{name}");
        if name.starts_with("bvh") {
            assert_eq!(cost(&three.geometry()), 3.0, "{name}");
        }
    }
    assert_eq!((NONE(&empty.geometry()), NONE(&three.geometry())), (0.0, 3.0));
}
