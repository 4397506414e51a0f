//! Options that nobody would choose, and scenes that make trees deep.

use crate::Numbers;
use crate::structures::{BUILDERS, Options, ask_everything, rays};
use eosphor_accel::{BuildOptions, GridOptions, KdTreeOptions, OctreeOptions, Scene, Vec3, vec3};

fn some_triangles(count: usize, numbers: &mut Numbers) -> Vec<[Vec3; 3]> {
    let mut point = |scale: f32| vec3(numbers.unit(), numbers.unit(), numbers.unit()) * scale;
    (0..count)
        .map(|_| {
            let corner = point(1.0);
            [corner, corner + point(0.2), corner + point(0.2)]
        })
        .collect()
}

#[test]
fn limits_of_zero_and_without_end() {
    let mut numbers = Numbers(1);
    let triangles = some_triangles(300, &mut numbers);
    let scene = Scene::new(&triangles, &[]).unwrap();
    let rays = rays(25, 1.0, &mut numbers);
    for (whole, real) in [
        (0, 0.0),
        (0, f32::NAN),
        (1, -1.0),
        (1, f32::NEG_INFINITY),
        (255, 1e-30),
        (256, 1e30),
        (u32::MAX, f32::INFINITY),
        (u32::MAX, f32::NAN),
    ] {
        for builder in BUILDERS {
            let options = Options {
                bvh: BuildOptions {
                    builder,
                    max_leaf_primitives: whole,
                    traversal_cost: real,
                    max_depth: whole,
                    cut_large_triangles: whole & 1 == 1,
                    reinsertion: real.is_nan() || whole & 1 == 1,
                },
                octree: OctreeOptions {
                    max_leaf_primitives: whole,
                    max_depth: whole,
                    visit_cost: real,
                    max_duplication: real.min(8.0),
                    only_if_cheaper: whole & 1 == 0,
                    ..OctreeOptions::default()
                },
                grid: GridOptions { density: real, max_cells: whole, max_duplication: real.min(8.0) },
                kdtree: KdTreeOptions {
                    traversal_cost: real,
                    empty_bonus: real,
                    patience: whole,
                    max_depth: whole,
                    max_duplication: real.min(8.0),
                },
            };
            ask_everything(&scene.geometry(), &options, &rays);
        }
    }
}

/// Each triangle is half as large as the one before and as far from the middle: no split halves the number.
#[test]
fn triangles_that_halve_make_the_deepest_trees() {
    let mut numbers = Numbers(2);
    let triangles: Vec<[Vec3; 3]> = (0..400)
        .map(|k| {
            let size = 0.5f32.powi(k % 110);
            let at = vec3(size, size * numbers.unit().abs(), 0.0);
            [at, at + vec3(size, 0.0, 0.0) * 0.3, at + vec3(0.0, size, size) * 0.3]
        })
        .collect();
    let scene = Scene::new(&triangles, &[]).unwrap();
    let rays = rays(40, 1.0, &mut numbers);
    for builder in BUILDERS {
        let one = BuildOptions { max_leaf_primitives: 1, traversal_cost: 1e-6, ..BuildOptions::of(builder) };
        ask_everything(&scene.geometry(), &Options { bvh: one, ..Options::of(builder) }, &rays);
    }
}

#[test]
fn many_triangles_in_one_place() {
    let mut numbers = Numbers(3);
    let scene = Scene::new(&[some_triangles(1, &mut numbers)[0]; 3000], &[]).unwrap();
    let rays = rays(10, 1.0, &mut numbers);
    for builder in BUILDERS {
        ask_everything(&scene.geometry(), &Options::of(builder), &rays);
    }
}

#[test]
fn scenes_of_nothing_and_of_one_thing() {
    let mut numbers = Numbers(4);
    let rays = rays(25, 1.0, &mut numbers);
    for count in [0, 1, 2] {
        let scene = Scene::new(&some_triangles(count, &mut numbers), &[]).unwrap();
        for builder in BUILDERS {
            ask_everything(&scene.geometry(), &Options::of(builder), &rays);
        }
    }
}
