//! Rays from far find what they meet: 10^3 to 10^12 radii.

use crate::double::{Double, Shape};
use crate::random::{Random, rays};
use crate::shapes::{Closed, icosphere, torus};
use crate::vector::*;
use eosphor_accel::{BuildOptions, Bvh, Bvh8, Hit, IgnoreWork, Ray, RayFilter, Scene, Sphere, Tracer};
use rayon::prelude::*;

/// A ray from `radii` away that passes within 0.9 of 0: its numbers are single precision's, and its line is what they say.
fn far_ray(random: &mut Random, radii: f64) -> Ray {
    let passes = random.in_cube();
    let (axis, diagonal) = (random.below(3), random.below(4) == 0);
    let sign = if random.below(2) == 0 { 1.0 } else { -1.0 };
    // Diagonals of a face: two numbers are equal, and cancel at the mesh.
    let also = if diagonal { (axis + 1) % 3 } else { axis };
    let distance = (radii * (1.0 + random.unit())) as f32;
    let (mut origin, mut direction) = ([0.0f32; 3], [0.0f32; 3]);
    for i in 0..3 {
        if i == axis || i == also {
            (origin[i], direction[i]) = (sign as f32 * distance, -sign as f32);
        } else {
            // Where it starts beside the axis, of the mesh's size, and where it is when it comes there.
            origin[i] = random.in_cube()[0] as f32;
            direction[i] = ((0.9 * passes[i] - origin[i] as f64) / distance as f64) as f32;
        }
    }
    if diagonal {
        // Off the diagonal's own line, by what the distance leaves of a number.
        origin[axis] += passes[axis] as f32;
    }
    Ray::new(origin.into(), direction.into())
}

/// How many rays did not find what double precision finds: by closest hit, any hit, next hit; and how many hit anything.
fn lost(tracer: &impl Tracer, truth: &Double, random: &mut Random, radii: f64) -> [u64; 4] {
    let ray = far_ray(random, radii);
    let (o, d) = (double(ray.origin), double(ray.direction));
    let Some(met) = truth.closest(o, d, f64::INFINITY, None) else { return [0; 4] };
    let hit = tracer.closest_hit(&ray, &RayFilter::ALL);
    let near = (hit.t as f64 - met.t()).abs() <= 4.0 * f32::EPSILON as f64 * (met.t() + 1.0);
    let found = !hit.is_miss() && hit.id.primitive as usize == met.primitive && near;
    let first = tracer.next_hit(&ray, &RayFilter::ALL, &Hit::miss(f32::NEG_INFINITY));
    // All that follow, in order, until there is no more.
    let mut count = 0;
    let mut after = first;
    while !after.is_miss() && count < 100 {
        after = tracer.next_hit(&ray, &RayFilter::ALL, &after);
        count += 1;
    }
    // What is closed is left as often as it is entered.
    let chain = first.id == hit.id && first.t == hit.t && count % 2 == 0;
    [!found, !tracer.occluded(&ray, &RayFilter::ALL), !chain, true].map(u64::from)
}

struct World {
    name: &'static str,
    bvh: Bvh,
    bvh8: Bvh8,
    truth: Double,
}

impl World {
    fn new(name: &'static str, shape: Option<&Closed>, spheres: &[Sphere]) -> World {
        let triangles: Vec<_> = shape.iter().flat_map(|s| s.corners()).map(|t| t.map(single)).collect();
        let scene = Scene::new(&triangles, spheres).unwrap();
        let shapes = triangles.iter().map(|t| Shape::Triangle(t.map(double))).chain(
            spheres.iter().map(|s| Shape::Sphere { center: double(s.center), radius: s.radius as f64 }),
        );
        World {
            name,
            bvh: Bvh::build(&scene.geometry(), &BuildOptions::default()),
            bvh8: Bvh8::build(&scene.geometry(), &BuildOptions::default()),
            truth: Double::new(shapes.collect()),
        }
    }
}

#[test]
fn rays_from_far_find_what_they_meet() {
    let mut random = Random(3);
    let balls: Vec<Sphere> = (0..60)
        .map(|_| Sphere {
            center: single(scaled(random.in_cube(), 0.8)),
            radius: 0.05 + 0.1 * random.unit() as f32,
        })
        .collect();
    // Turned by odd angles: diagonal rays would lie in planes of its corners, and meet edges exactly.
    let turned = torus(64, 32).mapped(|[x, y, z]| {
        let (x, y) = (0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y);
        [x, (5.0 * y - 12.0 * z) / 13.0, (12.0 * y + 5.0 * z) / 13.0]
    });
    let worlds = [
        World::new("icosphere", Some(&icosphere(3)), &[]),
        World::new("torus", Some(&turned), &[]),
        World::new("spheres", None, &balls),
    ];
    let mut failed = Vec::new();
    for world in &worlds {
        for exponent in (0..=12).step_by(3).chain([4, 5, 7]) {
            let radii = 10f64.powi(exponent);
            let blocks = (rays(60_000) / 24).div_ceil(512);
            let run = |block: u64| {
                let mut random = Random(block.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ exponent as u64);
                let mut sums = [[0; 4]; 2];
                for _ in 0..256 {
                    let one = lost(&world.bvh.tracer(IgnoreWork), &world.truth, &mut random, radii);
                    let other = lost(&world.bvh8.tracer(), &world.truth, &mut random, radii);
                    sums = plus(sums, [one, other]);
                }
                sums
            };
            let found = (0..blocks).into_par_iter().map(run).reduce(Default::default, plus);
            for (name, [closest, any, next, hits]) in [("bvh", found[0]), ("bvh8", found[1])] {
                println!(
                    "{}, {name}, 1e{exponent}: of {hits} {closest} lost, {any} not occluded, {next} not next",
                    world.name
                );
                assert!(hits > 50 * blocks);
                if closest.max(any).max(next) * 10_000 > hits {
                    failed.push(format!(
                        "{} {name} 1e{exponent}: {closest}, {any}, {next} of {hits}",
                        world.name
                    ));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

fn plus(a: [[u64; 4]; 2], b: [[u64; 4]; 2]) -> [[u64; 4]; 2] {
    std::array::from_fn(|k| std::array::from_fn(|i| a[k][i] + b[k][i]))
}
