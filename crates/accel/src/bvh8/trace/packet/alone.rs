//! Rays of a packet that go on one by one.

use super::decide::world_ray;
use super::{LocalPacket, Packet, Query16};
use crate::bvh8::Child;
use crate::bvh8::trace::found::{ANY, Query};
use crate::bvh8::trace::single;
use crate::bvh8::trace::single_ray::SingleRay;
use crate::bvh8::view::Bvh8View;
use crate::simd::{Kernel, Simd};
use eosphor_core::hierarchy::IgnoreWork;
use eosphor_core::ray::Ray;
use std::mem::MaybeUninit;

/// The rays of a leg as single ones, made when they are first needed.
pub(super) struct SingleRays<'a> {
    made: u32,
    /// Of these, the ones that pass by everything, which are not written.
    gone: u32,
    rays: [MaybeUninit<SingleRay<'a>>; 16],
}

impl<'a> SingleRays<'a> {
    /// None so far, in memory that is not written otherwise (it is large).
    #[inline(always)]
    pub(super) fn none<'r, const N: usize>(
        room: &'r mut MaybeUninit<[SingleRays<'a>; N]>,
    ) -> &'r mut [SingleRays<'a>; N] {
        let first = room.as_mut_ptr().cast::<SingleRays>();
        let mut k = 0;
        // SAFETY: written places: there is room for N, and of what is not written here no bit is set, so it is not read.
        unsafe {
            while k < N {
                (&raw mut (*first.add(k)).made).write(0);
                (&raw mut (*first.add(k)).gone).write(0);
                k += 1;
            }
            room.assume_init_mut()
        }
    }

    /// Makes those of `lanes` that are not there yet.
    #[inline(always)]
    fn make<S: Simd>(&mut self, leg: &LocalPacket<S>, query: &Query16<'a, S>, lanes: u32) {
        let mut missing = lanes & !self.made;
        self.made |= missing;
        while missing != 0 {
            let lane = missing.trailing_zeros() as usize & 15;
            missing &= missing - 1;
            let ray = world_ray(leg, lane);
            if leg.instance == 0 && SingleRay::is_usual(&ray, query.bvh.near) {
                self.rays[lane].write(SingleRay::of_world::<S>(&ray, query.bvh.world));
                continue;
            }
            let (bvh, instance) = (query.bvh, leg.instance);
            let unusual = Unusual { bvh, ray, instance, to: &mut self.rays[lane] };
            // SAFETY: instruction set: this runs below a kernel's.
            self.gone |= u32::from(!unsafe { S::run(unusual) }) << lane;
        }
    }

    /// # Safety
    /// It has been made, and does not pass by.
    #[inline(always)]
    unsafe fn get(&self, lane: usize) -> &SingleRay<'a> {
        debug_assert!((self.made & !self.gone) >> lane & 1 == 1);
        // SAFETY: written places: the ray has been made, as promised to this function.
        unsafe { self.rays[lane].assume_init_ref() }
    }
}

/// Makes a ray that is not usual or in an object's space; whether it does not pass by everything. A function of its own, since
/// it is rare.
struct Unusual<'a, 'b> {
    bvh: &'a Bvh8View<'a>,
    ray: Ray,
    instance: u32,
    to: &'b mut MaybeUninit<SingleRay<'a>>,
}

impl Kernel for Unusual<'_, '_> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<S: Simd>(self) -> bool {
        let Unusual { bvh, ray, instance: number, to } = self;
        let instance = &bvh.instances[number as usize];
        let geometry = instance.geometry as usize;
        let (size, bounds) = (bvh.size_of(geometry), &bvh.bounds[geometry]);
        let made = if number == 0 {
            SingleRay::of_any::<S>(&ray, size, bounds)
        } else {
            SingleRay::of_object::<S>(&ray, &instance.object_from_world, size, bounds)
        };
        made.map(|made| to.write(made)).is_some()
    }
}

impl<S: Simd> Packet<S> {
    /// Goes on with some lanes one by one, from a node of the leg's tree.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Closed view: `at` is a child of the tree.
    #[inline(always)]
    pub(super) unsafe fn go_on_alone<'a, const QUERY: Query, const INSTANCES: bool>(
        &mut self,
        query: &Query16<'a, S>,
        at: Child,
        leg: &LocalPacket<S>,
        singles: &mut SingleRays<'a>,
        lanes: u32,
    ) {
        let alone = Alone::<S, QUERY, INSTANCES> { packet: self, query, at, leg, singles, lanes };
        // SAFETY: instruction set: this runs below a kernel's.
        unsafe { S::run(alone) };
    }
}

/// Lanes that go on one by one: a function of its own, since it is large.
struct Alone<'a, 'b, 'l, S: Simd, const QUERY: Query, const INSTANCES: bool> {
    packet: &'a mut Packet<S>,
    query: &'a Query16<'b, S>,
    at: Child,
    leg: &'a LocalPacket<'l, S>,
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
            lanes &= !singles.gone;
        }
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 15;
            lanes &= lanes - 1;
            // SAFETY: instruction set: a kernel is run below its own. Lanes: the lane is below 16. Written places: its ray has been
            // made. Closed view: `at` is a child of the tree, as promised to `go_on_alone`.
            unsafe {
                let end = &mut *(&raw mut packet.end).cast::<f32>().add(lane);
                let mut found = packet.best.found(lane, *end);
                let before = (found.best.t, found.best.id);
                let filter = query.filters[lane];
                if INSTANCES {
                    single::trace_instances::<S, _, QUERY>(
                        bvh,
                        at,
                        &world_ray(leg, lane),
                        filter,
                        IgnoreWork,
                        &mut found,
                    );
                } else {
                    let ray = singles.get(lane);
                    ray.enter(&mut found);
                    single::search::<S, _, QUERY>(bvh, at, ray, leg.instance, filter, IgnoreWork, &mut found);
                }
                if QUERY == ANY {
                    if found.any {
                        *end = f32::NEG_INFINITY;
                    }
                } else if before != (found.best.t, found.best.id) {
                    packet.best.take_over(lane, &found, end);
                }
            }
        }
    }
}
