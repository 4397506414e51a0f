//! Rays of a launch.

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
    /// Adds what a thread has traced.
    pub(crate) fn add(&self, counts: &RayCounts) {
        let add = |total: &AtomicU64, count: u64| {
            if count > 0 {
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
