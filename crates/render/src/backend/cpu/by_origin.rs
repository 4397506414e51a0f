//! Packets for rays that stand one after the other in a batch and start at one place.

use eosphor_accel::{BatchTracer, Coherence, Filters};
use eosphor_core::hierarchy::{ShadowBatch, Tracer};
use eosphor_core::ray::{Hit, Ray, RayFilter};

/// Rays in a packet.
const LANES: usize = 16;

/// Takes batches apart into what a [`Tracer`] does well: rays from one point that leave out the same go through
/// [`Tracer::occluded_batch`], all others one by one.
pub(crate) struct ByOrigin<T>(pub(crate) T);

impl<T: Tracer> Tracer for ByOrigin<T> {
    #[inline(always)]
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        self.0.closest_hit(ray, filter)
    }
    #[inline(always)]
    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        self.0.occluded(ray, filter)
    }
    #[inline(always)]
    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        self.0.next_hit(ray, filter, after)
    }
    #[inline(always)]
    fn occluded_batch<const W: usize>(
        &self,
        batch: &ShadowBatch<W>,
        filter: &RayFilter,
        active: &[bool; W],
    ) -> [bool; W] {
        self.0.occluded_batch(batch, filter, active)
    }
}

impl<T: Tracer> BatchTracer for ByOrigin<T> {
    #[inline(always)]
    fn closest_hits(&self, rays: &[Ray], filters: Filters, _: Coherence, hits: &mut [Hit]) {
        for k in 0..rays.len() {
            hits[k] = self.0.closest_hit(&rays[k], filters.of(k));
        }
    }

    #[inline(always)]
    fn occluded_rays(&self, rays: &[Ray], filters: Filters, _: Coherence, hidden: &mut [bool]) {
        let mut first = 0;
        while first < rays.len() {
            let (origin, filter) = (rays[first].origin, filters.of(first));
            let none = [0.0; LANES];
            let mut batch = ShadowBatch { origin, x: none, y: none, z: none, t_max: none };
            let mut active = [false; LANES];
            let mut count = 0;
            while count < LANES && first + count < rays.len() {
                let ray = &rays[first + count];
                // A packet's rays begin at 0.
                if ray.origin != origin || ray.t_min != 0.0 || filters.of(first + count) != filter {
                    break;
                }
                let d = ray.direction;
                (batch.x[count], batch.y[count], batch.z[count]) = (d.x, d.y, d.z);
                (batch.t_max[count], active[count]) = (ray.t_max, true);
                count += 1;
            }
            if count > 1 {
                // Lanes that are not active go where the first one goes.
                for lane in count..LANES {
                    (batch.x[lane], batch.y[lane], batch.z[lane]) = (batch.x[0], batch.y[0], batch.z[0]);
                }
                let answers = self.0.occluded_batch(&batch, filter, &active);
                hidden[first..first + count].copy_from_slice(&answers[..count]);
            } else {
                count = 1;
                hidden[first] = self.0.occluded(&rays[first], filter);
            }
            first += count;
        }
    }

    #[inline(always)]
    fn next_hits(&self, rays: &[Ray], filters: Filters, _: Coherence, hits: &mut [Hit]) {
        for k in 0..rays.len() {
            hits[k] = self.0.next_hit(&rays[k], filters.of(k), &hits[k]);
        }
    }
}
