//! Filtered queries give what is left when core's tests of all primitives are filtered one by one.

use crate::check::Asked;
use crate::fused::Fused;
use crate::support::{Random, World};
use crate::ways::Structures;
use eosphor_accel::{SimdLevel, closest_hit_where, occluded_where};
use eosphor_core::hierarchy::{IgnoreWork, Tracer};
use eosphor_core::intersect::{LocalRay, PackedTriangle, intersect_sphere, intersect_triangle, t_rest};
use eosphor_core::ray::{Hit, PrimitiveId, Ray, RayFilter, UNKNOWN_REST};

/// Closures that say which hits count, by number.
const CLOSURES: usize = 6;

/// What closure `number` says about a hit.
fn accepts(number: usize, hit: &Hit) -> bool {
    let id = hit.id;
    match number {
        0 => true,
        1 => (id.primitive ^ id.instance) & 1 == 0,
        2 => id.primitive.wrapping_mul(0x9e37_79b9) >> 29 == 0,
        // An alpha test: a chequered texture.
        3 => ((hit.u * 8.0) as i32 ^ (hit.v * 8.0) as i32) & 1 == 0,
        4 => hit.t > 1.0,
        _ => false,
    }
}

/// A hit, and its `t` in double precision.
struct Candidate {
    hit: Hit,
    t: f64,
}

/// All hits of a ray in the instances that are seen.
fn candidates(world: &World, (ray, filter): &Asked, is_seen: impl Fn(u32) -> bool) -> Vec<Candidate> {
    let mut all = Vec::new();
    // A ray with numbers out of range in the world hits nothing anywhere.
    if LocalRay::new(ray, world.geometries[0].extent).t_min.is_nan() {
        return all;
    }
    for (number, instance) in (0..).zip(&world.instances) {
        if !is_seen(number) {
            continue;
        }
        let geometry = &world.geometries[instance.geometry as usize];
        let map = (number > 0).then_some(&instance.object_from_world);
        let local = match map {
            Some(map) => LocalRay::mapped(ray, map, geometry.extent),
            None => LocalRay::new(ray, geometry.extent),
        };
        for primitive in 0..geometry.triangle_count {
            let corners = world.triangles[(geometry.first_triangle + primitive) as usize];
            let triangle = PackedTriangle::new(corners, primitive);
            let id = PrimitiveId { instance: number, primitive };
            let is_culled = filter.cull_back_faces && !triangle.first_step(&local).meets_front;
            let h = intersect_triangle(&triangle, ray, map, geometry.extent);
            if h.meets && !is_culled && !filter.skips(id) {
                let unknown = h.t_rest == UNKNOWN_REST;
                let rest = if unknown { t_rest(&triangle, h.t, ray, map) } else { h.t_rest };
                let hit = Hit { t: h.t, t_rest: h.t_rest, u: h.u, v: h.v, id };
                all.push(Candidate { hit, t: f64::from(h.t) + f64::from(rest) });
            }
        }
        for sphere in 0..geometry.sphere_count {
            let id = PrimitiveId { instance: number, primitive: geometry.triangle_count + sphere };
            let shape = &world.spheres[(geometry.first_sphere + sphere) as usize];
            for h in intersect_sphere(shape, ray, map) {
                if !h.t.is_nan() && !local.t_min.is_nan() {
                    let hit = Hit { t: h.t, t_rest: h.t_rest, u: 0.0, v: 0.0, id };
                    all.push(Candidate { hit, t: hit.t64() });
                }
            }
        }
    }
    all
}

/// The first of those that count.
fn first(candidates: &[Candidate], ray: &Ray, closure: usize) -> Hit {
    let left = candidates.iter().filter(|c| accepts(closure, &c.hit));
    let key = |c: &&Candidate| (c.hit.id.instance, c.hit.id.primitive);
    let best = left.min_by(|a, b| a.t.total_cmp(&b.t).then_with(|| key(a).cmp(&key(b))));
    best.map_or(Hit::miss(ray.t_max), |c| c.hit)
}

fn bits(h: &Hit) -> (u32, u32, u32, PrimitiveId) {
    (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.id)
}

/// Compares the filtered queries of all 8-wide hierarchies, and those by [`closest_hit_where`] of some other structures.
pub(crate) fn check(world: &World, structures: &Structures, asked: &[Asked], random: &mut Random) {
    let masks: Vec<u32> = world.instances.iter().map(|_| 1 << random.below(3)).collect();
    for one in asked {
        let (ray, filter) = one;
        let mask = random.below(8) as u32;
        let everywhere = candidates(world, one, |_| true);
        let seen = candidates(world, one, |instance| masks[instance as usize] & mask != 0);
        for closure in 0..CLOSURES {
            let [all, some] = [&everywhere, &seen].map(|c| first(c, ray, closure));
            let accept = |hit: &Hit| accepts(closure, hit);
            for (name, bvh8) in &structures.bvh8s {
                for level in SimdLevel::available() {
                    let tracer = bvh8.tracer_at(level).expect("it is available");
                    let masked = tracer.with_masks(&masks, mask);
                    let about = || format!("{name} at {level}, closure {closure}, mask {mask}: {one:?}");
                    let hit = tracer.closest_hit_where(ray, filter, accept);
                    assert_eq!((bits(&hit), hit.t_rest), (bits(&all), all.t_rest), "{}", about());
                    let hit = masked.closest_hit_where(ray, filter, accept);
                    assert_eq!((bits(&hit), hit.t_rest), (bits(&some), some.t_rest), "{}", about());
                    let occluded = tracer.occluded_where(ray, filter, accept);
                    assert_eq!(occluded, !all.is_miss(), "{}", about());
                    let occluded = masked.occluded_where(ray, filter, accept);
                    assert_eq!(occluded, !some.is_miss(), "{}", about());
                    if closure == 0 {
                        check_chain(&masked, ray, filter, &seen, &about());
                    }
                }
            }
            let octree = Fused(structures.octrees[0].1.parametric_tracer(IgnoreWork));
            check_any_structure(&octree, one, closure, &all);
            check_any_structure(&structures.bvh8s[0].1.tracer(), one, closure, &all);
            let exhaustive = Fused(structures.exhaustive.tracer(IgnoreWork));
            check_any_structure(&exhaustive, one, closure, &all);
        }
    }
}

/// Compares the function that works with any structure.
fn check_any_structure(tracer: &impl Tracer, (ray, filter): &Asked, closure: usize, expected: &Hit) {
    let accept = |hit: &Hit| accepts(closure, hit);
    let hit = closest_hit_where(tracer, ray, filter, accept);
    assert_eq!(bits(&hit), bits(expected), "closure {closure}: {ray:?} {filter:?}");
    assert_eq!(occluded_where(tracer, ray, filter, accept), !expected.is_miss());
}

/// Follows the first hits of a ray, each from the one before.
fn check_chain(tracer: &impl Tracer, ray: &Ray, filter: &RayFilter, seen: &[Candidate], about: &str) {
    let mut sorted: Vec<&Candidate> = seen.iter().collect();
    let key = |c: &Candidate| (c.hit.id.instance, c.hit.id.primitive);
    sorted.sort_by(|a, b| a.t.total_cmp(&b.t).then_with(|| key(a).cmp(&key(b))));
    // A ray that touches a sphere meets it twice at one place: that is one hit.
    sorted.dedup_by(|a, b| a.t == b.t && key(a) == key(b));
    let mut hit = Hit::miss(f32::NEG_INFINITY);
    for candidate in sorted.iter().take(4) {
        hit = tracer.next_hit(ray, filter, &hit);
        assert_eq!(bits(&hit), bits(&candidate.hit), "{about}");
        assert_eq!(hit.t64().to_bits(), candidate.t.to_bits(), "{about}");
    }
    if sorted.len() < 4 {
        assert!(tracer.next_hit(ray, filter, &hit).is_miss(), "{about}");
    }
}
