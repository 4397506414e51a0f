//! Many rays: the choice among packets, sorted packets, streams and single rays.

use super::choice::{FLAT, Way, choose};
use super::found::{ANY, Found, NEXT, Query, STACK};
use super::lanes::RaysV;
use super::packet::{LaneFilters, Packet, Query16, Room, load_rays, trace};
use super::single;
use super::sort;
use crate::bvh8::view::Bvh8View;
use crate::simd::{Float, Kernel, Mask, Simd};
use crate::{Coherence, Filters};
use eosphor_core::hierarchy::IgnoreWork;
use eosphor_core::ray::{Hit, Ray, RayFilter};
use std::mem::MaybeUninit;

/// Queries to be answered.
pub(super) struct Batch<'a, const QUERY: Query> {
    pub(super) bvh: &'a Bvh8View<'a>,
    pub(super) rays: &'a [Ray],
    pub(super) filters: Filters<'a>,
    coherence: Coherence,
    /// Unless the query is [`ANY`].
    pub(super) hits: &'a mut [Hit],
    /// For [`ANY`].
    pub(super) hidden: &'a mut [bool],
}

impl<'a, const QUERY: Query> Batch<'a, QUERY> {
    /// # Panics
    /// Where there are not as many answers, or filters of single rays, as rays.
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
            _ => choose(&self.rays[first..end], self.bvh.extent(), self.bvh.blocks.len()),
        }
    }

    /// # Safety
    /// Instruction set: the CPU has it. Whole batch: `first` and `end` are no more than the rays.
    #[inline(always)]
    pub(super) unsafe fn one_by_one<S: Simd>(&mut self, first: usize, end: usize) {
        for k in first..end {
            let (ray, filter) = (&self.rays[k], self.filters.of(k));
            let mut found = Found::nothing(ray.t_max);
            if QUERY == NEXT {
                found.after = Some(self.hits[k]);
            }
            // SAFETY: instruction set: promised to this function.
            unsafe { single::trace::<S, _, QUERY>(self.bvh, ray, filter, IgnoreWork, &mut found) };
            if QUERY == ANY {
                self.hidden[k] = found.any;
            } else {
                self.hits[k] = found.best;
            }
        }
    }

    /// The rays of these numbers in packets that walk together, as many as fit: at least one ray.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Whole batch: numbers are below the count of rays.
    #[inline(always)]
    unsafe fn packets_of<S: Simd, const N: usize>(
        &mut self,
        numbers: &[u32],
        alone: u32,
        shared: &Shared<S>,
        room: &mut Room<S, N>,
    ) {
        let rays = self.rays.as_ptr();
        let mut loaded = MaybeUninit::<[RaysV<S::F16>; N]>::uninit();
        let mut packets = MaybeUninit::<[Packet<S>; N]>::uninit();
        let mut filters = MaybeUninit::<[[&RayFilter; 16]; N]>::uninit();
        let filter = filters.as_mut_ptr().cast::<&RayFilter>();
        let mut counts = [0; N];
        let last = numbers.len() - 1;
        // SAFETY: instruction set and whole batch: promised to this function, and there are N packets.
        unsafe {
            let mut k = 0;
            while k < N {
                counts[k] = numbers.len().saturating_sub(16 * k).min(16);
                let mut rows = [std::ptr::null::<f32>(); 16];
                let mut lane = 0;
                while lane < 16 {
                    // Lanes that are not used have the last ray.
                    let number = *numbers.get_unchecked((16 * k + lane).min(last)) as usize;
                    rows[lane] = rays.add(number).cast();
                    if let Filters::Each(each) = self.filters {
                        filter.add(16 * k + lane).write(each.get_unchecked(number));
                    }
                    lane += 1;
                }
                let rays = load_rays::<S>(&rows);
                packets.as_mut_ptr().cast::<Packet<S>>().add(k).write(Packet::new(rays.t_max));
                loaded.as_mut_ptr().cast::<RaysV<S::F16>>().add(k).write(rays);
                k += 1;
            }
            let packets = packets.assume_init_mut();
            let rays = loaded.assume_init_ref();
            self.trace::<S, N>(packets, rays, &filters, counts, alone, shared, room);
            k = 0;
            while k < N {
                let (packet, count) = (&packets[k], counts[k]);
                if QUERY == ANY {
                    let hidden = packet.end.same_bits(S::F16::splat(f32::NEG_INFINITY)).bits();
                    for lane in 0..count {
                        self.hidden[numbers[16 * k + lane] as usize] = hidden >> lane & 1 == 1;
                    }
                } else {
                    // Lanes that are not used go nowhere.
                    let mut nowhere = Hit::miss(0.0);
                    let mut rows = [(&raw mut nowhere).cast::<f32>(); 16];
                    for lane in 0..count {
                        rows[lane] = self.hits.as_mut_ptr().add(numbers[16 * k + lane] as usize).cast();
                    }
                    store_hits(packet, &rows);
                }
                k += 1;
            }
        }
    }

    /// N packets of sixteen rays from `first` on, which walk together: addresses follow from one.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Whole batch: there are 16 N rays from `first` on.
    #[inline(always)]
    unsafe fn packets_in_order<S: Simd, const N: usize>(
        &mut self,
        first: usize,
        shared: &Shared<S>,
        room: &mut Room<S, N>,
    ) {
        let mut loaded = MaybeUninit::<[RaysV<S::F16>; N]>::uninit();
        let mut packets = MaybeUninit::<[Packet<S>; N]>::uninit();
        let mut filters = MaybeUninit::<[[&RayFilter; 16]; N]>::uninit();
        let filter = filters.as_mut_ptr().cast::<&RayFilter>();
        // SAFETY: instruction set and whole batch: promised to this function; filters and answers are as many as rays.
        unsafe {
            let mut k = 0;
            while k < N {
                let rays = self.rays.as_ptr().add(first + 16 * k);
                let mut rows = [std::ptr::null::<f32>(); 16];
                let mut lane = 0;
                while lane < 16 {
                    rows[lane] = rays.add(lane).cast();
                    // Of the group after this one, which is one ahead in each lane.
                    S::prefetch(rays.wrapping_add(16 * N + lane));
                    if let Filters::Each(each) = self.filters {
                        filter.add(16 * k + lane).write(each.get_unchecked(first + 16 * k + lane));
                    }
                    lane += 1;
                }
                let rays = load_rays::<S>(&rows);
                packets.as_mut_ptr().cast::<Packet<S>>().add(k).write(Packet::new(rays.t_max));
                loaded.as_mut_ptr().cast::<RaysV<S::F16>>().add(k).write(rays);
                k += 1;
            }
            let packets = packets.assume_init_mut();
            let rays = loaded.assume_init_ref();
            self.trace::<S, N>(packets, rays, &filters, [16; N], ALONE_COHERENT, shared, room);
            k = 0;
            while k < N {
                let (packet, first) = (&packets[k], first + 16 * k);
                let mut lane = 0;
                if QUERY == ANY {
                    let hidden = packet.end.same_bits(S::F16::splat(f32::NEG_INFINITY)).bits();
                    let answers = self.hidden.as_mut_ptr().add(first);
                    while lane < 16 {
                        answers.add(lane).write(hidden >> lane & 1 == 1);
                        lane += 1;
                    }
                } else {
                    let answers = self.hits.as_mut_ptr().add(first);
                    let mut rows = [answers.cast::<f32>(); 16];
                    while lane < 16 {
                        rows[lane] = answers.add(lane).cast();
                        lane += 1;
                    }
                    store_hits(packet, &rows);
                }
                k += 1;
            }
        }
    }

    /// Traces packets; `each` holds the filters of rays that have their own.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Whole batch: where rays have filters of their own, `each` is written.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "what packets are made of")]
    unsafe fn trace<S: Simd, const N: usize>(
        &self,
        packets: &mut [Packet<S>; N],
        rays: &[RaysV<S::F16>; N],
        each: &MaybeUninit<[[&RayFilter; 16]; N]>,
        counts: [usize; N],
        alone: u32,
        shared: &Shared<S>,
        room: &mut Room<S, N>,
    ) {
        let mut active = [0; N];
        let query = Query16 {
            bvh: self.bvh,
            shared_filter: shared.filter,
            lane_filters: shared.lanes.as_ref(),
            filters: &shared.filters,
            alone,
            leaves_by_bounds: false,
        };
        let mut queries = [query; N];
        let mut lanes = [const { MaybeUninit::uninit() }; N];
        let mut k = 0;
        while k < N {
            active[k] = (1u32 << counts[k]) - 1;
            k += 1;
        }
        if let Filters::Each(_) = self.filters {
            // SAFETY: whole batch: where rays have their own filters, `each` is written, as promised to this function.
            let each = unsafe { each.assume_init_ref() };
            k = 0;
            while k < N {
                lanes[k].write(LaneFilters::new(&each[k]));
                k += 1;
            }
            k = 0;
            while k < N {
                // SAFETY: written places: the loop before has written all.
                let lanes = unsafe { lanes[k].assume_init_ref() };
                queries[k] = Query16 { lane_filters: Some(lanes), filters: &each[k], ..query };
                k += 1;
            }
        }
        // SAFETY: instruction set: promised to this function.
        unsafe { trace::<S, QUERY, N>(packets, rays, active, &queries, room) };
    }

    /// Rays `first .. end` in the given order, in groups.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Whole batch: `end` is no more than the rays.
    #[inline(always)]
    unsafe fn packets<S: Simd>(
        &mut self,
        mut first: usize,
        end: usize,
        shared: &Shared<S>,
        room: &mut Option<Box<Room<S, TOGETHER>>>,
    ) {
        while first + 16 * TOGETHER <= end {
            // SAFETY: whole batch: the loop's condition says so. Instruction set: promised to this function.
            unsafe { self.packets_in_order::<S, TOGETHER>(first, shared, made::<S>(room)) };
            first += 16 * TOGETHER;
        }
        // The rest.
        let mut room = MaybeUninit::uninit();
        while first + 16 <= end {
            // SAFETY: whole batch: the loop's condition says so. Instruction set: promised to this function.
            unsafe { self.packets_in_order::<S, 1>(first, shared, &mut room) };
            first += 16;
        }
        if first < end {
            let count = end - first;
            let mut numbers = [0; 16];
            for (lane, number) in numbers[..count].iter_mut().enumerate() {
                *number = (first + lane) as u32;
            }
            // SAFETY: whole batch: the numbers end with `end`. Instruction set: promised to this function.
            unsafe { self.packets_of::<S, 1>(&numbers[..count], ALONE_COHERENT, shared, &mut room) };
        }
    }

    /// Rays `first .. end`, at most [`CHUNK`], in the order of the octants that they go into.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Whole batch: `end` is no more than the rays.
    #[inline(always)]
    unsafe fn sorted_packets<S: Simd>(
        &mut self,
        first: usize,
        end: usize,
        shared: &Shared<S>,
        room: &mut Option<Box<Room<S, TOGETHER>>>,
    ) {
        let room = made::<S>(room);
        let mut order = [0u32; CHUNK];
        let count = end - first;
        sort::by_octant(&self.rays[first..end], first as u32, &mut order[..count]);
        for group in order[..count].chunks(16 * TOGETHER) {
            // SAFETY: whole batch: sorting keeps the numbers. Instruction set: promised to this function.
            unsafe {
                self.packets_of::<S, TOGETHER>(group, alone_sorted::<S>(self.bvh), shared, room);
            }
        }
    }
}

/// Room for a group, made when it is first needed.
#[inline(always)]
fn made<S: Simd>(room: &mut Option<Box<Room<S, TOGETHER>>>) -> &mut Room<S, TOGETHER> {
    room.get_or_insert_with(Box::<[[S::F16; TOGETHER]; STACK]>::new_uninit)
}

/// The filter of all rays, sixteen times.
struct Shared<'a, S: Simd> {
    /// `None` where it leaves out nothing.
    filter: Option<&'a RayFilter>,
    /// Where it leaves out backs.
    lanes: Option<LaneFilters<S>>,
    filters: [&'a RayFilter; 16],
}

impl<'a, S: Simd> Shared<'a, S> {
    /// Not used where each ray has its own.
    #[inline(always)]
    fn new(filters: Filters<'a>) -> Shared<'a, S> {
        let filter = if let Filters::Shared(filter) = filters { filter } else { &RayFilter::ALL };
        let lanes = filter.cull_back_faces.then(|| LaneFilters::shared(filter));
        Shared { filter: (*filter != RayFilter::ALL).then_some(filter), lanes, filters: [filter; 16] }
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
    // SAFETY: whole batch: the rows are hits, as promised to this function; a hit is six numbers of 32 bits.
    unsafe {
        while lane < 16 {
            ids[lane] = ids[lane].add(4);
            lane += 1;
        }
        S::scatter16([best.t, rest, best.u, best.v], rows);
        S::scatter16_pairs([instance, best.primitive], &ids);
    }
}

/// Packets that walk together.
const TOGETHER: usize = 4;

/// Rays that are sorted together.
const CHUNK: usize = 4096;

/// In packets of coherent rays, at most so many go on alone in a subtree.
pub(super) const ALONE_COHERENT: u32 = 0;

/// The same for rays sorted by octant: together they cost about half as much where sixteen are one register. In flat hierarchies
/// a ray alone has hardly less to do.
#[inline(always)]
fn alone_sorted<S: Simd>(bvh: &Bvh8View) -> u32 {
    match bvh.blocks.len() {
        ..=FLAT => 0,
        _ if S::HAS_REGISTERS_OF_16 => 2,
        _ => 3,
    }
}

/// Fewer rays than this are traced one by one. (Six in a stream are 1.03 to 1.42 times as fast, sixteen 1.3 to 1.9 times.)
const FEW: usize = 6;
impl<const QUERY: Query> Kernel for Batch<'_, QUERY> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Simd>(mut self) {
        // SAFETY: whole batch: `first` and `end` stay within the rays. Instruction set: a kernel is run below its own.
        unsafe {
            if QUERY == NEXT || self.rays.len() < FEW || !cfg!(feature = "packets") {
                let count = self.rays.len();
                return self.one_by_one::<S>(0, count);
            }
            let shared = Shared::<S>::new(self.filters);
            let mut room = None;
            let mut first = 0;
            while first < self.rays.len() {
                let mut end = self.rays.len().min(first + CHUNK);
                match self.way(first, end) {
                    // What is said to be incoherent does not go in packets as it comes.
                    Way::Packets if self.coherence != Coherence::Incoherent => {
                        self.packets(first, end, &shared, &mut room);
                    }
                    Way::Scattered => {
                        // As long as they are.
                        while end < self.rays.len() {
                            let next = self.rays.len().min(end + CHUNK);
                            if self.way(end, next) != Way::Scattered {
                                break;
                            }
                            end = next;
                        }
                        self.stream::<S>(first, end);
                    }
                    _ => self.sorted_packets(first, end, &shared, &mut room),
                }
                first = end;
            }
        }
    }
}
