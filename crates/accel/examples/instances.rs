//! One mesh in many places, and one of them moves: the hierarchy is refitted instead of built again.
//!
//! `cargo run --release -p eosphor-accel --example instances`

use eosphor_accel::{Affine, BuildOptions, Bvh8, Ray, RayFilter, Scene, Sphere, Tracer, vec3};
use std::error::Error;
use std::time::Instant;

/// Places along a side.
const SIDE: u32 = 100;

/// A map that scales evenly, then moves.
fn scaled_and_moved(scale: f32, x: f32, y: f32, z: f32) -> Affine {
    Affine {
        columns: [vec3(scale, 0.0, 0.0), vec3(0.0, scale, 0.0), vec3(0.0, 0.0, scale)],
        translation: vec3(x, y, z),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // A floor is the world: what is not placed. The mesh is a tree: a ball on a stem of two triangles.
    let size = SIDE as f32;
    let floor = [vec3(0.0, 0.0, 0.0), vec3(0.0, 0.0, size), vec3(size, 0.0, 0.0)];
    let stem = |x: f32, z: f32| [vec3(-x, 0.0, -z), vec3(x, 0.0, z), vec3(0.0, 1.0, 0.0)];
    let crown = Sphere { center: vec3(0.0, 1.0, 0.0), radius: 0.3 };
    let mut scene = Scene::new(&[floor], &[])?;
    let tree = scene.mesh(&[stem(0.1, 0.0), stem(0.0, 0.1)], &[crown])?;
    for k in 0..SIDE * SIDE {
        let (x, z) = ((k % SIDE) as f32, (k / SIDE) as f32);
        scene.place(tree, scaled_and_moved(0.5 + (k % 7) as f32 * 0.1, x, 0.0, z))?;
    }

    let start = Instant::now();
    let mut bvh = Bvh8::build(&scene.geometry(), &BuildOptions::default());
    println!("built over {} trees in {:.2} ms", SIDE * SIDE, start.elapsed().as_secs_f64() * 1e3);

    // Looking along a row, just above where the smaller crowns end. Hits say which instance: from 1, as they were placed.
    let ray = Ray::new(vec3(-5.0, 1.3, 50.0), vec3(1.0, 0.0, 0.0));
    let hit = bvh.tracer().closest_hit(&ray, &RayFilter::ALL);
    println!("the ray meets tree {} at t = {:.3}", hit.id.instance, hit.t);

    // The tree moves out of the way, step by step.
    let start = Instant::now();
    for step in 1..=10 {
        scene.replace(hit.id.instance, scaled_and_moved(1.0, 0.0, -0.2 * step as f32, 50.5))?;
        bvh.refit(&scene.geometry())?;
    }
    println!("refitted ten times in {:.2} ms", start.elapsed().as_secs_f64() * 1e3);
    let next = bvh.tracer().closest_hit(&ray, &RayFilter::ALL);
    println!("now it meets tree {} at t = {:.3}", next.id.instance, next.t);
    Ok(())
}
