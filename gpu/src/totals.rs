//! Rays of a launch, and the work on them.

use crate::warp;
use core::sync::atomic::{AtomicU64, Ordering};
use eosphor_core::integrator::RayCounts;

/// Sums over all threads, in the order in which `crates/cuda/src/launch.rs` reads them.
#[repr(C)]
pub struct RayTotals {
    camera: AtomicU64,
    reflected: AtomicU64,
    refracted: AtomicU64,
    glossy: AtomicU64,
    shadow: AtomicU64,
    // What follows is for kernels that count.
    searches: AtomicU64,
    nodes: AtomicU64,
    primitives: AtomicU64,
    traversal_ticks: AtomicU64,
    intersection_ticks: AtomicU64,
    thread_ticks: AtomicU64,
    thread_nanoseconds: AtomicU64,
}

/// What a thread has seen of its queries.
pub(crate) struct Seen {
    pub(crate) searches: u64,
    pub(crate) nodes: u64,
    pub(crate) primitives: u64,
    /// Ticks of the processor's clock in either phase, and in all.
    pub(crate) traversal_ticks: u64,
    pub(crate) intersection_ticks: u64,
    pub(crate) thread_ticks: u64,
    /// The same by the device's clock, which goes in coarse steps.
    pub(crate) thread_nanoseconds: u64,
}

impl RayTotals {
    /// Adds what the threads of a warp have traced: one of them for all, since additions to one place wait for each other.
    #[inline(always)]
    pub(crate) fn add(&self, counts: &RayCounts, lane: u32) {
        add(&self.camera, counts.camera, lane);
        add(&self.reflected, counts.reflected, lane);
        add(&self.refracted, counts.refracted, lane);
        add(&self.glossy, counts.glossy, lane);
        add(&self.shadow, counts.shadow, lane);
    }

    /// The same of what they have seen.
    #[inline(always)]
    pub(crate) fn add_seen(&self, seen: &Seen, lane: u32) {
        add(&self.searches, seen.searches, lane);
        add(&self.nodes, seen.nodes, lane);
        add(&self.primitives, seen.primitives, lane);
        add(&self.traversal_ticks, seen.traversal_ticks, lane);
        add(&self.intersection_ticks, seen.intersection_ticks, lane);
        add(&self.thread_ticks, seen.thread_ticks, lane);
        add(&self.thread_nanoseconds, seen.thread_nanoseconds, lane);
    }
}

#[inline(always)]
fn add(total: &AtomicU64, count: u64, lane: u32) {
    let count = warp::total(count);
    if (lane == 0) & (count > 0) {
        total.fetch_add(count, Ordering::Relaxed);
    }
}
