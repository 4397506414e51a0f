//! Rays to measure queries with, by the recipe that GPU ray tracers were compared with (`ray_sets.h` of the peers'
//! harness): camera rays, a bounce from each of their hits, and the bounces in random order.

use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::{Hit, Ray};
use eosphor_scene::SceneData;

/// Pixels of a tile, whose rays follow each other: a warp's.
const TILE: [u32; 2] = [8, 4];

/// What stands for infinity.
const FAR: f32 = 1e30;

/// How far above what they leave bounces start, in world units.
const ABOVE: f32 = 1e-4;

/// Rays to measure queries with.
#[derive(Clone, Debug)]
pub struct RaySets {
    /// Camera rays through the middle of every pixel, in tiles of 8 × 4.
    pub primary: Vec<Ray>,
    /// One ray from each triangle that primary rays hit, distributed by the cosine to its normal.
    pub bounce: Vec<Ray>,
    /// The rays of [`RaySets::bounce`] in random order.
    pub shuffled: Vec<Ray>,
}

impl RaySets {
    /// Makes the sets for the scene's camera, as a pin-hole. `trace` finds the closest hit of each ray, in the order of the
    /// rays.
    pub fn new(scene: &SceneData, trace: impl FnOnce(&[Ray]) -> Vec<Hit>) -> RaySets {
        let primary = camera_rays(scene);
        let hits = trace(&primary);
        let bounce: Vec<Ray> = (0..)
            .zip(primary.iter().zip(&hits))
            .filter_map(|(k, (ray, hit))| bounce(scene, k, ray, hit))
            .collect();
        let mut shuffled = bounce.clone();
        for i in (2..=shuffled.len()).rev() {
            shuffled.swap(i - 1, pcg(i as u32) as usize % i);
        }
        RaySets { primary, bounce, shuffled }
    }
}

fn camera_rays(scene: &SceneData) -> Vec<Ray> {
    let view = scene.view();
    let (camera, width, height) = (view.camera, view.settings.width, view.settings.height);
    let mut rays = Vec::with_capacity(width as usize * height as usize);
    for tile_y in (0..height).step_by(TILE[1] as usize) {
        for tile_x in (0..width).step_by(TILE[0] as usize) {
            for y in tile_y..(tile_y + TILE[1]).min(height) {
                for x in tile_x..(tile_x + TILE[0]).min(width) {
                    let a = ((x as f32 + 0.5) / width as f32 * 2.0 - 1.0) * camera.half_width;
                    let b = (1.0 - (y as f32 + 0.5) / height as f32 * 2.0) * camera.half_height;
                    let direction = camera.forward + camera.right * a + camera.up * b;
                    let direction = direction * (1.0 / direction.length());
                    rays.push(Ray { origin: camera.eye, t_min: 0.0, direction, t_max: FAR });
                }
            }
        }
    }
    rays
}

/// What leaves the point that a ray hit; `None` where it hit no triangle of the world.
fn bounce(scene: &SceneData, number: u32, ray: &Ray, hit: &Hit) -> Option<Ray> {
    if hit.is_miss() || hit.id.instance != 0 {
        return None;
    }
    let [a, b, c] = *scene.triangles.get(hit.id.primitive as usize)?;
    let normal = (b - a).cross(c - a);
    let length = normal.length();
    if length.is_nan() || length <= 0.0 {
        return None;
    }
    let normal = normal * if normal.dot(ray.direction) > 0.0 { -1.0 / length } else { 1.0 / length };
    let z = 1.0 - 2.0 * random(2 * number);
    let angle = std::f32::consts::TAU * random(2 * number + 1);
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let direction = normal + vec3(radius * angle.cos(), radius * angle.sin(), z);
    let length = direction.length();
    let direction = if length < 1e-4 { normal } else { direction * (1.0 / length) };
    // No component is 0: the peers would divide by it.
    let not_zero = |x: f32| if x == 0.0 { 1e-20 } else { x };
    let direction = vec3(not_zero(direction.x), not_zero(direction.y), not_zero(direction.z));
    let origin: Vec3 = ray.origin + ray.direction * hit.t + normal * ABOVE;
    Some(Ray { origin, t_min: 0.0, direction, t_max: FAR })
}

/// PCG hash (Jarzynski and Olano 2020).
fn pcg(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// In [0, 1).
fn random(number: u32) -> f32 {
    (pcg(number) >> 8) as f32 * (1.0 / 16_777_216.0)
}
