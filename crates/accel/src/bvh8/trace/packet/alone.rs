//! Rays of a packet that go on one by one.

use super::{Leg, Packet, Query16, arrays, lane_of};
use crate::bvh8::Child;
use crate::bvh8::trace::single;
use crate::bvh8::trace::single_leaf::settle;
use crate::bvh8::trace::single_ray::SingleRay;
use crate::bvh8::trace::walk::{ANY, Found, Query};
use crate::simd::{Float, Kernel, Simd};
use eosphor_core::ray::{Hit, PrimitiveId, Ray};
use std::mem::MaybeUninit;

/// The rays of a leg as single ones, made when they are first needed.
pub(super) struct SingleRays {
    made: u32,
    rays: [MaybeUninit<SingleRay>; 16],
}

impl SingleRays {
    #[inline(always)]
    pub(super) fn none() -> SingleRays {
        SingleRays { made: 0, rays: [const { MaybeUninit::uninit() }; 16] }
    }

    /// Makes those of `lanes` that are not there yet.
    #[inline(always)]
    fn make<S: Simd>(&mut self, leg: &Leg<S>, lanes: u32) {
        let mut missing = lanes & !self.made;
        if missing == 0 {
            return;
        }
        self.made |= missing;
        let (origin, direction) = (arrays::<S>(&leg.ray.origin), arrays::<S>(&leg.ray.direction));
        let t_min = leg.ray.t_min.to_array();
        while missing != 0 {
            let lane = missing.trailing_zeros() as usize & 15;
            missing &= missing - 1;
            let (o, d) = (lane_of(&origin, lane), lane_of(&direction, lane));
            self.rays[lane].write(SingleRay::new::<S>(o, d, t_min.as_ref()[lane], leg.extent));
        }
    }

    /// # Safety
    /// It has been made.
    #[inline(always)]
    unsafe fn get(&self, lane: usize) -> &SingleRay {
        debug_assert!(self.made >> lane & 1 == 1);
        // SAFETY: the caller's.
        unsafe { self.rays[lane].assume_init_ref() }
    }
}

impl<S: Simd> Packet<S> {
    /// Goes on with some lanes one by one, from a node of the leg's tree.
    #[inline(always)]
    pub(super) unsafe fn go_on_alone<const QUERY: Query, const INSTANCES: bool>(
        &mut self,
        query: &Query16<S>,
        at: Child,
        leg: &Leg<S>,
        singles: &mut SingleRays,
        lanes: u32,
    ) {
        let alone = Alone::<S, QUERY, INSTANCES> { packet: self, query, at, leg, singles, lanes };
        // SAFETY: the caller's.
        unsafe { S::run(alone) };
    }
}

/// Lanes that go on one by one: a function of its own, since it is large.
struct Alone<'a, 'b, S: Simd, const QUERY: Query, const INSTANCES: bool> {
    packet: &'a mut Packet<S>,
    query: &'a Query16<'b, S>,
    at: Child,
    leg: &'a Leg<S>,
    singles: &'a mut SingleRays,
    lanes: u32,
}

/// A lane of a vector in memory.
///
/// # Safety
/// `lane` is below 16.
#[inline(always)]
unsafe fn lane_in<F: Float>(vector: &mut F, lane: usize) -> *mut f32 {
    // SAFETY: a vector is as many floats one after the other.
    unsafe { (vector as *mut F).cast::<f32>().add(lane) }
}

impl<S: Simd, const QUERY: Query, const INSTANCES: bool> Kernel for Alone<'_, '_, S, QUERY, INSTANCES> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<X: Simd>(self) {
        let Alone { packet, query, at, leg, singles, mut lanes } = self;
        let bvh = query.bvh;
        if !INSTANCES {
            singles.make(leg, lanes);
        }
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 15;
            lanes &= lanes - 1;
            // SAFETY: the lane is below 16; the rest is the caller's.
            unsafe {
                let t_max = lane_in(&mut packet.t_max, lane);
                let best = &mut packet.best;
                let (u, v) = (lane_in(&mut best.u, lane), lane_in(&mut best.v, lane));
                let (primitive, instance) =
                    (lane_in(&mut best.primitive, lane), lane_in(&mut best.instance, lane));
                let id = PrimitiveId { instance: (*instance).to_bits(), primitive: (*primitive).to_bits() };
                let hit = Hit { t: *t_max, u: *u, v: *v, id };
                let mut found = Found { best: hit, ..Found::nothing(hit.t) };
                let filter = query.filters[lane];
                if INSTANCES {
                    let (origin, direction) = (arrays::<S>(&packet.origin), arrays::<S>(&packet.direction));
                    let (origin, direction) = (lane_of(&origin, lane), lane_of(&direction, lane));
                    let t_min = packet.t_min.to_array().as_ref()[lane];
                    let ray = Ray { origin, t_min, direction, t_max: hit.t };
                    single::trace_instances::<S, QUERY>(bvh, at, &ray, filter, &mut found);
                } else {
                    let world_interval = match &leg.world_interval {
                        Some((near, far)) => (near.to_array().as_ref()[lane], far.to_array().as_ref()[lane]),
                        None => (f32::NEG_INFINITY, f32::INFINITY),
                    };
                    let place = single::Place { instance: leg.instance, world_interval };
                    let ray = singles.get(lane);
                    single::search::<S, QUERY>(bvh, at, ray, &place, filter, &mut found);
                    settle::<S, QUERY>(bvh, ray, leg.instance, &mut found);
                }
                if QUERY == ANY {
                    if found.any {
                        *t_max = f32::NEG_INFINITY;
                    }
                } else if found.best.id != id || found.best.t < hit.t {
                    (*t_max, *u, *v) = (found.best.t, found.best.u, found.best.v);
                    *primitive = f32::from_bits(found.best.id.primitive);
                    *instance = f32::from_bits(found.best.id.instance);
                }
            }
        }
    }
}
