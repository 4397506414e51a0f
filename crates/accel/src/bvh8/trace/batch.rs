//! Many rays: the choice among packets, sorted packets, streams and single rays.

use super::packet::{LaneFilters, Packet};
use super::single;
use super::walk::{ANY, Found, NEXT, Query};
use crate::bvh8::Bvh8;
use crate::simd::{Float, Kernel, Simd};
use crate::{Coherence, Filters};
use eosphor_core::ray::{Hit, PrimitiveId, Ray, RayFilter};

/// Queries to be answered.
pub(super) struct Batch<'a, const QUERY: Query> {
    bvh: &'a Bvh8,
    rays: &'a [Ray],
    filters: Filters<'a>,
    coherence: Coherence,
    /// Unless the query is [`ANY`].
    hits: &'a mut [Hit],
    /// For [`ANY`].
    hidden: &'a mut [bool],
}

impl<'a, const QUERY: Query> Batch<'a, QUERY> {
    /// Panics where lengths differ.
    pub(super) fn new(
        bvh: &'a Bvh8,
        rays: &'a [Ray],
        filters: Filters<'a>,
        coherence: Coherence,
        hits: &'a mut [Hit],
        hidden: &'a mut [bool],
    ) -> Batch<'a, QUERY> {
        let answers = if QUERY == ANY { hidden.len() } else { hits.len() };
        assert_eq!(rays.len(), answers, "one answer for each ray");
        filters.check(rays.len());
        Batch { bvh, rays, filters, coherence, hits, hidden }
    }

    #[inline(always)]
    unsafe fn one_by_one<S: Simd>(&mut self, first: usize) {
        for k in first..self.rays.len() {
            let (ray, filter) = (&self.rays[k], self.filters.of(k));
            let mut found = Found::nothing(ray.t_max);
            if QUERY == NEXT {
                found.after = self.hits[k];
            }
            // SAFETY: the caller's.
            unsafe { single::trace::<S, QUERY>(self.bvh, ray, filter, &mut found) };
            if QUERY == ANY {
                self.hidden[k] = found.any;
            } else {
                self.hits[k] = found.best;
            }
        }
    }

    /// Sixteen rays; the numbers may repeat the last one.
    #[inline(always)]
    unsafe fn packet<S: Simd>(&mut self, numbers: &[u32; 16], count: usize, alone: u32) {
        let mut rows = [std::ptr::null::<f32>(); 16];
        let mut lane = 0;
        while lane < 16 {
            // SAFETY: numbers are below the length.
            rows[lane] = unsafe { self.rays.as_ptr().add(numbers[lane] as usize) }.cast();
            lane += 1;
        }
        let active = if count == 16 { 0xffff } else { (1u32 << count) - 1 };
        // SAFETY: the caller's; a ray is eight floats in the order of the packet.
        unsafe {
            let mut packet = Packet::<S>::load(&rows);
            match self.filters {
                Filters::Shared(filter) => {
                    let filters = [filter; 16];
                    if *filter == RayFilter::ALL {
                        packet.trace::<QUERY>(self.bvh, active, None, &filters, alone);
                    } else {
                        let lanes = LaneFilters::new(&filters);
                        packet.trace::<QUERY>(self.bvh, active, Some(&lanes), &filters, alone);
                    }
                }
                Filters::Each(each) => {
                    let mut filters = [&RayFilter::ALL; 16];
                    let mut lane = 0;
                    while lane < 16 {
                        filters[lane] = each.get_unchecked(numbers[lane] as usize);
                        lane += 1;
                    }
                    let lanes = LaneFilters::new(&filters);
                    packet.trace::<QUERY>(self.bvh, active, Some(&lanes), &filters, alone);
                }
            }
            self.store(&packet, numbers, count);
        }
    }

    #[inline(always)]
    fn store<S: Simd>(&mut self, packet: &Packet<S>, numbers: &[u32; 16], count: usize) {
        let t = packet.t_max.to_array();
        if QUERY == ANY {
            for lane in 0..count {
                self.hidden[numbers[lane] as usize] = t.as_ref()[lane] == f32::NEG_INFINITY;
            }
            return;
        }
        let (u, v) = (packet.u.to_array(), packet.v.to_array());
        let (primitive, instance) = (packet.primitive.to_array(), packet.instance.to_array());
        for lane in 0..count {
            let id = PrimitiveId {
                instance: instance.as_ref()[lane].to_bits(),
                primitive: primitive.as_ref()[lane].to_bits(),
            };
            self.hits[numbers[lane] as usize] =
                Hit { t: t.as_ref()[lane], u: u.as_ref()[lane], v: v.as_ref()[lane], id };
        }
    }

    /// In the given order, sixteen at a time.
    #[inline(always)]
    unsafe fn packets<S: Simd>(&mut self, alone: u32) {
        let mut first = 0;
        while first < self.rays.len() {
            let count = (self.rays.len() - first).min(16);
            let mut numbers = [0; 16];
            let mut lane = 0;
            while lane < 16 {
                numbers[lane] = (first + lane.min(count - 1)) as u32;
                lane += 1;
            }
            // SAFETY: the caller's.
            unsafe { self.packet::<S>(&numbers, count, alone) };
            first += 16;
        }
    }
}

/// In packets of coherent rays, at most so many go on alone in a subtree.
const ALONE_COHERENT: u32 = 0;

impl<const QUERY: Query> Kernel for Batch<'_, QUERY> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Simd>(mut self) {
        // SAFETY: the caller's.
        unsafe {
            if QUERY == NEXT {
                return self.one_by_one::<S>(0);
            }
            match self.coherence {
                Coherence::Coherent => self.packets::<S>(ALONE_COHERENT),
                _ => self.one_by_one::<S>(0),
            }
        }
    }
}
