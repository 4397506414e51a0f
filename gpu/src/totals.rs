//! Rays of a launch.

use crate::warp;
use core::sync::atomic::{AtomicU64, Ordering};
use eosphor_core::whitted::RayCounts;

/// Sums over all threads, in the order in which `crates/cuda/src/launch.rs` reads them.
#[repr(C)]
pub struct RayTotals {
    camera: AtomicU64,
    reflected: AtomicU64,
    refracted: AtomicU64,
    glossy: AtomicU64,
    shadow: AtomicU64,
}

impl RayTotals {
    /// Adds what the threads of a warp have traced: one of them for all, since additions to one place wait for each other.
    #[inline(always)]
    pub(crate) fn add(&self, counts: &RayCounts, lane: u32) {
        let add = |total: &AtomicU64, count: u64| {
            let count = warp::total(count);
            if (lane == 0) & (count > 0) {
                total.fetch_add(count, Ordering::Relaxed);
            }
        };
        add(&self.camera, counts.camera);
        add(&self.reflected, counts.reflected);
        add(&self.refracted, counts.refracted);
        add(&self.glossy, counts.glossy);
        add(&self.shadow, counts.shadow);
    }
}
