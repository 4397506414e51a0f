//! A sphere against sixteen rays.

use super::decide::world_ray;
use super::{LocalPacket, Packet, Query16};
use crate::bvh8::trace::found::{ANY, CLOSEST, NO_TRIANGLE, Offer, Query};
use crate::simd::{Float, Kernel, Simd, each};
use eosphor_core::geometry::Sphere;
use eosphor_core::intersect::precise::PreciseRay;
use eosphor_core::intersect::{LocalRay, SphereHit, TriangleHit, intersect_sphere, may_meet_sphere};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::{PrimitiveId, Ray};

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
        let mut roots = None;
        if map.is_none() & (left.count_ones() >= FEW_LANES) {
            left &= may_meet(leg, sphere);
            if left.count_ones() >= FEW_LANES {
                roots = Some(Roots::new(leg, sphere));
            }
        }
        while left != 0 {
            let lane = left.trailing_zeros() as usize & 15;
            left &= left - 1;
            let ray = world_ray(leg, lane);
            let crossings = match &roots {
                Some(roots) => roots.crossings(lane, &ray),
                None => {
                    let local = match map {
                        Some(map) => LocalRay::mapped(&ray, map, leg.extent),
                        None => LocalRay::new(&ray, leg.extent),
                    };
                    if !may_meet_sphere(&local, sphere) {
                        continue;
                    }
                    intersect_sphere(sphere, &ray, map)
                }
            };
            // SAFETY: lanes: a vector is sixteen floats; the lane is below 16.
            let end = unsafe { &mut *(&raw mut packet.end).cast::<f32>().add(lane) };
            for crossing in crossings {
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
                // The second one is farther.
                if QUERY == CLOSEST {
                    break;
                }
            }
        }
        changed
    }
}

/// From so many lanes on, double precision is computed for all lanes at once.
const FEW_LANES: u32 = 3;

/// Vectors of all lanes, component by component.
type Vectors<S> = [<<S as Simd>::F16 as Float>::Array; 3];

#[inline(always)]
fn vector<S: Simd>(v: &Vectors<S>, lane: usize) -> Vec3 {
    vec3(v[0].as_ref()[lane], v[1].as_ref()[lane], v[2].as_ref()[lane])
}

/// Bits of the lanes whose rays of the world may meet a sphere, in single precision.
#[inline(always)]
fn may_meet<S: Simd>(leg: &LocalPacket<S>, sphere: &Sphere) -> u32 {
    let [o, d] = [&leg.world.origin, &leg.world.direction].map(|v| each!(k => v[k].to_array()));
    let (t_min, t_max) = (leg.world.t_min.to_array(), leg.world.t_max.to_array());
    let mut may_meet = [0u32; 16];
    // A loop that becomes SIMD code.
    for lane in 0..16 {
        let (origin, direction) = (vector::<S>(&o, lane), vector::<S>(&d, lane));
        let ray = Ray { origin, t_min: t_min.as_ref()[lane], direction, t_max: t_max.as_ref()[lane] };
        may_meet[lane] = u32::from(may_meet_sphere(&LocalRay::new(&ray, leg.extent), sphere));
    }
    (0..16).fold(0, |bits, lane| bits | may_meet[lane] << lane)
}

/// Where rays of the world pass through a sphere's surface, in double precision; NaN where they do not.
struct Roots {
    t: [[f64; 16]; 2],
}

impl Roots {
    #[inline(always)]
    fn new<S: Simd>(leg: &LocalPacket<S>, sphere: &Sphere) -> Roots {
        let [o, d] = [&leg.world.origin, &leg.world.direction].map(|v| each!(k => v[k].to_array()));
        let mut t = [[0.0; 16]; 2];
        // As above.
        for lane in 0..16 {
            let wide = |v: Vec3| [f64::from(v.x), f64::from(v.y), f64::from(v.z)];
            let (origin, direction) = (wide(vector::<S>(&o, lane)), wide(vector::<S>(&d, lane)));
            let [first, second] = PreciseRay { origin, direction }.sphere_roots(sphere);
            (t[0][lane], t[1][lane]) = (first, second);
        }
        Roots { t }
    }

    /// As [`intersect_sphere`] finds them.
    #[inline(always)]
    fn crossings(&self, lane: usize, ray: &Ray) -> [SphereHit; 2] {
        // By `map`, sixteen numbers would be copied for one.
        let [first, second] = &self.t;
        [first[lane], second[lane]].map(|t| SphereHit::at(t, ray))
    }
}
