//! How much work the camera rays of a scene are to a hierarchy, and how fast it answers them.

use super::batched::CameraRays;
use super::queries::{with_batches, with_counting};
use super::tile::Tiling;
use super::{CpuBackend, Watch};
use crate::{Hierarchy, Region};
use eosphor_accel::{Coherence, Filters};
use eosphor_core::ray::{Hit, Ray, RayFilter};
use eosphor_core::sampling::{cosine_lobe, orthonormal_basis, point_2d};
use eosphor_core::shading::SurfacePoint;
use eosphor_core::view::SceneView;
use eosphor_scene::SceneData;
use serde::Serialize;
use std::time::{Duration, Instant};

/// Side of the tiles whose rays are traced together.
const TILE: u32 = 32;

/// Closest hits of camera rays, and of rays that leave what those hit in random directions, on one thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct CameraSpeed {
    /// How many rays were traced.
    pub rays: u64,
    /// Million rays a second, traced as a render traces them.
    pub mrays_per_second: f64,
    /// Nodes whose box was tested, mean over the rays, by the scalar traversal.
    pub nodes_a_ray: f64,
    /// Primitive tests, mean over the rays, by the scalar traversal.
    pub tests_a_ray: f64,
    /// Million rays a second that leave the points hit by camera rays, one from each, distributed as diffuse light is.
    pub diffuse_mrays_per_second: f64,
}

impl CpuBackend {
    /// Traces the first camera ray of pixels from all over the picture until all are done or this much time has gone by.
    /// Only speed depends on the machine.
    pub fn camera_speed(&self, scene: &SceneData, hierarchy: &Hierarchy, time: Duration) -> CameraSpeed {
        let view = scene.view();
        let settings = view.settings;
        let tiling = Tiling::new(Region::whole((settings.width, settings.height)), TILE);
        let start = Instant::now();
        let (count, mut camera, mut diffuse) = (Watch::default(), Clock::default(), Clock::default());
        let mut paths = Vec::new();
        for number in spread(tiling.len()) {
            paths.clear();
            let tile = tiling.tile(number);
            CameraRays::new(tile, 0..1).take(&view, (TILE * TILE) as usize, |path| paths.push(path));
            let rays: Vec<Ray> = paths.iter().map(|path| path.ray.ray()).collect();
            let filters: Vec<RayFilter> = paths.iter().map(|path| path.ray.filter(settings)).collect();
            let mut hits = vec![Hit::miss(f32::INFINITY); rays.len()];
            let coherent = Coherence::Coherent;
            with_batches(hierarchy, hierarchy, self.simd, |queries| {
                let each = Filters::Each(&filters);
                camera.time(rays.len(), || queries.closest_hits(&rays, each, coherent, &mut hits));
            });
            let (next_rays, next_filters) = diffuse_rays(&view, &rays, &filters, &hits);
            with_batches(hierarchy, hierarchy, self.simd, |queries| {
                let each = Filters::Each(&next_filters);
                let mut hits = vec![Hit::miss(f32::INFINITY); next_rays.len()];
                let how = Coherence::Incoherent;
                diffuse.time(next_rays.len(), || queries.closest_hits(&next_rays, each, how, &mut hits));
            });
            with_counting(hierarchy, hierarchy, &count, self.simd, |queries| {
                queries.closest_hits(&rays, Filters::Each(&filters), coherent, &mut hits);
            });
            if start.elapsed() > time {
                break;
            }
        }
        let mean = |number: u64| number as f64 / camera.rays.max(1) as f64;
        CameraSpeed {
            rays: camera.rays,
            mrays_per_second: camera.mrays_per_second(),
            nodes_a_ray: mean(count.nodes.get()),
            tests_a_ray: mean(count.primitives.get()),
            diffuse_mrays_per_second: diffuse.mrays_per_second(),
        }
    }
}

/// Rays and the time that they took.
#[derive(Default)]
struct Clock {
    rays: u64,
    seconds: f64,
}

impl Clock {
    fn time(&mut self, rays: usize, trace: impl FnOnce()) {
        let begin = Instant::now();
        trace();
        self.seconds += begin.elapsed().as_secs_f64();
        self.rays += rays as u64;
    }

    fn mrays_per_second(&self) -> f64 {
        if self.seconds > 0.0 { self.rays as f64 * 1e-6 / self.seconds } else { 0.0 }
    }
}

/// A ray from each hit, distributed by the cosine to the normal.
fn diffuse_rays(
    view: &SceneView,
    rays: &[Ray],
    filters: &[RayFilter],
    hits: &[Hit],
) -> (Vec<Ray>, Vec<RayFilter>) {
    let found = rays.iter().zip(filters).zip(hits).filter(|(_, hit)| !hit.is_miss());
    let leaving = (0..).zip(found).map(|(number, ((ray, filter), hit))| {
        let point: SurfacePoint = SurfacePoint::new(view, ray, hit);
        let normal = point.geometric_normal;
        let (x, y) = orthonormal_basis(normal);
        let local = cosine_lobe(1.0, point_2d(number, 1));
        let direction = (x * local.x).plus_scaled(y, local.y).plus_scaled(normal, local.z);
        (Ray::new(point.offset_origin(direction), direction), RayFilter { start: hit.id, ..*filter })
    });
    leaving.unzip()
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
