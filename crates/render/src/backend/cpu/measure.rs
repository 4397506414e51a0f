//! How much work the camera rays of a scene are to a hierarchy, and how fast it answers them.

use super::CpuBackend;
use super::batched::CameraRays;
use super::tile::Tiling;
use crate::Hierarchy;
use eosphor_accel::{Coherence, Filters};
use eosphor_core::hierarchy::CountWork;
use eosphor_core::ray::{Hit, Ray, RayFilter};
use eosphor_scene::SceneData;
use serde::Serialize;
use std::time::{Duration, Instant};

/// Side of the tiles whose rays are traced together.
const TILE: u32 = 32;

/// Closest hits of camera rays, on one thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct CameraSpeed {
    /// Rays traced.
    pub rays: u64,
    /// Million rays a second, traced as a render traces them.
    pub mrays_per_second: f64,
    /// Nodes whose box was tested, mean over the rays, by the scalar traversal.
    pub nodes_a_ray: f64,
    /// Primitive tests, mean over the rays, by the scalar traversal.
    pub tests_a_ray: f64,
}

impl CpuBackend {
    /// Traces the first camera ray of pixels from all over the picture until all are done or this much time has gone by.
    /// Only speed depends on the machine.
    pub fn camera_speed(&self, scene: &SceneData, hierarchy: &Hierarchy, time: Duration) -> CameraSpeed {
        let view = scene.view();
        let settings = view.settings;
        let tiling = Tiling::new(settings.width, 0..settings.height, TILE);
        let start = Instant::now();
        let (mut rays_traced, mut seconds, count) = (0, 0.0, CountWork::default());
        let mut paths = Vec::new();
        for number in spread(tiling.len()) {
            paths.clear();
            let tile = tiling.tile(number);
            CameraRays::new(tile, 1).take(&view, (TILE * TILE) as usize, &mut paths);
            let rays: Vec<Ray> = paths.iter().map(|path| path.ray.ray()).collect();
            let filters: Vec<RayFilter> = paths.iter().map(|path| path.ray.filter(settings)).collect();
            let mut hits = vec![Hit::miss(f32::INFINITY); rays.len()];
            let each = Filters::Each(&filters);
            hierarchy.with_batches(self.simd, |queries| {
                let begin = Instant::now();
                queries.closest_hits(&rays, each, Coherence::Coherent, &mut hits);
                seconds += begin.elapsed().as_secs_f64();
            });
            hierarchy.with_counting(&count, self.simd, |queries| {
                queries.closest_hits(&rays, each, Coherence::Coherent, &mut hits);
            });
            rays_traced += rays.len() as u64;
            if start.elapsed() > time {
                break;
            }
        }
        let mean = |number: u64| number as f64 / rays_traced.max(1) as f64;
        CameraSpeed {
            rays: rays_traced,
            mrays_per_second: if seconds > 0.0 { rays_traced as f64 * 1e-6 / seconds } else { 0.0 },
            nodes_a_ray: mean(count.nodes.get()),
            tests_a_ray: mean(count.primitives.get()),
        }
    }
}

/// All numbers below `count`, so that those that come early lie all over: steps of the golden ratio.
fn spread(count: u32) -> impl Iterator<Item = u32> {
    let gcd = |mut a: u64, mut b: u64| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let count = count as u64;
    let golden = ((count as f64 * 0.618_034) as u64).max(1);
    let step = (golden..).find(|&step| gcd(step, count) == 1).unwrap_or(1);
    (0..count).map(move |k| (k * step % count) as u32)
}

#[cfg(test)]
mod tests {
    use super::spread;

    #[test]
    fn every_number_once() {
        for count in [1, 2, 3, 10, 144, 2040] {
            let mut numbers: Vec<u32> = spread(count).collect();
            numbers.sort_unstable();
            assert!(numbers.into_iter().eq(0..count), "{count}");
        }
    }
}
