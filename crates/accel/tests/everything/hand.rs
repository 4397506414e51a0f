//! Cases by hand: rays that are none, and numbers at the edge of what there is.

use crate::check::{check, check_shadows};
use crate::fused::Fused;
use crate::scenes::{Kind, on_planes, primitives};
use crate::support::{Random, World};
use crate::ways::Structures;
use eosphor_accel::{BuildOptions, Builder, Bvh, Exhaustive};
use eosphor_core::hierarchy::{IgnoreWork, Tracer};
use eosphor_core::math::{Affine, Vec3, vec3};
use eosphor_core::ray::{Ray, RayFilter};

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
}

/// A world of everything, placed once more beside itself.
fn mixed(random: &mut Random) -> World {
    let (triangles, spheres) = primitives(Kind::Mixed, 60, random);
    let mut world = World::new(triangles.clone(), spheres.clone());
    let geometry = world.add_geometry(&triangles, &spheres);
    world.add_instance(geometry, Affine { translation: vec3(0.5, 0.25, -0.5), ..Affine::IDENTITY });
    world
}

#[test]
fn rays_that_are_no_rays_hit_nothing() {
    let mut random = Random(3);
    let structures = Structures::new(&mixed(&mut random));
    let reference = Fused(structures.exhaustive.tracer(IgnoreWork));
    let good = ray(vec3(0.1, 0.2, 3.0), vec3(0.05, -0.1, -1.0).normalize());
    let poisoned = |v: Vec3, component: usize, poison: f32| {
        let mut parts: [f32; 3] = v.into();
        parts[component] = poison;
        Vec3::from(parts)
    };
    let mut bad = Vec::new();
    for poison in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.1e18, -f32::MAX] {
        for component in 0..3 {
            bad.push(Ray { origin: poisoned(good.origin, component, poison), ..good });
            bad.push(Ray { direction: poisoned(good.direction, component, poison), ..good });
        }
        bad.push(Ray { origin: Vec3::splat(poison), direction: Vec3::splat(poison), ..good });
    }
    bad.extend([Vec3::ZERO, -Vec3::ZERO].map(|direction| Ray { direction, ..good }));
    bad.extend([f32::NAN, f32::NEG_INFINITY, -0.0, 0.0].map(|t_max| Ray { t_max, ..good }));
    bad.extend([f32::NAN, f32::INFINITY].map(|t_min| Ray { t_min, ..good }));
    bad.push(Ray { t_min: 4.0, t_max: 3.0, ..good });
    bad.push(Ray { t_min: f32::NEG_INFINITY, t_max: f32::NEG_INFINITY, ..good });
    for ray in &bad {
        assert!(reference.closest_hit(ray, &RayFilter::ALL).is_miss(), "{ray:?}");
    }
    let asked: Vec<_> = bad.iter().map(|r| (*r, RayFilter::ALL)).collect();
    check(&structures, &asked, &[asked.len()]);
    check(&structures, &asked, &[1]);
    check_shadows(&structures, &bad, &RayFilter::ALL);
    // Among good ones.
    let asked: Vec<_> = bad.iter().flat_map(|r| [(good, RayFilter::ALL), (*r, RayFilter::ALL)]).collect();
    check(&structures, &asked, &[16, 100]);
}

#[test]
fn empty_worlds_are_missed() {
    let mut instanced = World::new(vec![], vec![]);
    let nothing = instanced.add_geometry(&[], &[]);
    instanced.add_instance(nothing, Affine::IDENTITY);
    let mut random = Random(1);
    for world in [World::new(vec![], vec![]), instanced] {
        let structures = Structures::new(&world);
        let rays = (0..100).map(|_| ray(random.in_cube(), random.direction()));
        let rays = rays.chain([ray(Vec3::ZERO, vec3(0.0, 0.0, -1.0)), ray(Vec3::ZERO, vec3(-0.0, 1.0, 0.0))]);
        let asked: Vec<_> = rays.map(|r| (r, RayFilter::ALL)).collect();
        let reference = Fused(structures.exhaustive.tracer(IgnoreWork));
        assert!(asked.iter().all(|(r, f)| reference.closest_hit(r, f).is_miss()));
        check(&structures, &asked, &[3, 50]);
    }
}

#[test]
fn triangles_whose_products_underflow_are_hit_at_the_same_t() {
    let mut random = Random(9);
    for exponent in (-75..-35).step_by(2) {
        // Alone, and at the centre of something large: what is small beside a scene can only lie there.
        for large in [false, true] {
            let size = 2f32.powi(exponent);
            let mut triangles: Vec<_> = (0..10)
                .map(|_| {
                    // Around the origin.
                    let (a, b) = (random.in_cube() * size, random.in_cube() * size);
                    [a, b, (a + b) * -0.5]
                })
                .collect();
            let reach = if large { 1.0 } else { size * 4.0 };
            if large {
                triangles.push([vec3(1.0, 0.0, -0.9), vec3(0.9, 0.1, -1.0), vec3(1.0, 0.1, -1.0)]);
            }
            let structures = Structures::new(&World::new(triangles, vec![]));
            let reference = Fused(structures.exhaustive.tracer(IgnoreWork));
            let mut asked = Vec::new();
            for _ in 0..100 {
                // Through the origin exactly.
                let direction = random.direction();
                let ray = ray(direction * (-reach * 0.5f32.powi(random.below(3) as i32)), direction);
                asked.push((ray, RayFilter::ALL));
                let hit = reference.closest_hit(&ray, &RayFilter::ALL);
                if !hit.is_miss() {
                    asked.push((Ray { t_max: hit.t, ..ray }, RayFilter::ALL));
                    asked.push((Ray { t_min: hit.t.next_down(), ..ray }, RayFilter::ALL));
                }
            }
            println!("2^{exponent}, large {large}: {} hits", (asked.len() - 100) / 2);
            check(&structures, &asked, &[48, 1]);
        }
    }
}

#[test]
fn rays_in_the_plane_of_a_cut_triangle_hit_no_more_and_no_less() {
    for seed in 0..40 {
        let mut random = Random(seed);
        let world = World::new(primitives(Kind::OnPlanes, 100, &mut random).0, vec![]);
        let exhaustive = Exhaustive::new(&world.geometry());
        let options = BuildOptions {
            max_leaf_primitives: 1,
            traversal_cost: 0.0,
            ..BuildOptions::of(Builder::Spatial)
        };
        let bvh = Bvh::build(&world.geometry(), &options);
        for _ in 0..2000 {
            let axis = [vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, -1.0)][random.below(3)];
            let direction = (axis + random.direction() * 1e-7).normalize();
            let ray = ray(on_planes(&mut random), direction);
            let expected = Fused(exhaustive.tracer(IgnoreWork)).closest_hit(&ray, &RayFilter::ALL);
            let hit = Fused(bvh.tracer(IgnoreWork)).closest_hit(&ray, &RayFilter::ALL);
            assert_eq!(hit, expected, "seed {seed}: {ray:?}");
            assert!(
                expected.is_miss() || (0.0..=1.0).contains(&expected.u) && (0.0..=1.0).contains(&expected.v)
            );
        }
    }
}
