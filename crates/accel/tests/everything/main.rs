//! Every structure, builder, traversal and SIMD level gives the hit of no structure at all, bit for bit.
//!
//! `PROPTEST_CASES=N` runs N times the usual number of cases.

mod apart;
mod check;
mod cornell;
mod filtered;
mod fused;
mod hand;
mod rays;
mod scenes;
#[path = "../support/mod.rs"]
mod support;
mod ways;

use check::{Asked, check, check_shadows};
use eosphor_core::hierarchy::{IgnoreWork, Tracer};
use eosphor_core::math::Vec3;
use eosphor_core::ray::{Ray, RayFilter};
use fused::Fused;
use proptest::prelude::*;
use rays::{Aims, Wildness};
use scenes::{Frame, Kind};
use support::{Random, World};
use ways::Structures;

/// How many times the usual number of cases.
fn times() -> u32 {
    std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(1)
}

fn cases(count: u32) -> ProptestConfig {
    ProptestConfig {
        failure_persistence: None,
        // A seed does not shrink to anything simpler.
        max_shrink_iters: 20,
        ..ProptestConfig::with_cases(count * times())
    }
}

/// Sizes of batches: below, at and above what kernels take at a time.
const SIZES: [usize; 9] = [1, 3, 4, 15, 16, 17, 33, 100, 64];

/// The rays, and some of them again with an end at or next to a hit, or without the triangle that they hit.
fn with_ends(structures: &Structures, asked: Vec<Asked>, random: &mut Random) -> Vec<Asked> {
    let reference = Fused(structures.exhaustive.tracer(IgnoreWork));
    let mut all = Vec::new();
    for (ray, filter) in asked {
        all.push((ray, filter));
        let closest = reference.closest_hit(&ray, &filter);
        if closest.is_miss() || random.below(3) > 0 {
            continue;
        }
        let next = reference.next_hit(&ray, &filter, &closest);
        let hit = if next.is_miss() || random.below(2) == 0 { closest } else { next };
        all.push(match random.below(7) {
            0 => (Ray { t_max: hit.t, ..ray }, filter),
            1 => (Ray { t_max: hit.t.next_down(), ..ray }, filter),
            2 => (Ray { t_min: hit.t, ..ray }, filter),
            3 => (Ray { t_min: hit.t.next_down(), ..ray }, filter),
            4 => (ray, RayFilter { start: hit.id, ..filter }),
            5 => (ray, RayFilter { target: hit.id, ..filter }),
            _ => (ray, RayFilter { cull_back_faces: !filter.cull_back_faces, ..filter }),
        });
    }
    all
}

/// Checks a world with rays of all kinds.
fn check_world(world: &World, frame: Frame, count: usize, wildness: Wildness, random: &mut Random) {
    let structures = Structures::new(world);
    let aims = Aims::new(world, frame, random);
    let asked = with_ends(&structures, aims.rays(count, wildness, random), random);
    let first = random.below(SIZES.len());
    let sizes: Vec<usize> = SIZES.iter().cycle().skip(first).take(SIZES.len()).copied().collect();
    check(&structures, &asked, &sizes);
    let some: Vec<Ray> = asked.iter().take(32).map(|a| a.0).collect();
    check_shadows(&structures, &some, &asked[0].1);
}

/// Checks filtered queries in a world with rays of all kinds.
fn check_filtered(world: &World, count: usize, wildness: Wildness, random: &mut Random) {
    let structures = Structures::new(world);
    let aims = Aims::new(world, Frame::UNIT, random);
    let asked = with_ends(&structures, aims.rays(count, wildness, random), random);
    filtered::check(world, &structures, &asked, random);
}

fn kind() -> impl Strategy<Value = Kind> {
    (0..Kind::ALL.len()).prop_map(|k| Kind::ALL[k])
}

fn wildness() -> impl Strategy<Value = Wildness> {
    prop_oneof![Just(Wildness::Tame), Just(Wildness::Wild)]
}

proptest! {
    #![proptest_config(cases(20))]

    #[test]
    fn all_agree_on_triangles_and_spheres(
        seed in any::<u64>(),
        kind in kind(),
        count in prop_oneof![Just(1usize), Just(6), Just(40), Just(300)],
        wildness in wildness(),
    ) {
        let mut random = Random(seed);
        let world = scenes::world([kind, kind], [count, 0], 0, &Frame::UNIT, &mut random);
        check_world(&world, Frame::UNIT, 150, wildness, &mut random);
    }

    #[test]
    fn all_agree_on_instances(
        seed in any::<u64>(),
        kinds in [kind(), kind()],
        counts in [0usize..20, 1usize..60],
        instances in prop_oneof![1usize..4, 1usize..40],
        wildness in wildness(),
    ) {
        let mut random = Random(seed);
        let world = scenes::world(kinds, counts, instances, &Frame::UNIT, &mut random);
        check_world(&world, Frame::UNIT, 150, wildness, &mut random);
    }

    #[test]
    fn all_agree_at_any_scale_and_far_away(
        seed in any::<u64>(),
        kinds in [kind(), kind()],
        instances in 0usize..4,
        size in prop_oneof![-6f32..9.0, -18f32..18.0],
        offset in prop_oneof![Just(None), (-3f32..12.0).prop_map(Some), (-18f32..18.0).prop_map(Some)],
        wildness in wildness(),
    ) {
        let mut random = Random(seed);
        let center = offset.map_or(Vec3::ZERO, |exponent| random.in_cube() * 10f32.powf(exponent));
        let frame = Frame { size: 10f32.powf(size), center };
        let world = scenes::world(kinds, [30, 20], instances, &frame, &mut random);
        // The largest frames may be left by what is large in them.
        prop_assume!(world.is_in_range());
        check_world(&world, frame, 120, wildness, &mut random);
    }
}

proptest! {
    #![proptest_config(cases(20))]

    #[test]
    fn filtered_queries_are_those_over_what_is_left(
        seed in any::<u64>(),
        kinds in [kind(), kind()],
        counts in [0usize..60, 1usize..40],
        instances in prop_oneof![Just(0usize), 1usize..4, 1usize..20],
        wildness in wildness(),
    ) {
        let mut random = Random(seed);
        let world = scenes::world(kinds, counts, instances, &Frame::UNIT, &mut random);
        check_filtered(&world, 100, wildness, &mut random);
    }
}

proptest! {
    #![proptest_config(cases(1))]

    #[test]
    fn all_agree_on_large_batches(seed in any::<u64>(), kind in kind(), instances in 0usize..3) {
        let mut random = Random(seed);
        let world = scenes::world([kind, Kind::Mixed], [100, 30], instances, &Frame::UNIT, &mut random);
        let structures = Structures::new(&world);
        let aims = Aims::new(&world, Frame::UNIT, &mut random);
        check(&structures, &aims.rays(5000, Wildness::Tame, &mut random), &[5000]);
    }

    #[test]
    fn all_agree_on_thousands_of_equal_primitives(seed in any::<u64>(), instances in 0usize..3) {
        let mut random = Random(seed);
        let world =
            scenes::world([Kind::Coincident, Kind::Coincident], [5000, 50], instances, &Frame::UNIT, &mut random);
        check_world(&world, Frame::UNIT, 60, Wildness::Tame, &mut random);
    }

    #[test]
    fn all_agree_on_hundreds_of_instances(seed in any::<u64>(), kinds in [kind(), kind()]) {
        let mut random = Random(seed);
        let world = scenes::world(kinds, [10, 20], 400, &Frame::UNIT, &mut random);
        check_world(&world, Frame::UNIT, 100, Wildness::Wild, &mut random);
    }
}

/// Found by chance by `all_agree_on_hundreds_of_instances`: from 10^14 sizes away, hits of several instances are at one `t` of
/// double precision; and rays whose numbers are out of range in an instance's space alone hit nothing there.
#[test]
fn instances_from_beyond_double_precision() {
    let mut random = Random(10905397489955544456);
    let world = scenes::world([Kind::Coplanar, Kind::AxisFlat], [10, 20], 400, &Frame::UNIT, &mut random);
    check_world(&world, Frame::UNIT, 100, Wildness::Wild, &mut random);
}

/// Found by chance by `all_agree_on_instances`.
#[test]
fn instances_from_far_beyond_their_size() {
    let mut random = Random(3111489946237811296);
    let world = scenes::world([Kind::Coplanar, Kind::Coplanar], [19, 7], 3, &Frame::UNIT, &mut random);
    check_world(&world, Frame::UNIT, 150, Wildness::Wild, &mut random);
}

/// Found by chance by `all_agree_at_any_scale_and_far_away`: a ray whose numbers are out of range in an instance's space alone,
/// and that starts far from it there.
#[test]
fn numbers_out_of_range_in_an_instance_alone() {
    let mut random = Random(3939537680582943425);
    let frame = Frame { size: 10f32.powf(13.001601), center: Vec3::ZERO };
    let world = scenes::world([Kind::Single, Kind::Spheres], [30, 20], 3, &frame, &mut random);
    check_world(&world, frame, 120, Wildness::Tame, &mut random);
}

/// Found by chance by `all_agree_at_any_scale_and_far_away`: of rays that start in one point, packets multiplied in an order in
/// which products overflow and cancel to no number, where core's do not.
#[test]
fn products_that_overflow_in_another_order() {
    let mut random = Random(2098012749815399653);
    let center = random.in_cube() * 10f32.powf(14.558019);
    let frame = Frame { size: 10f32.powf(11.989734), center };
    let world = scenes::world([Kind::Mesh, Kind::Soup], [30, 20], 0, &frame, &mut random);
    check_world(&world, frame, 120, Wildness::Wild, &mut random);
}

/// What proptest has found: one of the rays touches a sphere.
#[test]
fn a_ray_that_touches_a_sphere_hits_it_once() {
    let mut random = Random(4_079_957_143_426_768_048);
    let world = scenes::world([Kind::Mixed, Kind::Spheres], [45, 28], 0, &Frame::UNIT, &mut random);
    check_filtered(&world, 100, Wildness::Wild, &mut random);
}

/// At such a size, the normal of a triangle times the distance to it is infinite in single precision.
#[test]
fn all_agree_where_products_overflow() {
    let mut random = Random(11482994408168036156);
    let frame = Frame { size: 10f32.powf(14.168359), center: Vec3::ZERO };
    let world = scenes::world([Kind::Mesh, Kind::ManySizes], [30, 20], 0, &frame, &mut random);
    check_world(&world, frame, 120, Wildness::Tame, &mut random);
}
