//! Queries without a picture.

use super::CpuBackend;
use super::queries::with_batches;
use crate::Hierarchy;
use eosphor_accel::{Coherence, Filters};
use eosphor_core::ray::{Hit, Ray, RayFilter};
use rayon::prelude::*;

/// Rays that a thread takes at a time.
const CHUNK: usize = 1 << 14;

impl CpuBackend {
    /// The closest hits of rays, on all threads of the backend.
    pub fn closest_hits(&self, hierarchy: &Hierarchy, rays: &[Ray]) -> Vec<Hit> {
        let mut hits = vec![Hit::miss(0.0); rays.len()];
        self.pool.install(|| {
            rays.par_chunks(CHUNK).zip(hits.par_chunks_mut(CHUNK)).for_each(|(rays, hits)| {
                let all = Filters::Shared(&RayFilter::ALL);
                with_batches(hierarchy, hierarchy, self.simd, |q| {
                    q.closest_hits(rays, all, Coherence::Auto, hits)
                });
            });
        });
        hits
    }

    /// For each ray whether it hits anything, in the order of `rays`, computed on all threads of the backend.
    pub fn occluded_rays(&self, hierarchy: &Hierarchy, rays: &[Ray]) -> Vec<bool> {
        let mut hidden = vec![false; rays.len()];
        self.pool.install(|| {
            rays.par_chunks(CHUNK).zip(hidden.par_chunks_mut(CHUNK)).for_each(|(rays, hidden)| {
                let all = Filters::Shared(&RayFilter::ALL);
                with_batches(hierarchy, hierarchy, self.simd, |q| {
                    q.occluded_rays(rays, all, Coherence::Auto, hidden)
                });
            });
        });
        hidden
    }
}
