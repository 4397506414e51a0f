//! A sphere against sixteen rays.

use super::{Best, Leg, MaskOf, arrays, lane_of};
use crate::bvh8::trace::lanes::ConfirmedV;
use crate::bvh8::trace::walk::Query;
use crate::bvh8::view::Bvh8View;
use crate::simd::{Float, Kernel, Mask, Simd};
use eosphor_core::geometry::Sphere;
use eosphor_core::intersect::{LocalRay, intersect_sphere};

impl<S: Simd> Best<S> {
    /// Tests a sphere; whether any ray has a new hit.
    #[inline(always)]
    pub(super) unsafe fn test_sphere<const QUERY: Query>(
        &mut self,
        bvh: &Bvh8View,
        number: usize,
        leg: &Leg<S>,
        lanes: u32,
        t_max: &mut S::F16,
    ) -> bool {
        // SAFETY: the caller's.
        let roots = unsafe { S::run(SphereTest { leg, sphere: &bvh.spheres[number], lanes }) };
        let zero = S::F16::splat(0.0);
        let (mut changed, mut root) = (false, 0);
        while root < 2 {
            // SAFETY: sixteen floats.
            let t = unsafe { S::F16::load(roots[root].as_ptr()) };
            // Roots that are not hits are NaN.
            let counts = t.le(t).and(MaskOf::<S>::from_bits(lanes));
            let hits = ConfirmedV { counts, unsure: MaskOf::<S>::from_bits(0), t, u: zero, v: zero };
            changed |= self.offer::<QUERY>(&hits, leg, bvh.sphere_primitives[number], t_max);
            root += 1;
        }
        changed
    }
}

/// A sphere against the rays, one by one: a function of its own, since it is rare and large.
struct SphereTest<'a, S: Simd> {
    leg: &'a Leg<S>,
    sphere: &'a Sphere,
    lanes: u32,
}

impl<S: Simd> Kernel for SphereTest<'_, S> {
    type Output = [[f32; 16]; 2];

    #[inline(always)]
    unsafe fn run<X: Simd>(self) -> [[f32; 16]; 2] {
        let leg = self.leg;
        let (origin, direction) = (arrays::<S>(&leg.ray.origin), arrays::<S>(&leg.ray.direction));
        let t_min = leg.ray.t_min.to_array();
        let mut roots = [[f32::NAN; 16]; 2];
        let mut left = self.lanes;
        while left != 0 {
            let lane = left.trailing_zeros() as usize & 15;
            left &= left - 1;
            let (o, d) = (lane_of(&origin, lane), lane_of(&direction, lane));
            let ray = LocalRay::new(o, d, t_min.as_ref()[lane], leg.extent);
            [roots[0][lane], roots[1][lane]] = intersect_sphere(&ray, self.sphere);
        }
        roots
    }
}
