//! Rays of a launch, and the work on them.

use crate::warp;
use core::sync::atomic::{AtomicU64, Ordering};
use eosphor_core::device::RayTotals;
use eosphor_core::integrator::RayCounts;

/// The [`RayTotals`] of a launch, to which all threads add.
pub(crate) struct Totals(*mut RayTotals);

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

/// The address of a total.
macro_rules! field {
    ($self:ident.$field:ident) => {
        // SAFETY: the totals are there, by the contract of `new`.
        unsafe { &raw mut (*$self.0).$field }
    };
}
impl Totals {
    /// Of the totals at this address.
    ///
    /// # Safety
    ///
    /// They are there for as long as this is used, and touched by atomic additions alone.
    #[inline(always)]
    pub(crate) unsafe fn new(totals: *mut RayTotals) -> Totals {
        Totals(totals)
    }

    /// Adds what the threads of a warp have traced: one of them for all, since additions to one place wait for each other.
    #[inline(always)]
    pub(crate) fn add(&self, counts: &RayCounts, lane: u32) {
        add(field!(self.camera), counts.camera, lane);
        add(field!(self.reflected), counts.reflected, lane);
        add(field!(self.refracted), counts.refracted, lane);
        add(field!(self.glossy), counts.glossy, lane);
        add(field!(self.shadow), counts.shadow, lane);
    }

    /// The same of what they have seen.
    #[inline(always)]
    pub(crate) fn add_seen(&self, seen: &Seen, lane: u32) {
        add(field!(self.searches), seen.searches, lane);
        add(field!(self.nodes), seen.nodes, lane);
        add(field!(self.primitives), seen.primitives, lane);
        add(field!(self.traversal_ticks), seen.traversal_ticks, lane);
        add(field!(self.intersection_ticks), seen.intersection_ticks, lane);
        add(field!(self.thread_ticks), seen.thread_ticks, lane);
        add(field!(self.thread_nanoseconds), seen.thread_nanoseconds, lane);
    }
}

#[inline(always)]
fn add(total: *mut u64, count: u64, lane: u32) {
    let count = warp::total(count);
    if (lane == 0) & (count > 0) {
        // SAFETY: the total is there, by the contract of `Totals::new`, and touched by additions like this alone.
        unsafe { AtomicU64::from_ptr(total) }.fetch_add(count, Ordering::Relaxed);
    }
}
