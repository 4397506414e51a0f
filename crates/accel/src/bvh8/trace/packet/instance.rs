//! What an instance places, for sixteen rays.

use super::alone::SingleRays;
use super::{Leg, MaskOf, Packet, Query16};
use crate::bvh8::trace::lanes::RayV;
use crate::bvh8::trace::walk::Query;
use crate::simd::{Float, Mask, Simd, along, each, splat3};

impl<S: Simd> Packet<S> {
    /// Searches what an instance places; whether any ray may have a new hit.
    #[inline(always)]
    pub(super) unsafe fn visit_instance<const QUERY: Query>(
        &mut self,
        query: &Query16<S>,
        number: u32,
        world: &Leg<S>,
        active: MaskOf<S>,
    ) -> bool {
        let bvh = query.bvh;
        let instance = &bvh.instances[number as usize];
        let low = splat3(instance.world_bounds.min);
        let high = splat3(instance.world_bounds.max);
        let (near, far) = world.ray.slab.interval(&low, &high, world.ray.t_min);
        let active = active.and(near.le(far.min(self.t_max)));
        if !active.any() {
            return false;
        }
        let map = &instance.object_from_world;
        let c = each!(k => splat3::<S::F16>(map.columns[k]));
        let (o, d) = (&self.origin, &self.direction);
        let from = along(&splat3(map.translation), &c[0], o[0]);
        let origin = along(&along(&from, &c[1], o[1]), &c[2], o[2]);
        let from = each!(k => c[0][k].mul(d[0]));
        let direction = along(&along(&from, &c[1], d[1]), &c[2], d[2]);
        let extent = bvh.geometries[instance.geometry as usize].extent;
        let ray = RayV::new::<S>(origin, direction, self.t_min, extent);
        let after = near.max(ray.t_min);
        let leg = Leg { ray, extent, instance: number, world_interval: Some((near, far)), after };
        let active = active.and(S::F16::splat(0.0).le(leg.ray.t_min));
        let root = bvh.roots[instance.geometry as usize];
        let mut singles = SingleRays::none();
        // SAFETY: the caller's.
        unsafe { self.walk_octants::<QUERY, false>(query, root, &leg, &mut singles, active) };
        true
    }
}
