//! Rays of a packet that go on one by one.

use super::decide::world_ray;
use super::{Leg, Packet, Query16};
use crate::bvh8::Child;
use crate::bvh8::trace::single;
use crate::bvh8::trace::single_ray::SingleRay;
use crate::bvh8::trace::walk::{ANY, Query};
use crate::simd::{Kernel, Simd};
use std::mem::MaybeUninit;

/// The rays of a leg as single ones, made when they are first needed.
pub(super) struct SingleRays<'a> {
    made: u32,
    rays: [MaybeUninit<Option<SingleRay<'a>>>; 16],
}

impl<'a> SingleRays<'a> {
    #[inline(always)]
    pub(super) fn none() -> SingleRays<'a> {
        SingleRays { made: 0, rays: [const { MaybeUninit::uninit() }; 16] }
    }

    /// Makes those of `lanes` that are not there yet.
    #[inline(always)]
    fn make<S: Simd>(&mut self, leg: &Leg<S>, query: &Query16<'a, S>, lanes: u32) {
        let mut missing = lanes & !self.made;
        self.made |= missing;
        let instance = &query.bvh.instances[leg.instance as usize];
        let bounds = &query.bvh.bounds[instance.geometry as usize];
        while missing != 0 {
            let lane = missing.trailing_zeros() as usize & 15;
            missing &= missing - 1;
            let ray = world_ray(leg, lane);
            self.rays[lane].write(if leg.instance == 0 && SingleRay::is_usual(&ray, query.bvh.near) {
                Some(SingleRay::of_world::<S>(&ray, leg.extent))
            } else if leg.instance == 0 {
                SingleRay::of_any::<S>(&ray, leg.extent, bounds)
            } else {
                SingleRay::of_object::<S>(&ray, &instance.object_from_world, leg.extent, bounds)
            });
        }
    }

    /// `None` for a ray that passes by.
    ///
    /// # Safety
    /// It has been made.
    #[inline(always)]
    unsafe fn get(&self, lane: usize) -> Option<&SingleRay<'a>> {
        debug_assert!(self.made >> lane & 1 == 1);
        // SAFETY: the caller's.
        unsafe { self.rays[lane].assume_init_ref() }.as_ref()
    }
}

impl<S: Simd> Packet<S> {
    /// Goes on with some lanes one by one, from a node of the leg's tree.
    #[inline(always)]
    pub(super) unsafe fn go_on_alone<'a, const QUERY: Query, const INSTANCES: bool>(
        &mut self,
        query: &Query16<'a, S>,
        at: Child,
        leg: &Leg<S>,
        singles: &mut SingleRays<'a>,
        lanes: u32,
    ) {
        let alone = Alone::<S, QUERY, INSTANCES> { packet: self, query, at, leg, singles, lanes };
        // SAFETY: the caller's.
        unsafe { S::run(alone) };
    }
}

/// Lanes that go on one by one: a function of its own, since it is large.
struct Alone<'a, 'b, 'l, S: Simd, const QUERY: Query, const INSTANCES: bool> {
    packet: &'a mut Packet<S>,
    query: &'a Query16<'b, S>,
    at: Child,
    leg: &'a Leg<'l, S>,
    singles: &'a mut SingleRays<'b>,
    lanes: u32,
}

impl<S: Simd, const QUERY: Query, const INSTANCES: bool> Kernel for Alone<'_, '_, '_, S, QUERY, INSTANCES> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<X: Simd>(self) {
        let Alone { packet, query, at, leg, singles, mut lanes } = self;
        let bvh = query.bvh;
        if !INSTANCES {
            singles.make(leg, query, lanes);
        }
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 15;
            lanes &= lanes - 1;
            // SAFETY: the lane is below 16, and a vector is as many floats; the rest is the caller's.
            unsafe {
                let end = &mut *(&raw mut packet.end).cast::<f32>().add(lane);
                let mut found = packet.best.found(lane, *end);
                let filter = query.filters[lane];
                if INSTANCES {
                    single::trace_instances::<S, QUERY>(bvh, at, &world_ray(leg, lane), filter, &mut found);
                } else if let Some(ray) = singles.get(lane) {
                    ray.enter(&mut found);
                    single::search::<S, QUERY>(bvh, at, ray, leg.instance, filter, &mut found);
                }
                if QUERY == ANY {
                    if found.any {
                        *end = f32::NEG_INFINITY;
                    }
                } else {
                    packet.best.take_over(lane, &found, end);
                }
            }
        }
    }
}
