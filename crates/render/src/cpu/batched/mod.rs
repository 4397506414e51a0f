//! The scheduler of the CPU: a tile's rays in batches.
//!
//! Rays of one kind are traced together, because packets and streams of rays are what is fast: the camera rays of small
//! blocks of pixels, the shadow rays of many points towards one light, the rays that go on. It calls the stages of
//! `core`, in another order than `whitted::radiance` does; sums are exact, so the bits are the same.
//!
//! ```text
//! camera rays, or pending ones -> closest hits -> points: local terms ─┬─> light by light: shadow rays -> sums
//!                     ^                                                └─> rays that go on, and points with many
//!                     └────────────── taken from the top ────────────────────────────┘
//! ```
//!
//! Rays that go on wait on a stack ([`pending`]). Points with many glossy rays wait there themselves and give their rays when a
//! batch takes them, so that a point with a thousand takes the room of one. Memory is bounded: a ray of a batch leaves one such
//! point, or two rays (mirrored and through glass), or one (through a hole), and a batch takes what came last first; so the
//! points that wait at one time are at most [`BATCH`] for each bounce of the depth limit, and twice that for the camera (what
//! lies behind a hole takes the place of its own point), or so many pairs of rays. That is 1 MiB a bounce.

mod camera;
mod lit;
mod paths;
mod pending;
mod points;
mod shadows;
mod triangle_order;

use super::dispatch::TileJob;
use super::tile::Tile;
pub(super) use camera::CameraRays;
use eosphor_accel::{BatchTracer, Coherence, Filters};
use eosphor_core::integrator::whitted::{LampLobe, depth_limit, local_radiance};
use eosphor_core::integrator::{PathRay, RayCounts, RayKind, weight_at};
use eosphor_core::math::Vec3;
use eosphor_core::ray::{Hit, Ray, RayFilter};
use eosphor_core::shading::SurfacePoint;
use eosphor_core::sums::ExactSum;
use eosphor_core::view::SceneView;
use lit::{LANES, LitPoints};
use paths::PathBatch;
pub(super) use paths::trace_paths;
use pending::Pending;
use points::{Arrival, Arrivals, Points};
use shadows::Shadows;
use std::sync::atomic::Ordering;

/// Rays traced at a time, at most.
const BATCH: usize = 2048;

/// What hits name is asked of memory so many hits before it is read.
const AHEAD: usize = 32;

const NO_RAY: Ray = Ray { origin: Vec3::ZERO, t_min: 0.0, direction: Vec3::ZERO, t_max: 0.0 };

/// A ray and the sample that it is part of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    pub(super) ray: PathRay,
    x: u32,
    y: u32,
    sample: u32,
}

/// What the scheduler works in. It is used again for tile after tile, so that none asks the system for memory.
#[derive(Default)]
pub(super) struct Workspace {
    paths: Vec<Path>,
    rays: Vec<Ray>,
    filters: Vec<RayFilter>,
    hits: Vec<Hit>,
    arrivals: Arrivals,
    pending: Pending,
    lit: LitPoints,
    shadows: Shadows,
    path_batch: PathBatch,
    /// Those of the tile's pixels, row after row.
    pub(super) sums: Vec<ExactSum>,
}

/// The rays of a tile, whose sums are in the workspace then; `None` where it was given up.
#[inline(always)]
pub(super) fn trace_tile<T: BatchTracer>(
    view: &SceneView,
    tracer: &T,
    job: &TileJob,
    work: &mut Workspace,
) -> Option<RayCounts> {
    let (tile, cancel) = (job.tile, job.cancel);
    let mut counts = RayCounts::default();
    let mut camera = CameraRays::new(tile, job.samples.clone());
    work.pending.clear();
    work.sums.clear();
    work.sums.resize(tile.pixels() as usize, ExactSum::default());
    loop {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        work.paths.clear();
        let waiting = work.pending.len();
        // While few rays wait there are camera rays to make them more.
        let from_camera = waiting < BATCH && camera.take(view, BATCH, |path| work.paths.push(path));
        if !from_camera {
            work.pending.take(view, BATCH, &mut work.paths);
        }
        if work.paths.is_empty() {
            if waiting == 0 {
                break;
            }
            // The points that waited had no ray to give, but there may be camera rays left.
            continue;
        }
        work.find_hits(view, tracer, from_camera);
        work.shade(view, tile, &mut counts);
        if !work.lit.is_empty() {
            work.shadows.add_light(view, tracer, &mut work.lit, &mut counts.shadow, cancel)?;
            work.lit.add_to(&mut work.sums);
        }
    }
    Some(counts)
}

impl Workspace {
    /// Closest hits. Rays of mirrors and clear glass go on in the order of the triangles that they left, so they mostly go together
    /// (in a conference room of mirrors, 0.93 of the time).
    #[inline(always)]
    fn find_hits<T: BatchTracer>(&mut self, view: &SceneView, tracer: &T, from_camera: bool) {
        let is_spread = self.paths.iter().any(|path| path.ray.kind == RayKind::Glossy);
        let coherence = if is_spread { Coherence::Auto } else { Coherence::Coherent };
        let count = self.paths.len();
        // Written over below; nothing is written where the length stays the same.
        self.rays.resize(count, NO_RAY);
        self.filters.resize(count, RayFilter::ALL);
        self.hits.resize(count, Hit::miss(f32::INFINITY));
        for (path, ray) in self.paths.iter().zip(&mut self.rays) {
            *ray = path.ray.ray();
        }
        if from_camera {
            // Camera rays: all leave out the same.
            let filter = self.paths[0].ray.filter(view.settings);
            tracer.closest_hits(&self.rays, Filters::Shared(&filter), coherence, &mut self.hits);
        } else {
            for (path, filter) in self.paths.iter().zip(&mut self.filters) {
                *filter = path.ray.filter(view.settings);
            }
            tracer.closest_hits(&self.rays, Filters::Each(&self.filters), coherence, &mut self.hits);
        }
    }

    /// What the rays found: background and local terms, points to be lit, points whose rays go on.
    #[inline(always)]
    fn shade(&mut self, view: &SceneView, tile: Tile, counts: &mut RayCounts) {
        self.lit.clear();
        self.arrivals.clear();
        for hit in self.hits.iter().take(AHEAD) {
            view.prefetch_triangle(hit);
        }
        for (k, (path, hit)) in self.paths.iter().zip(&self.hits).enumerate() {
            if let Some(later) = self.hits.get(k + AHEAD) {
                view.prefetch_triangle(later);
            }
            counts.count(path.ray.kind);
            if hit.is_miss() {
                let pixel = tile.index_of(path.x, path.y);
                self.sums[pixel].add(path.ray.weight * view.settings.background);
            } else {
                self.arrivals.push(view, k, hit);
            }
        }
        // Camera rays lie side by side as they are.
        if self.paths.first().is_some_and(|path| path.ray.depth > 0) {
            self.arrivals.sort_triangles(view);
        }
        let max_depth = depth_limit(view.settings);
        let Workspace { paths, rays, hits, arrivals, lit, pending, sums, .. } = self;
        for chunk in arrivals.of_kind.iter().flat_map(|arrivals| arrivals.chunks(LANES)) {
            let points = Points::of(view, chunk, rays, hits);
            let found_by = |arrival: &Arrival| {
                let k = arrival.ray as usize;
                (&paths[k], &rays[k], &hits[k])
            };
            if let Some(lanes) = points.alike(chunk) {
                let (path, ray, hit) = found_by(&chunk[0]);
                let point = points.get(view, (0, &chunk[0]), ray, hit);
                if gives_the_same(view, &point) {
                    // As below, for all of them together.
                    let local = local_radiance(view, &point, &path.ray, hit.t);
                    let takes_light = LitPoints::takes(view, &point, &LampLobe::NONE);
                    let mut block = takes_light.then(|| lit.push_alike(lanes, chunk.len(), &point, local));
                    let goes_on = point.material_values.reflects() | point.material_values.transmits();
                    for (lane, arrival) in chunk.iter().enumerate() {
                        let (path, ray, hit) = found_by(arrival);
                        let pixel = tile.index_of(path.x, path.y);
                        match &mut block {
                            Some(block) => block.set_path(lane, hit.id, path, pixel, path.ray.weight),
                            None => sums[pixel].add(path.ray.weight * local),
                        }
                        if goes_on {
                            let point = points.get(view, (lane, arrival), ray, hit);
                            pending.push(view, &point, path, hit.t, max_depth);
                        }
                    }
                    continue;
                }
            }
            for (lane, arrival) in chunk.iter().enumerate() {
                let (path, ray, hit) = found_by(arrival);
                let pixel = tile.index_of(path.x, path.y);
                let point = points.get(view, (lane, arrival), ray, hit);
                let ray = PathRay { weight: weight_at(view, &point, &path.ray, hit.t), ..path.ray };
                if point.coverage > 0.0 {
                    let found = local_radiance(view, &point, &ray, hit.t);
                    let shown = ray.weight * point.coverage;
                    let lobe = LampLobe::new(view, &point, &ray, max_depth);
                    if LitPoints::takes(view, &point, &lobe) {
                        lit.push((&point, &lobe), path, pixel, shown, found);
                    } else {
                        sums[pixel].add(shown * found);
                    }
                }
                pending.push(view, &point, &Path { ray, ..*path }, hit.t, max_depth);
            }
        }
    }
}

/// Whether all points of this one's material give the same by themselves, wherever and from whichever side paths met them, and
/// are lit alike: it does not shine, has no lobes and no holes, and no body behind it takes light away.
#[inline(always)]
fn gives_the_same(view: &SceneView, point: &SurfacePoint) -> bool {
    let (values, material) = (&point.material_values, &view.materials[point.material as usize]);
    let has_lobes = (values.lobe_rays(0) > 0) | (values.lobe_rays(1) > 0);
    let has_holes = (point.coverage < 1.0) | material.single_sided;
    let shines = values.emission.max_component() > 0.0;
    let takes_away = material.attenuation.max_component() > 0.0;
    view.settings.lighting_model.is_lit() & !has_lobes & !has_holes & !shines & !takes_away
}
