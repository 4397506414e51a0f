//! Why the triangle test is what it is: speed and missed edge rays of three candidates.
//!
//! `RUSTFLAGS=-Ctarget-cpu=x86-64-v3 cargo run --release -p eosphor-accel --example triangle_tests`
//!
//! Candidates: Möller and Trumbore's formula with exact comparisons, the same with edges moved out by the rounding error
//! (the one in use, first step), and the shear test of Woop, Benthin and Wald (2013) without its fallback in double
//! precision. Missed are rays aimed at a point of an edge that two triangles share, both facing the ray's way, that hit
//! neither.

use eosphor_core::intersect::{LocalRay, PackedTriangle, intersect_triangle, longest_edge_last};
use eosphor_core::math::{Vec3, elementary, vec3};
use eosphor_core::ray::Ray;
use eosphor_core::sampling::mix;
use std::f32::consts::{PI, TAU};
use std::hint::black_box;
use std::time::Instant;

const LANES: usize = 16;

fn main() {
    let grid = 160;
    let triangles = bumpy_sphere(grid);
    let packed: Vec<PackedTriangle> = (0..)
        .zip(&triangles)
        .map(|(i, t)| {
            let mut t = *t;
            let k = longest_edge_last(&t);
            t.rotate_left(k);
            PackedTriangle::new(t, i)
        })
        .collect();
    edge_rays(&triangles, &packed);
    speed(&triangles, &packed);
}

fn extent(triangles: &[[Vec3; 3]]) -> f32 {
    triangles.iter().flatten().fold(0.0, |e: f32, v| e.max(v.abs().max_component()))
}

/// Two triangles a cell, one after the other: they share the cell's diagonal.
fn bumpy_sphere(grid: u32) -> Vec<[Vec3; 3]> {
    let point = |i: u32, j: u32| {
        let (a, b) = (i as f32 / grid as f32 * TAU, (j as f32 + 0.5) / (grid + 1) as f32 * PI);
        let radius = 1.0 + 0.01 * (mix(i % grid * 7919 + j) % 16) as f32;
        let (ring, height) = (elementary::sin(b), elementary::cos(b));
        vec3(elementary::cos(a) * ring, height, elementary::sin(a) * ring) * radius
    };
    let cell = |k: u32| {
        let (i, j) = (k % grid, k / grid);
        let corners = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
        [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    };
    (0..grid * grid).flat_map(cell).collect()
}

/// Numbers from 0 to 1.
fn randoms() -> impl FnMut() -> f32 {
    let mut counter = 0u32;
    move || {
        counter += 1;
        (mix(counter) >> 8) as f32 / 16_777_216.0
    }
}

fn edge_rays(triangles: &[[Vec3; 3]], packed: &[PackedTriangle]) {
    let extent = extent(triangles);
    let mut random = randoms();
    let (mut rays, mut missed) = (0u32, [0u32; 3]);
    for (pair, packed) in triangles.chunks_exact(2).zip(packed.chunks_exact(2)) {
        for _ in 0..32 {
            let target = pair[0][0].plus_scaled(pair[0][2] - pair[0][0], random());
            let away = vec3(random() - 0.5, random() - 0.5, random() - 0.5).normalize();
            let origin = target.plus_scaled(away, -0.5 - 10.0 * random());
            let direction = (target - origin).normalize();
            if packed[0].normal().dot(direction) * packed[1].normal().dot(direction) <= 0.0 {
                continue;
            }
            rays += 1;
            let ray = Ray::new(origin, direction);
            let shear = Shear::new(origin, direction);
            missed[0] += !packed.iter().any(|t| exact(origin, direction, t)) as u32;
            missed[1] += !packed.iter().any(|t| intersect_triangle(t, &ray, None, extent).meets) as u32;
            missed[2] += !pair.iter().any(|t| shear.test(shear.permuted(t))) as u32;
        }
    }
    println!("{rays} edge rays, missed: exact {}, widened {}, shear {}", missed[0], missed[1], missed[2]);
}

/// Nanoseconds a test, the best of many passes: one ray by many triangles, and 16 rays by one triangle.
fn speed(triangles: &[[Vec3; 3]], packed: &[PackedTriangle]) {
    let extent = extent(triangles);
    let mut random = randoms();
    let origin = vec3(3.0, 1.0, 0.2);
    let directions: [Vec3; LANES] =
        std::array::from_fn(|_| (vec3(random() - 0.5, random() - 0.5, random() - 0.5) - origin).normalize());
    let rays = directions.map(|d| LocalRay::new(&Ray::new(origin, d), extent));
    let shears = directions.map(|d| Shear::new(origin, d));
    assert!(shears.iter().all(|s| s.axes == shears[0].axes), "a packet of one main axis");
    let row = |name: &str, single: f64, lanes: f64| {
        println!("{name:8} one ray {single:.2} ns, {LANES} rays {lanes:.2} ns")
    };

    let single = time(packed.len(), || {
        directions.iter().map(|d| packed.iter().filter(|t| exact(origin, *d, t)).count()).sum()
    });
    let lanes =
        time(packed.len(), || packed.iter().map(|t| count(|lane| exact(origin, directions[lane], t))).sum());
    row("exact", single, lanes);
    let widened = |ray: &LocalRay, t: &PackedTriangle| t.first_step(ray).may_meet;
    let single =
        time(packed.len(), || rays.iter().map(|r| packed.iter().filter(|t| widened(r, t)).count()).sum());
    // As in packets: what differs between the rays lies in arrays.
    let length = rays.map(|r| r.length);
    let ray = |lane: usize| LocalRay { direction: directions[lane], length: length[lane], ..rays[0] };
    let lanes = time(packed.len(), || packed.iter().map(|t| count(|lane| widened(&ray(lane), t))).sum());
    row("widened", single, lanes);
    let single = time(packed.len(), || {
        shears.iter().map(|s| triangles.iter().filter(|t| s.test(s.permuted(t))).count()).sum()
    });
    let (x, y) = (shears.map(|s| s.x), shears.map(|s| s.y));
    let lanes = time(packed.len(), || {
        let lane_test = |t: &[Vec3; 3]| {
            let permuted = shears[0].permuted(t);
            count(|lane| Shear { x: x[lane], y: y[lane], ..shears[0] }.test(permuted))
        };
        triangles.iter().map(lane_test).sum()
    });
    row("shear", single, lanes);
}

#[inline(always)]
fn count(mut test: impl FnMut(usize) -> bool) -> usize {
    let mut hits = [0u32; LANES];
    for lane in 0..LANES {
        hits[lane] = test(lane) as u32;
    }
    hits.iter().sum::<u32>() as usize
}

fn time(triangles: usize, mut pass: impl FnMut() -> usize) -> f64 {
    let best = (0..30).map(|_| {
        let start = Instant::now();
        black_box(pass());
        start.elapsed().as_secs_f64()
    });
    best.fold(f64::INFINITY, f64::min) / (triangles * LANES) as f64 * 1e9
}

/// Möller and Trumbore with exact comparisons.
#[inline(always)]
fn exact(origin: Vec3, direction: Vec3, t: &PackedTriangle) -> bool {
    let r = (t.v0 - origin).cross(direction);
    let determinant = t.normal().dot(direction);
    let sign = determinant.to_bits() & 0x8000_0000;
    let signed = |x: f32| f32::from_bits(x.to_bits() ^ sign);
    let (u, v) = (signed(r.dot(t.e2())), signed(-r.dot(t.e1())));
    (u >= 0.0) & (v >= 0.0) & (determinant.abs() - u - v >= 0.0)
}

/// A ray for the shear test.
#[derive(Clone, Copy)]
struct Shear {
    axes: [usize; 3],
    origin: [f32; 3],
    x: f32,
    y: f32,
}

impl Shear {
    fn new(origin: Vec3, direction: Vec3) -> Shear {
        let a = direction.abs();
        let main = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        let axes = [(main + 1) % 3, (main + 2) % 3, main];
        let (x, y) = (direction[axes[0]] / direction[main], direction[axes[1]] / direction[main]);
        Shear { axes, origin: axes.map(|k| origin[k]), x, y }
    }

    #[inline(always)]
    fn permuted(&self, t: &[Vec3; 3]) -> [[f32; 3]; 3] {
        t.map(|v| self.axes.map(|k| v[k]))
    }

    #[inline(always)]
    fn test(&self, t: [[f32; 3]; 3]) -> bool {
        let [a, b, c] = t.map(|v| {
            let z = v[2] - self.origin[2];
            [v[0] - self.origin[0] - self.x * z, v[1] - self.origin[1] - self.y * z]
        });
        // Products are not fused: only so has the edge seen from its other side exactly the opposite value.
        let edge = |p: [f32; 2], q: [f32; 2]| p[0] * q[1] - p[1] * q[0];
        let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
        let negative = (u < 0.0) | (v < 0.0) | (w < 0.0);
        let positive = (u > 0.0) | (v > 0.0) | (w > 0.0);
        !(negative & positive) & (u + v + w != 0.0)
    }
}
