//! The queries that shading asks.

use crate::math::{Vec3, vec3};
use crate::ray::{Hit, Ray, RayFilter};

/// Answers queries about a scene. Every implementation gives the same answers, bit for bit, whatever the numbers of the
/// ray are: one with infinities or NaN hits nothing (see [`Ray`]).
pub trait Tracer {
    /// The nearest hit in `t_min < t <= t_max`; ties go to the lowest (instance, primitive).
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit;

    /// Whether there is any hit in `t_min < t <= t_max`.
    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool;

    /// The first hit that comes after `after` in the order of (t, instance, primitive).
    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit;

    /// [`Tracer::next_hit`], or without `after` [`Tracer::closest_hit`].
    #[inline(always)]
    fn hit_after(&self, ray: &Ray, filter: &RayFilter, after: Option<&Hit>) -> Hit {
        match after {
            Some(after) => self.next_hit(ray, filter, after),
            None => self.closest_hit(ray, filter),
        }
    }

    /// [`Tracer::occluded`] for rays from one origin; lanes that are not `active` answer `true`.
    #[inline(always)]
    fn occluded_batch<const W: usize>(
        &self,
        batch: &ShadowBatch<W>,
        filter: &RayFilter,
        active: &[bool; W],
    ) -> [bool; W] {
        let mut hidden = [true; W];
        let mut lane = 0;
        while lane < W {
            if active[lane] {
                hidden[lane] = self.occluded(&batch.ray(lane), filter);
            }
            lane += 1;
        }
        hidden
    }

    /// [`Tracer::occluded_batch`] in batches of sixteen rays, for tracers that take no more of them together.
    #[inline(always)]
    fn occluded_by_sixteens<const W: usize>(
        &self,
        batch: &ShadowBatch<W>,
        filter: &RayFilter,
        active: &[bool; W],
    ) -> [bool; W] {
        let mut hidden = [true; W];
        let mut first = 0;
        while first < W {
            let count = if W - first < 16 { W - first } else { 16 };
            let mut part = [false; 16];
            part[..count].copy_from_slice(&active[first..first + count]);
            let found = self.occluded_batch(&batch.sixteen(first), filter, &part);
            hidden[first..first + count].copy_from_slice(&found[..count]);
            first += 16;
        }
        hidden
    }
}

/// Rays from one point towards points of one light.
#[derive(Clone, Copy, Debug)]
pub struct ShadowBatch<const W: usize> {
    /// Where all start; hits must lie beyond `t = 0`.
    pub origin: Vec3,
    /// Unit directions, x of every ray.
    pub x: [f32; W],
    /// y of every ray.
    pub y: [f32; W],
    /// z of every ray.
    pub z: [f32; W],
    /// Hits must not lie beyond this.
    pub t_max: [f32; W],
}

impl<const W: usize> ShadowBatch<W> {
    /// The sixteen rays from lane `first` on; those past the last are the first ray of all.
    #[inline(always)]
    pub fn sixteen(&self, first: usize) -> ShadowBatch<16> {
        let none = [0.0; 16];
        let mut part = ShadowBatch { origin: self.origin, x: none, y: none, z: none, t_max: none };
        for lane in 0..16 {
            let from = if first + lane < W { first + lane } else { 0 };
            (part.x[lane], part.y[lane], part.z[lane]) = (self.x[from], self.y[from], self.z[from]);
            part.t_max[lane] = self.t_max[from];
        }
        part
    }

    /// One of the rays.
    #[inline(always)]
    pub fn ray(&self, lane: usize) -> Ray {
        Ray {
            origin: self.origin,
            t_min: 0.0,
            direction: vec3(self.x[lane], self.y[lane], self.z[lane]),
            t_max: self.t_max[lane],
        }
    }
}
