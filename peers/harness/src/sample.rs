//! A small data folder, for tests: random triangles and rays, with hits found by trying all triangles, in double
//! precision.

use crate::data::SETS;
use crate::{MISS, Ray, Triangle};
use std::fs;
use std::io;
use std::path::Path;

/// Writes `triangles` triangles, and `rays` rays in each set, into a folder that is there.
pub fn write(folder: &Path, triangles: usize, rays: usize) -> io::Result<()> {
    let mut random = Random(1);
    let mesh: Vec<Triangle> = (0..triangles)
        .map(|_| {
            let centre = random.in_cube(1.0);
            [(); 3].map(|()| add(centre, random.in_cube(0.15)))
        })
        .collect();
    let words = mesh.as_flattened().as_flattened().iter().map(|x| x.to_bits());
    save(&folder.join("mesh.tris"), mesh.len(), words)?;
    for set in SETS {
        let rays: Vec<Ray> = (0..rays).map(|_| random.ray(set == "primary")).collect();
        let words = rays.iter().flat_map(|ray| {
            let Ray { origin: [x, y, z], t_min, direction: [dx, dy, dz], t_max } = *ray;
            [x, y, z, t_min, dx, dy, dz, t_max].map(f32::to_bits)
        });
        save(&folder.join(format!("{set}.rays")), rays.len(), words)?;
        let hits = rays.iter().flat_map(|ray| {
            let (t, triangle) = closest(&mesh, ray);
            [(t as f32).to_bits(), triangle]
        });
        save(&folder.join(format!("{set}.hits")), rays.len(), hits)?;
    }
    Ok(())
}

fn save(path: &Path, count: usize, words: impl Iterator<Item = u32>) -> io::Result<()> {
    let mut bytes = (count as u32).to_le_bytes().to_vec();
    bytes.extend(words.flat_map(u32::to_le_bytes));
    fs::write(path, bytes)
}

/// Distance and triangle; the distance of a miss is 0.
fn closest(mesh: &[Triangle], ray: &Ray) -> (f64, u32) {
    let mut best = (f64::from(ray.t_max), MISS);
    for (index, triangle) in mesh.iter().enumerate() {
        if let Some(t) = distance(triangle, ray).filter(|t| *t >= f64::from(ray.t_min) && *t < best.0) {
            best = (t, index as u32);
        }
    }
    if best.1 == MISS { (0.0, MISS) } else { best }
}

/// By the volumes that the ray's line spans with the three edges: of one sign where it goes through the triangle.
fn distance(triangle: &Triangle, ray: &Ray) -> Option<f64> {
    let (origin, direction) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
    let corners = triangle.map(|corner| sub(corner.map(f64::from), origin));
    let volumes = [0, 1, 2].map(|edge| dot(direction, cross(corners[edge], corners[(edge + 1) % 3])));
    if volumes.iter().any(|volume| *volume < 0.0) && volumes.iter().any(|volume| *volume > 0.0) {
        return None;
    }
    let normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
    let t = dot(normal, corners[0]) / dot(normal, direction);
    t.is_finite().then_some(t)
}

fn add(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The same numbers at each run.
struct Random(u64);

impl Random {
    /// From -1 to 1. SplitMix64.
    fn signed(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn in_cube(&mut self, size: f32) -> [f32; 3] {
        [(); 3].map(|()| size * self.signed())
    }

    /// From a camera's place outside without an end, or from anywhere, with both ends.
    fn ray(&mut self, is_primary: bool) -> Ray {
        let target = self.in_cube(1.0);
        let origin = if is_primary { [0.5, 0.7, 4.0] } else { self.in_cube(1.2) };
        let way = sub(target.map(f64::from), origin.map(f64::from));
        let length = dot(way, way).sqrt();
        let direction = way.map(|x| (x / length) as f32);
        match is_primary {
            true => Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY },
            false => Ray { origin, t_min: 0.1, direction, t_max: 1.5 },
        }
    }
}
