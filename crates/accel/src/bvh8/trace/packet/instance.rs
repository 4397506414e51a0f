//! What an instance places, for sixteen rays.

use super::alone::SingleRays;
use super::{LocalPacket, MaskOf, Packet, Query16, walk_octants};
use crate::bvh8::EMPTY;
use crate::bvh8::trace::found::Query;
use crate::bvh8::trace::lanes::LocalV;
use crate::simd::{Float, Mask, Simd, splat3};
use std::mem::MaybeUninit;

impl<S: Simd> Packet<S> {
    /// Searches what an instance places; whether any ray may have a new hit.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Closed view: the instance is there.
    #[inline(always)]
    pub(super) unsafe fn visit_instance<const QUERY: Query>(
        &mut self,
        query: &Query16<S>,
        number: u32,
        world: &LocalPacket<S>,
        active: MaskOf<S>,
    ) -> bool {
        let bvh = query.bvh;
        let instance = &bvh.instances[number as usize];
        let low = splat3(instance.world_bounds.min);
        let high = splat3(instance.world_bounds.max);
        let (near, far) = world.local.slab.interval(&low, &high, world.local.t_min);
        let active = active.and(near.le(far.min(self.end)));
        if !active.any() {
            return false;
        }
        let rays = world.world;
        let geometry = instance.geometry as usize;
        let extent = bvh.geometries[geometry].extent;
        let own = rays.mapped(&instance.object_from_world);
        let (mut local, usual) = LocalV::of_object(rays, &own, extent);
        usual.mend_others::<S>(&own, &mut local);
        let leg = LocalPacket { own: &own, local: &local, extent, instance: number, world: rays };
        let active = active.and(S::F16::splat(0.0).le(leg.local.t_min));
        let root = bvh.roots[geometry];
        let (mut room, mut singles) = (MaybeUninit::uninit(), MaybeUninit::uninit());
        let singles = SingleRays::none::<1>(&mut singles);
        let far = leg.far_from(&bvh.bounds[geometry]);
        // SAFETY: instruction set: promised to this function. Closed view: the root is the geometry's.
        unsafe {
            walk_octants::<S, QUERY, false, 1>(
                std::array::from_mut(self),
                std::array::from_ref(query),
                root,
                &[leg],
                singles,
                [active.without(far)],
                &mut room,
            );
            let alone = active.and(far).bits();
            if alone != 0 && root != EMPTY {
                let [singles] = singles;
                self.go_on_alone::<QUERY, false>(query, root, &leg, singles, alone);
            }
        }
        true
    }
}
