//! Path tracing: some thousand paths, surface by surface.
//!
//! ```text
//! camera rays -> closest hits -> bounce of each ─┬─> shadow rays -> sums
//!                     ^                          └─> rays that go on
//!                     └──────────────────────────────────┘
//! ```

use super::super::dispatch::TileJob;
use super::{AHEAD, CameraRays, NO_RAY, Path, Workspace};
use eosphor_accel::{BatchTracer, Coherence, Filters};
use eosphor_core::integrator::path::{
    Bounce, BounceLanes, LightRequest, NumberLanes, PathState, bounce_lanes, bounce_matte, is_matte_triangle,
    surroundings_lanes, through,
};
use eosphor_core::integrator::{RayCounts, pixel_key};
use eosphor_core::math::Vec3;
use eosphor_core::ray::{Hit, Ray, RayFilter};
use eosphor_core::sums::ExactSum;
use eosphor_core::view::SceneView;
use std::sync::atomic::Ordering;

/// A path and the sample that it is.
#[derive(Clone, Copy, Debug)]
struct PlacedPath {
    state: PathState,
    /// Its random numbers are those of this pixel and sample.
    pixel_key: u32,
    sample: u32,
    /// Of the tile.
    pixel: u32,
}

/// A light that a path asks for.
#[derive(Clone, Copy, Debug)]
struct PlacedRequest {
    contribution: Vec3,
    pixel: u32,
}

/// Paths whose random numbers are computed together: as many as AVX-512 has lanes.
const LANES: usize = 16;

/// Paths on their way at a time, at most: what they and the scene take stays in the second cache.
const BATCH: usize = 1024;

/// The same in scenes of so few triangles that paths have the caches for themselves: the more rays there are, the fuller are
/// packets of those that go into one octant. (Cornell's box: 5 % faster; sponza would be 3 % slower.)
const LARGE_BATCH: usize = 4096;
const FEW_TRIANGLES: usize = 2048;

/// The random numbers of paths.
#[inline(always)]
fn numbers_of<'a>(path: impl Fn(usize) -> &'a PlacedPath) -> NumberLanes<LANES> {
    NumberLanes::new(|lane| {
        let path = path(lane);
        (path.pixel_key, path.sample, &path.state.ray)
    })
}

/// Takes what paths find.
struct Found<'a> {
    paths: &'a [PlacedPath],
    /// The paths' numbers.
    lanes: &'a [u32],
    sums: &'a mut [ExactSum],
    next: &'a mut Vec<PlacedPath>,
    rays: &'a mut Vec<Ray>,
    filters: &'a mut Vec<RayFilter>,
    requests: &'a mut Vec<PlacedRequest>,
}

/// Takes what one of them finds.
struct FoundByOne<'a, 'b> {
    path: &'a PlacedPath,
    to: &'a mut Found<'b>,
}

impl<'b> BounceLanes for Found<'b> {
    type Lane<'a>
        = FoundByOne<'a, 'b>
    where
        Self: 'a;

    #[inline(always)]
    fn lane(&mut self, lane: usize) -> FoundByOne<'_, 'b> {
        FoundByOne { path: &self.paths[self.lanes[lane] as usize], to: self }
    }
}

impl Bounce for FoundByOne<'_, '_> {
    #[inline(always)]
    fn add(&mut self, found: Vec3) {
        self.to.sums[self.path.pixel as usize].add(found);
    }

    #[inline(always)]
    fn ask(&mut self, LightRequest { ray, filter, contribution }: LightRequest) {
        self.to.rays.push(ray);
        self.to.filters.push(filter);
        self.to.requests.push(PlacedRequest { contribution, pixel: self.path.pixel });
    }

    #[inline(always)]
    fn go_on(&mut self, state: PathState) {
        self.to.next.push(PlacedPath { state, ..*self.path });
    }
}

/// What path tracing works in.
#[derive(Default)]
pub(super) struct PathBatch {
    paths: Vec<PlacedPath>,
    /// Those that were there before paths from the camera came.
    on_their_way: Vec<PlacedPath>,
    next: Vec<PlacedPath>,
    rays: Vec<Ray>,
    filters: Vec<RayFilter>,
    hits: Vec<Hit>,
    requests: Vec<PlacedRequest>,
    hidden: Vec<bool>,
    /// Numbers of paths that met nothing, matte triangles, and something else.
    missed: Vec<u32>,
    matte: Vec<u32>,
    others: Vec<u32>,
}

/// The rays of a tile, whose sums are in the workspace then; `None` where it was given up.
#[inline(always)]
pub(in super::super) fn trace_paths<T: BatchTracer>(
    view: &SceneView,
    tracer: &T,
    job: &TileJob,
    work: &mut Workspace,
) -> Option<RayCounts> {
    let tile = job.tile;
    let mut counts = RayCounts::default();
    let mut camera = CameraRays::new(tile, job.samples.clone());
    let Workspace { path_batch: batch, sums, .. } = work;
    sums.clear();
    sums.resize(tile.pixels() as usize, ExactSum::default());
    // Of a tile that was given up.
    batch.paths.clear();
    let most = if view.triangles.len() <= FEW_TRIANGLES { LARGE_BATCH } else { BATCH };
    loop {
        if job.cancel.load(Ordering::Relaxed) {
            return None;
        }
        batch.next.clear();
        // Paths end, and others take their places, so that lanes and packets stay full.
        if batch.paths.len() <= most - most / 4 {
            std::mem::swap(&mut batch.paths, &mut batch.on_their_way);
            batch.paths.clear();
            let limit = most - batch.on_their_way.len();
            camera.take(view, limit, |Path { ray, x, y, sample }| {
                batch.paths.push(PlacedPath {
                    state: PathState::new(ray),
                    pixel_key: pixel_key(view.settings.seed, x, y),
                    sample,
                    pixel: tile.index_of(x, y) as u32,
                });
            });
            if batch.paths.is_empty() && batch.on_their_way.is_empty() {
                return Some(counts);
            }
            batch.step(view, tracer, Coherence::Coherent, sums, &mut counts);
            std::mem::swap(&mut batch.paths, &mut batch.on_their_way);
        }
        batch.step(view, tracer, Coherence::Incoherent, sums, &mut counts);
        std::mem::swap(&mut batch.paths, &mut batch.next);
    }
}

impl PathBatch {
    /// Each path's way to its next surface, and what it finds there: those that go on are put behind [`PathBatch::next`].
    #[inline(always)]
    fn step<T: BatchTracer>(
        &mut self,
        view: &SceneView,
        tracer: &T,
        coherence: Coherence,
        sums: &mut [ExactSum],
        counts: &mut RayCounts,
    ) {
        if self.paths.is_empty() {
            return;
        }
        self.find_hits(view, tracer, coherence);
        self.bounce(view, sums, counts);
        self.add_light(view, tracer, coherence, sums, counts);
    }

    #[inline(always)]
    fn find_hits<T: BatchTracer>(&mut self, view: &SceneView, tracer: &T, coherence: Coherence) {
        let count = self.paths.len();
        // Written over below; nothing is written where the length stays the same.
        self.rays.resize(count, NO_RAY);
        self.filters.resize(count, RayFilter::ALL);
        self.hits.resize(count, Hit::miss(f32::INFINITY));
        for ((path, ray), filter) in self.paths.iter().zip(&mut self.rays).zip(&mut self.filters) {
            *ray = path.state.ray.ray();
            *filter = path.state.ray.filter(view.settings);
        }
        tracer.closest_hits(&self.rays, Filters::Each(&self.filters), coherence, &mut self.hits);
    }

    /// What the rays found, and what follows from it, in lanes: matte triangles by a way of their own.
    #[inline(always)]
    fn bounce(&mut self, view: &SceneView, sums: &mut [ExactSum], counts: &mut RayCounts) {
        let PathBatch { paths, next, rays, filters, hits, requests, missed, matte, others, .. } = self;
        rays.clear();
        filters.clear();
        requests.clear();
        missed.clear();
        matte.clear();
        others.clear();
        for hit in hits.iter().take(AHEAD) {
            view.prefetch_triangle(hit);
        }
        for (number, (path, hit)) in paths.iter().zip(hits.iter()).enumerate() {
            if let Some(later) = hits.get(number + AHEAD) {
                view.prefetch_triangle(later);
            }
            counts.count(path.state.ray.kind);
            if hit.is_miss() {
                missed.push(number as u32);
            } else if is_matte_triangle(view, &path.state.ray, hit) {
                matte.push(number as u32);
            } else {
                others.push(number as u32);
            }
        }
        let number = |lanes: &[u32], lane: usize| lanes[lane.min(lanes.len() - 1)] as usize;
        for lanes in missed.chunks(LANES) {
            let ray = |lane| &paths[number(lanes, lane)].state.ray;
            surroundings_lanes::<LANES>(view, lanes.len(), ray, |lane, radiance| {
                sums[paths[lanes[lane] as usize].pixel as usize].add(radiance);
            });
        }
        let mut found = Found { paths, lanes: &[], sums, next, rays, filters, requests };
        let met = |lanes, lane| (&paths[number(lanes, lane)].state, &hits[number(lanes, lane)]);
        for lanes in matte.chunks(LANES) {
            found.lanes = lanes;
            let numbers = numbers_of(|lane| &paths[number(lanes, lane)]);
            bounce_matte::<LANES, _>(view, lanes.len(), |lane| met(lanes, lane), &numbers, &mut found);
        }
        for lanes in others.chunks(LANES) {
            found.lanes = lanes;
            let numbers = numbers_of(|lane| &paths[number(lanes, lane)]);
            bounce_lanes::<LANES, _>(view, lanes.len(), |lane| met(lanes, lane), &numbers, &mut found);
        }
    }

    /// The light of those lights that are seen.
    #[inline(always)]
    fn add_light<T: BatchTracer>(
        &mut self,
        view: &SceneView,
        tracer: &T,
        coherence: Coherence,
        sums: &mut [ExactSum],
        counts: &mut RayCounts,
    ) {
        let count = self.requests.len();
        counts.shadow += count as u64;
        self.hidden.resize(count, false);
        tracer.occluded_rays(&self.rays, Filters::Each(&self.filters), coherence, &mut self.hidden);
        for (number, request) in self.requests.iter().enumerate() {
            let contribution = request.contribution;
            let visible = if self.hidden[number] {
                let (ray, filter) = (self.rays[number], self.filters[number]);
                through(view, tracer, &LightRequest { ray, filter, contribution })
            } else {
                Vec3::ONE
            };
            sums[request.pixel as usize].add(contribution * visible);
        }
    }
}
