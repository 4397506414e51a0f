//! Many rays: the choice among packets, sorted packets, streams and single rays.

use super::choice::{Way, choose};
use super::packet::{LaneFilters, Packet};
use super::single;
use super::stream;
use super::walk::{ANY, Found, NEXT, Query};
use crate::bvh8::Bvh8;
use crate::simd::{Float, Kernel, Simd};
use crate::{Coherence, Filters};
use eosphor_core::ray::{Hit, Ray, RayFilter};

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
    unsafe fn one_by_one<S: Simd>(&mut self) {
        for k in 0..self.rays.len() {
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
                let number = numbers[lane] as usize;
                // A ray may have come with this end, and then nothing hides it.
                let is_marked = t.as_ref()[lane] == f32::NEG_INFINITY;
                self.hidden[number] = is_marked & (self.rays[number].t_max != f32::NEG_INFINITY);
            }
            return;
        }
        let primitive = packet.primitive.to_array();
        // A hit is t, u, v, instance and primitive; lanes that are not used go nowhere.
        let mut nowhere = Hit::miss(0.0);
        let mut rows = [(&raw mut nowhere).cast::<f32>(); 16];
        for lane in 0..count {
            // SAFETY: numbers are below the length.
            rows[lane] = unsafe { self.hits.as_mut_ptr().add(numbers[lane] as usize) }.cast();
        }
        // SAFETY: rows are hits, which are five numbers of 32 bits.
        unsafe {
            S::scatter16([packet.t_max, packet.u, packet.v, packet.instance], &rows);
            for lane in 0..16 {
                rows[lane].add(4).write(primitive.as_ref()[lane]);
            }
        }
    }

    /// Rays `first .. end` in the given order, sixteen at a time.
    #[inline(always)]
    unsafe fn packets<S: Simd>(&mut self, mut first: usize, end: usize) {
        while first < end {
            let count = (end - first).min(16);
            let mut numbers = [0; 16];
            let mut lane = 0;
            while lane < 16 {
                numbers[lane] = (first + lane.min(count - 1)) as u32;
                lane += 1;
            }
            // SAFETY: the caller's.
            unsafe { self.packet::<S>(&numbers, count, ALONE_COHERENT) };
            first += 16;
        }
    }

    /// Rays `first .. end`, at most [`CHUNK`], in the order of the octants that they go into.
    #[inline(always)]
    unsafe fn sorted_packets<S: Simd>(&mut self, first: usize, end: usize) {
        let mut order = [0u32; CHUNK];
        let count = end - first;
        sort_by_octant(&self.rays[first..end], first as u32, &mut order[..count]);
        let mut start = 0;
        while start < count {
            let lanes = (count - start).min(16);
            let mut numbers = [order[start]; 16];
            numbers[..lanes].copy_from_slice(&order[start..start + lanes]);
            // SAFETY: the caller's.
            unsafe { self.packet::<S>(&numbers, lanes, ALONE_SORTED) };
            start += 16;
        }
    }

    /// Rays `first .. end` in a stream.
    #[inline(always)]
    unsafe fn stream<S: Simd>(&mut self, first: usize, end: usize) {
        let bvh = self.bvh;
        // SAFETY: the caller's.
        unsafe { stream::trace::<S, QUERY>(bvh, &mut InOrder { batch: self, next: first, end }) };
    }
}

/// Rays of a batch for a stream.
struct InOrder<'b, 'a, const QUERY: Query> {
    batch: &'b mut Batch<'a, QUERY>,
    next: usize,
    end: usize,
}

impl<const QUERY: Query> stream::Source for InOrder<'_, '_, QUERY> {
    #[inline(always)]
    fn next(&mut self) -> Option<(u32, &Ray, &RayFilter)> {
        if self.next == self.end {
            return None;
        }
        self.next += 1;
        Some((self.next as u32 - 1, &self.batch.rays[self.next - 1], self.batch.filters.of(self.next - 1)))
    }

    #[inline(always)]
    fn finish(&mut self, number: u32, found: &Found) {
        if QUERY == ANY {
            self.batch.hidden[number as usize] = found.any;
        } else {
            self.batch.hits[number as usize] = found.best;
        }
    }

    #[inline(always)]
    fn ray(&self, number: u32) -> (&Ray, &RayFilter) {
        (&self.batch.rays[number as usize], self.batch.filters.of(number as usize))
    }
}

/// Rays that are sorted together.
const CHUNK: usize = 4096;

/// Numbers of rays from `first` on, those of one octant next to each other; otherwise as they come.
#[inline(always)]
fn sort_by_octant(rays: &[Ray], first: u32, order: &mut [u32]) {
    let mut starts = [0u32; 9];
    for ray in rays {
        starts[octant(ray) + 1] += 1;
    }
    for k in 0..8 {
        starts[k + 1] += starts[k];
    }
    for (number, ray) in (first..).zip(rays) {
        let place = &mut starts[octant(ray)];
        order[*place as usize] = number;
        *place += 1;
    }
}

#[inline(always)]
fn octant(ray: &Ray) -> usize {
    let negative = |x: f32| (x.to_bits() >> 31) as usize;
    negative(ray.direction.x) | negative(ray.direction.y) << 1 | negative(ray.direction.z) << 2
}

/// In packets of coherent rays, at most so many go on alone in a subtree.
const ALONE_COHERENT: u32 = 0;
/// The same for rays sorted by octant.
const ALONE_SORTED: u32 = 4;
/// Fewer rays than this are traced one by one.
const FEW: usize = 4;

impl<const QUERY: Query> Kernel for Batch<'_, QUERY> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Simd>(mut self) {
        // SAFETY: the caller's.
        unsafe {
            if QUERY == NEXT || self.rays.len() < FEW {
                return self.one_by_one::<S>();
            }
            let mut first = 0;
            while first < self.rays.len() {
                let end = self.rays.len().min(first + CHUNK);
                let way = match self.coherence {
                    Coherence::Coherent => Way::Packets,
                    _ => choose(&self.rays[first..end], self.bvh.extent()),
                };
                // What is said to be incoherent does not go in packets as it comes.
                match (way, self.coherence) {
                    (Way::Packets, Coherence::Incoherent) => self.sorted_packets::<S>(first, end),
                    (Way::Packets, _) => self.packets::<S>(first, end),
                    (Way::SortedPackets, _) => self.sorted_packets::<S>(first, end),
                    (Way::Stream, _) => self.stream::<S>(first, end),
                }
                first = end;
            }
        }
    }
}
