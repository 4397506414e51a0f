//! What is built anew from a geometry on is what is built over the whole scene.

#[path = "support/mod.rs"]
mod support;

use eosphor_accel::{Accel, Affine, Builder, Hierarchy, HierarchyOptions, RefitError, Scene, Sphere, vec3};
use eosphor_core::math::Vec3;
use support::Random;

fn triangles(random: &mut Random, count: usize) -> Vec<[Vec3; 3]> {
    let triangle = |_| {
        let p = random.in_cube() * 5.0;
        [p, p + random.in_cube(), p + random.in_cube()]
    };
    (0..count).map(triangle).collect()
}

/// Sizes of the meshes after the world: triangles and spheres.
const MESHES: [(usize, usize); 4] = [(30, 0), (0, 3), (90, 2), (17, 0)];

/// A scene whose meshes from this number on are shaped by another seed.
fn scene(seed: u64, first: usize, other_seed: u64) -> Scene {
    let mut random = Random(seed);
    let mut scene = Scene::new(&triangles(&mut random, 50), &[]).unwrap();
    for (number, (triangle_count, sphere_count)) in MESHES.into_iter().enumerate() {
        if number + 1 == first {
            random = Random(other_seed);
        }
        let spheres: Vec<Sphere> = (0..sphere_count)
            .map(|k| Sphere { center: random.in_cube() + vec3(k as f32, 0.0, 0.0), radius: 0.5 })
            .collect();
        let mesh = scene.mesh(&triangles(&mut random, triangle_count), &spheres).unwrap();
        let moved = Affine { translation: random.in_cube() * 9.0, ..Affine::IDENTITY };
        scene.place(mesh, moved).unwrap();
    }
    scene
}

/// All that a hierarchy holds, but for the time that it took.
fn held(mut hierarchy: Hierarchy) -> String {
    match &mut hierarchy {
        Hierarchy::Exhaustive(_) => {}
        Hierarchy::Bvh(bvh) => bvh.build_seconds = 0.0,
        Hierarchy::Bvh8(bvh) => bvh.build_seconds = 0.0,
        Hierarchy::Octree(tree) | Hierarchy::OctreeParametric(tree) => tree.build_seconds = 0.0,
        Hierarchy::Grid(grid) => grid.build_seconds = 0.0,
        Hierarchy::KdTree(tree) => tree.build_seconds = 0.0,
    }
    format!("{hierarchy:?}")
}

#[test]
fn what_is_built_from_a_geometry_on_is_what_is_built_over_all() {
    for &accel in Accel::ALL {
        let builders: &[Option<Builder>] = match accel {
            Accel::Bvh | Accel::Bvh8 => &Builder::ALL.map(Some),
            _ => &[None],
        };
        for &builder in builders {
            let options = HierarchyOptions { builder, ..HierarchyOptions::default() };
            for first in 0..=MESHES.len() + 1 {
                let mut hierarchy = Hierarchy::build(accel, &options, &scene(1, first, 2).geometry());
                // Twice: nothing is left of what was there before.
                for seed in [3, 4] {
                    let new = scene(1, first, seed);
                    hierarchy.rebuild_from(first, &new.geometry(), &options).unwrap();
                    let expected = Hierarchy::build(accel, &options, &new.geometry());
                    assert_eq!(held(hierarchy.clone()), held(expected), "{accel} {builder:?} from {first}");
                }
            }
        }
    }
}

#[test]
fn other_geometries_before_are_refused() {
    let (old, new) = (scene(1, 9, 2), Scene::new(&[], &[]).unwrap());
    for &accel in Accel::ALL {
        let options = HierarchyOptions::default();
        let mut hierarchy = Hierarchy::build(accel, &options, &old.geometry());
        let before = format!("{hierarchy:?}");
        let refused = hierarchy.rebuild_from(1, &new.geometry(), &options);
        assert_eq!(refused, Err(RefitError::Geometry { number: 0 }), "{accel}");
        let refused = hierarchy.rebuild_from(2, &new.geometry(), &options);
        assert!(matches!(refused, Err(RefitError::Counts { .. })), "{accel}");
        assert_eq!(format!("{hierarchy:?}"), before);
    }
}
