//! Ambient occlusion, baked into the vertices of a mesh: how much of the sky each one sees.
//!
//! `cargo run --release -p eosphor-accel --example occlusion`

use eosphor_accel::{
    BatchTracer, Bvh8, Coherence, Filters, Quality, Ray, RayFilter, Scene, SceneError, Vec3,
    indexed, vec3,
};
use std::f32::consts::TAU;

/// Vertices along a side.
const GRID: u32 = 65;
/// Rays from each vertex.
const RAYS: usize = 64;

fn main() -> Result<(), SceneError> {
    // A landscape of hills and hollows.
    let height = |x: f32, z: f32| 0.6 * (3.0 * x).sin() * (2.0 * z).cos();
    let at = |k: u32| 6.0 * (k as f32 / (GRID - 1) as f32) - 3.0;
    let vertex = |k: u32| vec3(at(k % GRID), height(at(k % GRID), at(k / GRID)), at(k / GRID));
    let vertices: Vec<Vec3> = (0..GRID * GRID).map(vertex).collect();
    let faces: Vec<[u32; 3]> = (0..(GRID - 1) * (GRID - 1))
        .flat_map(|cell| {
            let a = cell / (GRID - 1) * GRID + cell % (GRID - 1);
            [[a, a + GRID, a + 1], [a + 1, a + GRID, a + GRID + 1]]
        })
        .collect();
    let triangles = indexed(&vertices, &faces)?;

    // Baking traces many rays, so a hierarchy that takes longer to build pays.
    let scene = Scene::new(&triangles, &[])?;
    let bvh = Bvh8::build(&scene.geometry(), &Quality::High.options());
    let tracer = bvh.tracer();

    // Rays start a little off the surface, and far hills do not count. The directions are spread evenly over the upper
    // half of a sphere (a Fibonacci lattice), the same for each vertex.
    let direction = |k: usize| {
        let (up, turn) = ((k as f32 + 0.5) / RAYS as f32, k as f32 * 0.618_034 * TAU);
        let side = (1.0 - up * up).sqrt();
        vec3(side * turn.cos(), up, side * turn.sin())
    };
    let (off, reach) = (1e-3, 4.0);
    let ray = |v: &Vec3, k: usize| Ray { t_min: off, t_max: reach, ..Ray::new(*v, direction(k)) };
    let rays: Vec<Ray> = vertices.iter().flat_map(|v| (0..RAYS).map(move |k| ray(v, k))).collect();

    // Whether there is anything in the way: cheaper than what is first.
    let mut hidden = vec![false; rays.len()];
    let everything = Filters::Shared(&RayFilter::ALL);
    tracer.occluded_rays(&rays, everything, Coherence::Incoherent, &mut hidden);
    let sky: Vec<f32> =
        hidden.chunks(RAYS).map(|h| h.iter().filter(|&&h| !h).count() as f32 / RAYS as f32).collect();

    for row in sky.chunks(GRID as usize).step_by(2) {
        let shade = |s: &f32| char::from(b"@%#*+=-:. "[(s * 9.0).round() as usize]);
        println!("{}", row.iter().map(shade).collect::<String>());
    }
    let mean = sky.iter().sum::<f32>() / sky.len() as f32;
    println!("{} rays; a vertex sees {:.0} % of the sky on average", rays.len(), 100.0 * mean);
    Ok(())
}
