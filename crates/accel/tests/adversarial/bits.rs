//! Coordinates of any bits: those that are out of range are refused, and with the others nothing happens but hits.

use crate::Numbers;
use crate::structures::{BUILDERS, Options, ask_everything, rays};
use eosphor_accel::{Affine, Bounds, Geometry, GeometryError, Instance, SceneGeometry, Sphere, Vec3, vec3};

/// A world and a mesh that is placed twice, with the numbers that `number` gives.
fn ask_scene_of(seed: u64, extent: f32, number: impl Fn(&mut Numbers) -> f32) -> Result<(), GeometryError> {
    let mut numbers = Numbers(seed);
    let vector = |numbers: &mut Numbers| vec3(number(numbers), number(numbers), number(numbers));
    let triangles: Vec<[Vec3; 3]> = (0..80).map(|_| [(); 3].map(|()| vector(&mut numbers))).collect();
    let spheres: Vec<Sphere> = (0..12)
        .map(|_| Sphere { center: vector(&mut numbers), radius: number(&mut numbers).abs() })
        .collect();
    let ranges = [[0, 50, 0, 7], [50, 30, 7, 5]];
    let geometries = ranges.map(|[first_triangle, triangle_count, first_sphere, sphere_count]| Geometry {
        first_triangle,
        triangle_count,
        first_sphere,
        sphere_count,
        extent: number(&mut numbers).abs(),
        first_sphere_object: 0,
    });
    let instances: Vec<Instance> = [0, 1, 1]
        .into_iter()
        .map(|geometry| {
            let mut map = || Affine {
                columns: [(); 3].map(|()| vector(&mut numbers)),
                translation: vector(&mut numbers),
            };
            let (object_from_world, world_from_object) = (map(), map());
            let world_bounds = Bounds { min: vector(&mut numbers), max: vector(&mut numbers) };
            Instance {
                object_from_world,
                world_from_object,
                world_bounds,
                geometry,
                material: u32::MAX,
                object: 0,
            }
        })
        .collect();
    let rays = rays(40, extent, &mut numbers);
    let scene = SceneGeometry::new(&triangles, &spheres, &geometries, &instances)?;
    ask_everything(&scene, &Options::of(BUILDERS[seed as usize % BUILDERS.len()]), &rays);
    Ok(())
}

/// A number with any bits that is in range.
fn any_in_range(numbers: &mut Numbers) -> f32 {
    loop {
        let number = numbers.any();
        if number.abs() <= 1e18 {
            return number;
        }
    }
}

#[test]
fn numbers_out_of_range_are_refused() {
    for (seed, bad) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.01e18, f32::MIN].into_iter().enumerate()
    {
        for share in [1, 8, 64] {
            let number = |numbers: &mut Numbers| {
                if numbers.bits().is_multiple_of(share) { bad } else { numbers.unit() }
            };
            let refused = ask_scene_of(seed as u64, 1.0, number);
            assert!(matches!(refused, Err(GeometryError::OutOfRange { .. })), "{bad} {share}");
        }
    }
}

#[test]
fn numbers_of_any_bits() {
    for seed in 0..60 {
        ask_scene_of(seed, 1.0, any_in_range).unwrap();
    }
}

#[test]
fn numbers_at_both_ends_of_the_range() {
    for seed in 0..12 {
        ask_scene_of(seed, 1e18, |numbers| numbers.unit() * 1e18).unwrap();
        ask_scene_of(seed, 1e-38, |numbers| numbers.unit().max(1e-5) * 1e-38).unwrap();
        let both =
            |numbers: &mut Numbers| numbers.unit().max(1e-5) * [1e-38, 1e18][numbers.bits() as usize & 1];
        ask_scene_of(seed, 1.0, both).unwrap();
    }
}

#[test]
fn everything_in_one_point() {
    for seed in 0..6 {
        ask_scene_of(seed, 1.0, |_| 0.25).unwrap();
    }
}
