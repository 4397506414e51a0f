//! Asks every way about rays, and compares with no structure at all.

use crate::fused::Fused;
use crate::ways::{Structures, Way};
use eosphor_accel::Filters;
use eosphor_core::hierarchy::{IgnoreWork, ShadowBatch, Tracer};
use eosphor_core::ray::{Hit, PrimitiveId, Ray, RayFilter};

/// A ray and what it leaves out.
pub(crate) type Asked = (Ray, RayFilter);

/// Hits of a chain are followed so far.
const CHAIN: usize = 6;

type Bits = (u32, u32, u32, u32, PrimitiveId);

fn bits(h: &Hit) -> Bits {
    (h.t.to_bits(), h.t_rest.to_bits(), h.u.to_bits(), h.v.to_bits(), h.id)
}

fn assert_same(way: &str, query: &str, got: &Hit, expected: &Hit, ray: &Ray, filter: &RayFilter) {
    assert_eq!(
        bits(got),
        bits(expected),
        "{way}, {query}: {got:?} instead of {expected:?} for {ray:?} with {filter:?}"
    );
}

/// What no structure at all says about a ray.
struct Expected {
    closest: Hit,
    hidden: bool,
    /// The first hits; a miss at the end if there are no more.
    chain: Vec<Hit>,
}

impl Expected {
    fn new(structures: &Structures, (ray, filter): &Asked) -> Expected {
        let reference = Fused(structures.exhaustive.tracer(IgnoreWork));
        let closest = reference.closest_hit(ray, filter);
        let hidden = reference.occluded(ray, filter);
        let mut chain: Vec<Hit> = Vec::new();
        let mut after = Hit::miss(f32::NEG_INFINITY);
        while chain.len() < CHAIN && !chain.last().is_some_and(Hit::is_miss) {
            after = reference.next_hit(ray, filter, &after);
            chain.push(after);
        }
        let expected = Expected { closest, hidden, chain };
        expected.check(ray, filter, structures);
        expected
    }

    /// Whether the answers agree with each other and with the query.
    fn check(&self, ray: &Ray, filter: &RayFilter, structures: &Structures) {
        // Closest hits know the rest of their `t` only where they had to be computed in double precision.
        let first = Hit { t_rest: self.closest.t_rest, ..self.chain[0] };
        assert_same("reference", "chain", &first, &self.closest, ray, filter);
        assert_eq!(self.hidden, !self.closest.is_miss(), "{ray:?}");
        let primitives = &structures.exhaustive.primitives();
        for hit in &self.chain {
            if hit.is_miss() {
                assert_eq!(bits(hit), bits(&Hit::miss(ray.t_max)), "a miss says t_max: {ray:?}");
                continue;
            }
            assert!(hit.t > ray.t_min && hit.t <= ray.t_max && hit.t.is_finite(), "{hit:?} {ray:?}");
            // Spheres are not left out by number.
            let geometry = primitives.instances()[hit.id.instance as usize].geometry;
            let is_sphere = hit.id.primitive >= primitives.geometries()[geometry as usize].triangle_count;
            assert!(is_sphere || !filter.skips(hit.id), "{hit:?} {filter:?}");
        }
        for pair in self.chain.windows(2) {
            assert!(pair[1].is_miss() || pair[0].before(&pair[1]), "{pair:?} {ray:?}");
        }
    }
}

/// Compares all ways for these rays, which are asked in batches of the given sizes in turn; returns how many answers
/// were compared.
pub(crate) fn check(structures: &Structures, asked: &[Asked], sizes: &[usize]) -> usize {
    let expected: Vec<Expected> = asked.iter().map(|a| Expected::new(structures, a)).collect();
    let rays: Vec<Ray> = asked.iter().map(|a| a.0).collect();
    let filters: Vec<RayFilter> = asked.iter().map(|a| a.1).collect();
    let mut compared = 0;
    for way in structures.ways() {
        let (mut first, mut size) = (0, sizes.iter().cycle());
        while first < rays.len() {
            let count = (*size.next().unwrap()).min(rays.len() - first);
            let range = first..first + count;
            let all_one = filters[range.clone()].iter().all(|f| *f == filters[first]);
            let filters = if all_one {
                Filters::Shared(&filters[first])
            } else {
                Filters::Each(&filters[range.clone()])
            };
            check_batch(&way, &rays[range.clone()], filters, &expected[range]);
            compared += 2 * count;
            first += count;
        }
        compared += check_chains(&way, &rays, &filters, &expected);
    }
    compared
}

fn check_batch(way: &Way, rays: &[Ray], filters: Filters, expected: &[Expected]) {
    let nonsense =
        Hit { t: -1.0, t_rest: 0.5, u: 2.0, v: 3.0, id: PrimitiveId { instance: 4, primitive: 5 } };
    let mut hits = vec![nonsense; rays.len()];
    way.answers.closest(rays, filters, &mut hits);
    let mut hidden: Vec<bool> = expected.iter().map(|e| !e.hidden).collect();
    way.answers.occluded(rays, filters, &mut hidden);
    for (k, (ray, expected)) in rays.iter().zip(expected).enumerate() {
        assert_same(&way.name, "closest", &hits[k], &expected.closest, ray, filters.of(k));
        let (name, filter) = (&way.name, filters.of(k));
        assert_eq!(
            hidden[k], expected.hidden,
            "{name}, occluded: {:?} for {ray:?} with {filter:?}",
            expected.closest
        );
    }
}

/// Follows the hits of every third ray.
fn check_chains(way: &Way, rays: &[Ray], filters: &[RayFilter], expected: &[Expected]) -> usize {
    let some: Vec<usize> = (0..rays.len()).step_by(3).collect();
    let mut hits = vec![Hit::miss(f32::NEG_INFINITY); some.len()];
    let rays: Vec<Ray> = some.iter().map(|&k| rays[k]).collect();
    let filters: Vec<RayFilter> = some.iter().map(|&k| filters[k]).collect();
    for step in 0..CHAIN {
        way.answers.next(&rays, Filters::Each(&filters), &mut hits);
        let mut left = 0;
        for (place, &k) in some.iter().enumerate() {
            if let Some(hit) = expected[k].chain.get(step) {
                assert_same(&way.name, "next", &hits[place], hit, &rays[place], &filters[place]);
                left += 1;
            } else {
                // Where the chain has ended it starts again.
                hits[place] = Hit::miss(f32::NEG_INFINITY);
            }
        }
        if left == 0 {
            break;
        }
    }
    CHAIN * some.len()
}

/// Shadow rays from one point, many at a time, with these directions and ends.
pub(crate) fn check_shadows(structures: &Structures, rays: &[Ray], filter: &RayFilter) {
    for way in structures.ways() {
        let a = &way.answers;
        check_lanes::<1>(structures, &way.name, rays, filter, |b, s| a.shadows1(b, filter, s));
        check_lanes::<8>(structures, &way.name, rays, filter, |b, s| a.shadows8(b, filter, s));
        check_lanes::<16>(structures, &way.name, rays, filter, |b, s| a.shadows16(b, filter, s));
        check_lanes::<64>(structures, &way.name, rays, filter, |b, s| a.shadows64(b, filter, s));
    }
}

fn check_lanes<const W: usize>(
    structures: &Structures,
    name: &str,
    rays: &[Ray],
    filter: &RayFilter,
    ask: impl Fn(&ShadowBatch<W>, &[bool; W]) -> [bool; W],
) {
    let reference = Fused(structures.exhaustive.tracer(IgnoreWork));
    for group in rays.chunks(W) {
        let lane = |i: usize| group[i % group.len()];
        let batch = ShadowBatch::<W> {
            origin: group[0].origin,
            x: std::array::from_fn(|i| lane(i).direction.x),
            y: std::array::from_fn(|i| lane(i).direction.y),
            z: std::array::from_fn(|i| lane(i).direction.z),
            t_max: std::array::from_fn(|i| lane(i).t_max),
        };
        // A lane that nobody asked about answers true.
        let active: [bool; W] = std::array::from_fn(|i| i % 5 != 3);
        let expected: [bool; W] =
            std::array::from_fn(|i| !active[i] || reference.occluded(&batch.ray(i), filter));
        assert_eq!(ask(&batch, &active), expected, "{name}, shadows: {batch:?} with {filter:?}");
    }
}
