//! Many rays: the choice among packets, sorted packets, streams and single rays.

use super::choice::{Way, choose};
use super::lanes::RaysV;
use super::packet::{LaneFilters, Packet, Query16, load_rays, rays_from_one_point};
use super::single;
use super::sort;
use super::walk::{ANY, Found, NEXT, Query};
use crate::bvh8::view::Bvh8View;
use crate::simd::{Float, Kernel, Mask, Simd};
use crate::{Coherence, Filters};
use eosphor_core::hierarchy::ShadowBatch;
use eosphor_core::ray::{Hit, Ray, RayFilter};

/// Queries to be answered.
pub(super) struct Batch<'a, const QUERY: Query> {
    bvh: &'a Bvh8View<'a>,
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
        bvh: &'a Bvh8View<'a>,
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

    /// How to trace a chunk.
    #[inline(always)]
    fn way(&self, first: usize, end: usize) -> Way {
        match self.coherence {
            Coherence::Coherent => Way::Packets,
            _ => choose(&self.rays[first..end], self.bvh.extent()),
        }
    }

    #[inline(always)]
    unsafe fn one_by_one<S: Simd>(&mut self, first: usize, end: usize) {
        for k in first..end {
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

    /// Sixteen rays; of some, the numbers may repeat the last one.
    #[inline(always)]
    unsafe fn packet<S: Simd>(&mut self, numbers: &[u32; 16], count: usize, alone: u32, shared: &Shared<S>) {
        let rays = self.rays.as_ptr();
        let mut rows = [std::ptr::null::<f32>(); 16];
        let mut filters = [&RayFilter::ALL; 16];
        let mut lane = 0;
        while lane < 16 {
            // SAFETY: numbers are below the length.
            unsafe {
                rows[lane] = rays.add(numbers[lane] as usize).cast();
                if let Filters::Each(each) = self.filters {
                    filters[lane] = each.get_unchecked(numbers[lane] as usize);
                }
            }
            lane += 1;
        }
        // SAFETY: the caller's.
        unsafe {
            let loaded = load_rays::<S>(&rows);
            let mut packet = Packet::new(loaded.t_max);
            self.trace(&mut packet, &loaded, &filters, count, alone, shared);
            if QUERY == ANY {
                let hidden = packet.end.same_bits(S::F16::splat(f32::NEG_INFINITY)).bits();
                for lane in 0..count {
                    self.hidden[numbers[lane] as usize] = hidden >> lane & 1 == 1;
                }
                return;
            }
            // Lanes that are not used go nowhere.
            let mut nowhere = Hit::miss(0.0);
            let mut rows = [(&raw mut nowhere).cast::<f32>(); 16];
            for lane in 0..count {
                rows[lane] = self.hits.as_mut_ptr().add(numbers[lane] as usize).cast();
            }
            store_hits(&packet, &rows);
        }
    }

    /// Sixteen rays from `first` on: addresses follow from one.
    #[inline(always)]
    unsafe fn packet_in_order<S: Simd>(&mut self, first: usize, shared: &Shared<S>) {
        let mut rows = [std::ptr::null::<f32>(); 16];
        let mut filters = [&RayFilter::ALL; 16];
        let mut lane = 0;
        // SAFETY: the caller's; there are sixteen rays, filters and answers.
        unsafe {
            let rays = self.rays.as_ptr().add(first);
            while lane < 16 {
                rows[lane] = rays.add(lane).cast();
                // Of the packet after this one, which is one ahead in each lane.
                S::prefetch(rays.wrapping_add(16 + lane));
                if let Filters::Each(each) = self.filters {
                    filters[lane] = each.get_unchecked(first + lane);
                }
                lane += 1;
            }
            let loaded = load_rays::<S>(&rows);
            let mut packet = Packet::new(loaded.t_max);
            self.trace(&mut packet, &loaded, &filters, 16, ALONE_COHERENT, shared);
            if QUERY == ANY {
                let hidden = packet.end.same_bits(S::F16::splat(f32::NEG_INFINITY)).bits();
                let answers = self.hidden.as_mut_ptr().add(first);
                let mut lane = 0;
                while lane < 16 {
                    answers.add(lane).write(hidden >> lane & 1 == 1);
                    lane += 1;
                }
                return;
            }
            let answers = self.hits.as_mut_ptr().add(first);
            let mut rows = [answers.cast::<f32>(); 16];
            let mut lane = 0;
            while lane < 16 {
                rows[lane] = answers.add(lane).cast();
                lane += 1;
            }
            store_hits(&packet, &rows);
        }
    }

    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "what packets are made of")]
    unsafe fn trace<S: Simd>(
        &self,
        packet: &mut Packet<S>,
        rays: &RaysV<S::F16>,
        each: &[&RayFilter; 16],
        count: usize,
        alone: u32,
        shared: &Shared<S>,
    ) {
        let active = if count == 16 { 0xffff } else { (1u32 << count) - 1 };
        // SAFETY: the caller's.
        unsafe {
            if let Filters::Each(_) = self.filters {
                let lanes = LaneFilters::new(each);
                let query = Query16 { bvh: self.bvh, lane_filters: Some(&lanes), filters: each, alone };
                packet.trace::<QUERY>(rays, active, &query);
            } else {
                let query = Query16 {
                    bvh: self.bvh,
                    lane_filters: shared.lanes.as_ref(),
                    filters: &shared.filters,
                    alone,
                };
                packet.trace::<QUERY>(rays, active, &query);
            }
        }
    }

    /// Rays `first .. end` in the given order, sixteen at a time.
    #[inline(always)]
    unsafe fn packets<S: Simd>(&mut self, mut first: usize, end: usize, shared: &Shared<S>) {
        while first + 16 <= end {
            // SAFETY: the caller's.
            unsafe { self.packet_in_order(first, shared) };
            first += 16;
        }
        if first < end {
            let count = end - first;
            let mut numbers = [0; 16];
            let mut lane = 0;
            while lane < 16 {
                numbers[lane] = (first + lane.min(count - 1)) as u32;
                lane += 1;
            }
            // SAFETY: the caller's.
            unsafe { self.packet(&numbers, count, ALONE_COHERENT, shared) };
        }
    }

    /// Rays `first .. end`, at most [`CHUNK`], in the order of the octants that they go into.
    #[inline(always)]
    unsafe fn sorted_packets<S: Simd>(&mut self, first: usize, end: usize, shared: &Shared<S>) {
        let mut order = [0u32; CHUNK];
        let count = end - first;
        sort::by_octant(&self.rays[first..end], first as u32, &mut order[..count]);
        let mut start = 0;
        while start < count {
            let lanes = (count - start).min(16);
            let mut numbers = [order[start]; 16];
            numbers[..lanes].copy_from_slice(&order[start..start + lanes]);
            // SAFETY: the caller's.
            unsafe { self.packet(&numbers, lanes, const { alone_sorted::<S>() }, shared) };
            start += 16;
        }
    }

    /// Rays `first .. end` in the order of the places where they start and the octants that they go into.
    #[inline(always)]
    unsafe fn packets_by_place<S: Simd>(&mut self, first: usize, end: usize, shared: &Shared<S>) {
        let order = sort::by_place(&self.rays[first..end], first as u32);
        for group in order.chunks(16) {
            let mut numbers = [group[0]; 16];
            numbers[..group.len()].copy_from_slice(group);
            // SAFETY: the caller's.
            unsafe { self.packet(&numbers, group.len(), const { alone_sorted::<S>() }, shared) };
        }
    }
}

/// The filter of all rays, sixteen times.
struct Shared<'a, S: Simd> {
    /// `None` where it leaves out nothing.
    lanes: Option<LaneFilters<S>>,
    filters: [&'a RayFilter; 16],
}

impl<'a, S: Simd> Shared<'a, S> {
    /// Not used where each ray has its own.
    #[inline(always)]
    fn new(filters: Filters<'a>) -> Shared<'a, S> {
        let filter = if let Filters::Shared(filter) = filters { filter } else { &RayFilter::ALL };
        let lanes = (*filter != RayFilter::ALL).then(|| LaneFilters::shared(filter));
        Shared { lanes, filters: [filter; 16] }
    }
}

/// Writes hits: t, its rest, u, v, instance and primitive each.
///
/// # Safety
/// The rows are hits.
#[inline(always)]
unsafe fn store_hits<S: Simd>(packet: &Packet<S>, rows: &[*mut f32; 16]) {
    let best = &packet.best;
    let (rest, instance) = best.rest_and_instance();
    let mut ids = *rows;
    let mut lane = 0;
    // SAFETY: the caller's; a hit is six numbers of 32 bits.
    unsafe {
        while lane < 16 {
            ids[lane] = ids[lane].add(4);
            lane += 1;
        }
        S::scatter16([best.t, rest, best.u, best.v], rows);
        S::scatter16_pairs([instance, best.primitive], &ids);
    }
}

/// Rays from one point, towards a light.
pub(super) struct FromOnePoint<'a> {
    pub(super) bvh: &'a Bvh8View<'a>,
    pub(super) batch: &'a ShadowBatch<16>,
    pub(super) filter: &'a RayFilter,
    /// Bits of the lanes that are asked for.
    pub(super) active: u32,
}

impl Kernel for FromOnePoint<'_> {
    /// Bits of the lanes that something hides.
    type Output = u32;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> u32 {
        let (batch, filters) = (self.batch, [self.filter; 16]);
        let lanes = LaneFilters::<S>::shared(self.filter);
        let rays = rays_from_one_point::<S>(batch);
        let mut packet = Packet::<S>::new(rays.t_max);
        // SAFETY: the caller's.
        unsafe {
            let query = Query16 {
                bvh: self.bvh,
                lane_filters: Some(&lanes),
                filters: &filters,
                alone: ALONE_COHERENT,
            };
            packet.trace::<ANY>(&rays, self.active, &query);
        }
        packet.end.same_bits(S::F16::splat(f32::NEG_INFINITY)).bits() & self.active
    }
}

/// Rays that are sorted together.
const CHUNK: usize = 4096;

/// In packets of coherent rays, at most so many go on alone in a subtree.
const ALONE_COHERENT: u32 = 0;

/// The same for rays sorted by octant: together they cost about half as much where sixteen are one register.
const fn alone_sorted<S: Simd>() -> u32 {
    if S::HAS_REGISTERS_OF_16 { 2 } else { 4 }
}

/// Fewer rays than this are traced one by one.
const FEW: usize = 4;
/// From so many on, scattered rays are worth sorting by place.
const MANY: usize = 16_384;
/// So many are sorted by place at most.
const MOST: usize = 1 << 20;
/// In hierarchies of more blocks than this, rays of one octant part so soon that single ones are faster.
const DENSE: usize = 100_000;

impl<const QUERY: Query> Kernel for Batch<'_, QUERY> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Simd>(mut self) {
        // SAFETY: the caller's.
        unsafe {
            if QUERY == NEXT || self.rays.len() < FEW {
                let count = self.rays.len();
                return self.one_by_one::<S>(0, count);
            }
            let shared = Shared::<S>::new(self.filters);
            let dense = self.bvh.blocks.len() > DENSE;
            let mut first = 0;
            while first < self.rays.len() {
                let mut end = self.rays.len().min(first + CHUNK);
                let way = self.way(first, end);
                match way {
                    // What is said to be incoherent does not go in packets as it comes.
                    Way::Packets if self.coherence != Coherence::Incoherent => {
                        self.packets(first, end, &shared);
                    }
                    Way::Scattered => {
                        // As many as there are, since the more there are the closer are neighbours.
                        while end < self.rays.len() && end - first < MOST {
                            let next = self.rays.len().min(end + CHUNK);
                            if self.way(end, next) != Way::Scattered {
                                break;
                            }
                            end = next;
                        }
                        if end - first >= MANY {
                            self.packets_by_place(first, end, &shared);
                        } else {
                            self.one_by_one::<S>(first, end);
                        }
                    }
                    _ if dense => self.one_by_one::<S>(first, end),
                    _ => self.sorted_packets(first, end, &shared),
                }
                first = end;
            }
        }
    }
}
