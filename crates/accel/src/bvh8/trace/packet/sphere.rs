//! A sphere against sixteen rays.

use super::decide::world_ray;
use super::{LocalPacket, Packet, Query16};
use crate::bvh8::trace::found::{ANY, NO_TRIANGLE, Offer, Query};
use crate::simd::{Kernel, Simd};
use eosphor_core::intersect::{LocalRay, TriangleHit, intersect_sphere, may_meet_sphere};
use eosphor_core::ray::PrimitiveId;

impl<S: Simd> Packet<S> {
    /// Tests a sphere; whether any ray has a new hit.
    ///
    /// # Safety
    /// Instruction set: the CPU has it.
    #[inline(always)]
    pub(super) unsafe fn test_sphere<const QUERY: Query>(
        &mut self,
        query: &Query16<S>,
        number: u32,
        leg: &LocalPacket<S>,
        lanes: u32,
    ) -> bool {
        // SAFETY: instruction set: promised to this function.
        unsafe { S::run(SphereTest::<S, QUERY> { packet: self, query, number, leg, lanes }) }
    }
}

/// A sphere against the rays, one by one: a function of its own, since it is rare and large.
struct SphereTest<'a, 'b, 'l, S: Simd, const QUERY: Query> {
    packet: &'a mut Packet<S>,
    query: &'a Query16<'b, S>,
    number: u32,
    leg: &'a LocalPacket<'l, S>,
    lanes: u32,
}

impl<S: Simd, const QUERY: Query> Kernel for SphereTest<'_, '_, '_, S, QUERY> {
    type Output = bool;

    #[inline(always)]
    unsafe fn run<X: Simd>(self) -> bool {
        let SphereTest { packet, query, number, leg, lanes: mut left } = self;
        let bvh = query.bvh;
        let sphere = &bvh.spheres[number as usize];
        let id = PrimitiveId { instance: leg.instance, primitive: bvh.sphere_primitives[number as usize] };
        let map = (leg.instance != 0).then(|| &bvh.instances[leg.instance as usize].object_from_world);
        let mut changed = false;
        while left != 0 {
            let lane = left.trailing_zeros() as usize & 15;
            left &= left - 1;
            let ray = world_ray(leg, lane);
            let local = match map {
                Some(map) => LocalRay::mapped(&ray, map, leg.extent),
                None => LocalRay::new(&ray, leg.extent),
            };
            if !may_meet_sphere(&local, sphere) {
                continue;
            }
            // SAFETY: lanes: a vector is sixteen floats; the lane is below 16.
            let end = unsafe { &mut *(&raw mut packet.end).cast::<f32>().add(lane) };
            for crossing in intersect_sphere(sphere, &ray, map) {
                // Roots that are not hits are NaN.
                if crossing.t.is_nan() {
                    continue;
                }
                if QUERY == ANY {
                    *end = f32::NEG_INFINITY;
                    changed = true;
                    break;
                }
                let mut found = packet.best.found(lane, *end);
                let hit = TriangleHit::of_sphere(&crossing);
                found.offer::<QUERY>(&Offer { bvh, ray: &ray, hit, id, place: NO_TRIANGLE });
                packet.best.take_over(lane, &found, end);
                changed = true;
            }
        }
        changed
    }
}
