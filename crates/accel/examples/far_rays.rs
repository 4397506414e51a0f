//! What rays cost by how far from a mesh they start: closest hit, any hit and next hit, one by one and in batches.
//!
//! `far_rays FILE.tris [RAYS] [REPEATS]`. The file is a count and 9 floats a triangle, little endian. A line a distance, from
//! 1 to 10^12 radii: nanoseconds of CPU time a ray, the best of the repeats, and after it how often that of 1 radius.

use eosphor_accel::{
    BatchTracer, Bvh8, Bvh8Tracer, Coherence, Filters, Hit, Quality, Ray, RayFilter, Scene, SimdLevel,
    Tracer, Vec3, vec3,
};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

/// Pseudo-random numbers of 0 to 1 (PCG-like steps; any will do).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

/// A ray from far away through a point: along an axis but for the tilt that single precision can say there, since an
/// origin far off the axes would not say where it is.
fn far_ray(random: &mut Random, low: Vec3, high: Vec3, distance: f64) -> Ray {
    let axis = (3.0 * random.unit()) as usize % 3;
    let sign = if random.unit() < 0.5 { 1.0 } else { -1.0 };
    let (mut origin, mut direction) = ([0.0f32; 3], [0.0f32; 3]);
    for k in 0..3 {
        let mut within = || low[k] + (high[k] - low[k]) * random.unit() as f32;
        if k == axis {
            (origin[k], direction[k]) = (sign * distance as f32, -sign);
        } else {
            origin[k] = within();
            direction[k] = ((within() - origin[k]) as f64 / distance) as f32;
        }
    }
    Ray::new(vec3(origin[0], origin[1], origin[2]), vec3(direction[0], direction[1], direction[2]))
}

fn best(repeats: usize, rays: usize, mut work: impl FnMut()) -> f64 {
    let run = |work: &mut dyn FnMut()| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64() * 1e9 / rays as f64
    };
    (0..repeats).map(|_| run(&mut work)).fold(f64::INFINITY, f64::min)
}

fn costs(tracer: &Bvh8Tracer, rays: &[Ray], repeats: usize) -> ([f64; 5], usize) {
    let filter = &RayFilter::ALL;
    let firsts: Vec<Hit> = rays.iter().map(|ray| tracer.closest_hit(ray, filter)).collect();
    let hits = firsts.iter().filter(|hit| !hit.is_miss()).count();
    let (mut found, mut hidden) = (firsts.clone(), vec![false; rays.len()]);
    let closest = best(repeats, rays.len(), || {
        for ray in rays {
            black_box(tracer.closest_hit(black_box(ray), filter));
        }
    });
    let any = best(repeats, rays.len(), || {
        for ray in rays {
            black_box(tracer.occluded(black_box(ray), filter));
        }
    });
    let next = best(repeats, rays.len(), || {
        for (ray, first) in rays.iter().zip(&firsts) {
            black_box(tracer.next_hit(black_box(ray), filter, first));
        }
    });
    let shared = Filters::Shared(filter);
    let closest_batch = best(repeats, rays.len(), || {
        tracer.closest_hits(rays, shared, Coherence::Auto, &mut found);
    });
    let any_batch = best(repeats, rays.len(), || {
        tracer.occluded_rays(rays, shared, Coherence::Auto, &mut hidden);
    });
    ([closest, any, next, closest_batch, any_batch], hits)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().ok_or("far_rays FILE.tris [RAYS] [REPEATS]")?;
    let rays: usize = arguments.next().map_or(Ok(100_000), |x| x.parse())?;
    let repeats: usize = arguments.next().map_or(Ok(5), |x| x.parse())?;
    let bytes = std::fs::read(&file).map_err(|e| format!("{file}: {e}"))?;
    let words: Vec<f32> = bytes
        .get(4..)
        .ok_or("the file is too short")?
        .chunks_exact(4)
        .map(|c| f32::from_le_bytes([c[0], c[1], c[2], c[3]]))
        .collect();
    let vertex = |v: &[f32]| vec3(v[0], v[1], v[2]);
    let triangles: Vec<[Vec3; 3]> =
        words.chunks_exact(9).map(|v| [vertex(v), vertex(&v[3..]), vertex(&v[6..])]).collect();
    let corners = || triangles.iter().flatten();
    let low = corners().fold(Vec3::splat(f32::INFINITY), |a, b| a.min(*b));
    let high = corners().fold(Vec3::splat(f32::NEG_INFINITY), |a, b| a.max(*b));
    let radius = 0.5 * (high - low).length() as f64;
    let scene = Scene::new(&triangles, &[])?;
    let bvh = Bvh8::build(&scene.geometry(), &Quality::Medium.options());
    let tracer = bvh.tracer();
    println!("{file}: {} triangles, {rays} rays, {:?}", triangles.len(), SimdLevel::best());
    println!("radii    hits  closest         any             next            closest, batch  any, batch");
    let mut near = None;
    for power in 0..=12 {
        let distance = radius * 10f64.powi(power) + if power == 0 { radius } else { 0.0 };
        let mut random = Random(power as u64);
        let rays: Vec<Ray> = (0..rays).map(|_| far_ray(&mut random, low, high, distance)).collect();
        let (costs, hits) = costs(&tracer, &rays, repeats);
        let near = near.get_or_insert(costs);
        let column = |k: usize| format!("{:8.1} {:5.2}", costs[k], costs[k] / near[k]);
        let columns: Vec<String> = (0..5).map(column).collect();
        println!("10^{power:<4} {:5.3} {}", hits as f64 / rays.len() as f64, columns.join("  "));
    }
    Ok(())
}
