//! The binary hierarchy gives the hit of no structure at all, bit for bit: cases by hand. (Random ones: `everything`.)

mod support;

use eosphor_accel::{BuildOptions, Bvh, Exhaustive};
use eosphor_core::geometry::{Bounds, Sphere};
use eosphor_core::hierarchy::{BvhNode, IgnoreWork, MAX_BVH_DEPTH, ShadowBatch, Tracer};
use eosphor_core::math::{Affine, Vec3, vec3};
use eosphor_core::ray::{Hit, PrimitiveId, Ray, RayFilter};
use support::{Random, World, affine};

/// One world under every structure.
struct Structures {
    exhaustive: Exhaustive,
    bvhs: Vec<Bvh>,
}

impl Structures {
    fn new(world: &World) -> Structures {
        let with = |max_leaf_primitives, traversal_cost| {
            let options = BuildOptions { max_leaf_primitives, traversal_cost, ..BuildOptions::default() };
            Bvh::build(&world.geometry(), &options)
        };
        let bvhs = vec![
            Bvh::build(&world.geometry(), &BuildOptions::default()),
            with(1, 1.0),
            with(8, 0.0),
            with(3, 100.0),
            with(255, 1e9),
        ];
        Structures { exhaustive: Exhaustive::new(&world.geometry()), bvhs }
    }

    fn closest(&self, ray: &Ray) -> Hit {
        self.exhaustive.tracer(IgnoreWork).closest_hit(ray, &RayFilter::ALL)
    }

    fn is_triangle(&self, id: PrimitiveId) -> bool {
        let primitives = &self.exhaustive.primitives();
        let geometry = primitives.instances()[id.instance as usize].geometry;
        id.primitive < primitives.geometries()[geometry as usize].triangle_count
    }

    /// Asks everything about a ray; returns all its hits.
    fn check(&self, ray: &Ray, filter: &RayFilter) -> Vec<Hit> {
        let reference = self.exhaustive.tracer(IgnoreWork);
        let closest = reference.closest_hit(ray, filter);
        let all = chain(&reference, ray, filter);
        assert_same(&closest, all.first().unwrap_or(&Hit::miss(ray.t_max)), ray);
        assert_eq!(reference.occluded(ray, filter), !closest.is_miss(), "{ray:?}");
        for hit in &all {
            assert!(hit.t > ray.t_min && hit.t <= ray.t_max && hit.t.is_finite(), "{hit:?} {ray:?}");
            // Spheres are not left out by number.
            assert!(!(filter.skips(hit.id) && self.is_triangle(hit.id)), "{hit:?} {ray:?}");
        }
        for pair in all.windows(2) {
            assert!(pair[0].before(&pair[1]), "{pair:?} {ray:?}");
        }
        for bvh in &self.bvhs {
            let tracer = bvh.tracer(IgnoreWork);
            assert_same(&tracer.closest_hit(ray, filter), &closest, ray);
            assert_eq!(tracer.occluded(ray, filter), !closest.is_miss(), "{ray:?}");
            let hits = chain(&tracer, ray, filter);
            assert_eq!(hits.len(), all.len(), "{hits:?} instead of {all:?} for {ray:?}");
            for (hit, expected) in hits.iter().zip(&all) {
                assert_same(hit, expected, ray);
            }
        }
        all
    }

    /// [`Structures::check`], then with the ray's end at and just before a hit, and without the first primitive.
    fn check_all_ends(&self, ray: &Ray, filter: &RayFilter) {
        let all = self.check(ray, filter);
        let Some(first) = all.first() else { return };
        for hit in [first, all.last().unwrap(), &all[all.len() / 2]] {
            // Close to an end, `t` is that of double precision, rounded.
            let t = hit.t64() as f32;
            let up_to = self.check(&Ray { t_max: t, ..*ray }, filter);
            assert!(up_to.iter().any(|h| h.id == hit.id), "a hit at t_max counts: {ray:?}");
            self.check(&Ray { t_max: t.next_down(), ..*ray }, filter);
            self.check(&Ray { t_min: t, ..*ray }, filter);
        }
        self.check(ray, &RayFilter { start: first.id, ..*filter });
        self.check(ray, &RayFilter { target: all[all.len() / 2].id, ..*filter });
        self.check(ray, &RayFilter { cull_back_faces: !filter.cull_back_faces, ..*filter });
    }

    /// Batches of `W` of these rays from the origin of the first.
    fn check_batches<const W: usize>(&self, rays: &[Ray], filter: &RayFilter) {
        let reference = self.exhaustive.tracer(IgnoreWork);
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
            assert_eq!(reference.occluded_batch(&batch, filter, &active), expected);
            for bvh in &self.bvhs {
                let tracer = bvh.tracer(IgnoreWork);
                assert_eq!(tracer.occluded_batch(&batch, filter, &active), expected, "{batch:?}");
            }
        }
    }

    fn check_rays(&self, rays: &[Ray], filter: &RayFilter) {
        for ray in rays {
            self.check_all_ends(ray, filter);
        }
        self.check_batches::<1>(rays, filter);
        self.check_batches::<8>(rays, filter);
        self.check_batches::<16>(rays, filter);
        self.check_batches::<50>(rays, filter);
        self.check_batches::<64>(rays, filter);
        self.check_batches::<65>(rays, filter);
    }
}

/// All hits, one after the other. More than there can be are a loop without end.
fn chain(tracer: &impl Tracer, ray: &Ray, filter: &RayFilter) -> Vec<Hit> {
    let mut hits = Vec::new();
    let mut after = Hit::miss(f32::NEG_INFINITY);
    loop {
        let hit = tracer.next_hit(ray, filter, &after);
        if hit.is_miss() {
            assert_eq!(hit.t.to_bits(), ray.t_max.to_bits(), "a miss says t_max");
            return hits;
        }
        hits.push(hit);
        assert!(hits.len() < 100_000, "no end: {ray:?}");
        after = hit;
    }
}

fn assert_same(got: &Hit, expected: &Hit, ray: &Ray) {
    let bits = |h: &Hit| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.id);
    assert_eq!(bits(got), bits(expected), "{got:?} instead of {expected:?} for {ray:?}");
}

// --- Cases by hand ---------------------------------------------------------------------------------------------------

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
}

const DOWN: Vec3 = vec3(0.0, 0.0, -1.0);

/// Covers (0, 0) in the plane z.
fn flat_triangle(z: f32) -> [Vec3; 3] {
    [vec3(-1.0, -1.0, z), vec3(3.0, -1.0, z), vec3(-1.0, 3.0, z)]
}

#[test]
fn empty_worlds_are_missed() {
    let mut instanced = World::new(vec![], vec![]);
    let nothing = instanced.add_geometry(&[], &[]);
    instanced.add_instance(nothing, Affine::IDENTITY);
    for world in [World::new(vec![], vec![]), instanced] {
        let structures = Structures::new(&world);
        let mut random = Random(1);
        let rays: Vec<Ray> = (0..100)
            .map(|_| ray(random.in_cube(), random.direction()))
            .chain([ray(Vec3::ZERO, DOWN)])
            .collect();
        structures.check_rays(&rays, &RayFilter::ALL);
        assert!(rays.iter().all(|r| structures.closest(r).is_miss()));
    }
}

#[test]
fn ties_go_to_the_lowest_primitive() {
    // A stack of equal triangles among others, whatever order a tree has them in.
    let triangles = (0..50).map(|i| flat_triangle(if i % 3 == 1 { 0.0 } else { -1.0 - i as f32 })).collect();
    let structures = Structures::new(&World::new(triangles, vec![]));
    let down = ray(vec3(0.0, 0.0, 2.0), DOWN);
    let hits = structures.check(&down, &RayFilter::ALL);
    assert_eq!(hits.len(), 50);
    let at_zero: Vec<u32> = hits.iter().filter(|h| h.t == 2.0).map(|h| h.id.primitive).collect();
    assert_eq!(at_zero, (0..50).filter(|i| i % 3 == 1).collect::<Vec<_>>());
    assert_eq!(structures.closest(&down).id, PrimitiveId { instance: 0, primitive: 1 });
}

#[test]
fn ties_go_to_the_lowest_instance_before_the_lowest_primitive() {
    let mut world = World::new(vec![flat_triangle(0.0), flat_triangle(1.0)], vec![]);
    let object = world.add_geometry(&[flat_triangle(0.0), flat_triangle(1.0)], &[]);
    for _ in 0..20 {
        world.add_instance(object, Affine::IDENTITY);
    }
    let structures = Structures::new(&world);
    let hits = structures.check(&ray(vec3(0.0, 0.0, 2.0), DOWN), &RayFilter::ALL);
    let expected: Vec<_> = [1, 0]
        .into_iter()
        .flat_map(|primitive| (0..=20).map(move |instance| PrimitiveId { instance, primitive }))
        .collect();
    assert_eq!(hits.iter().map(|h| h.id).collect::<Vec<_>>(), expected);
}

#[test]
fn ties_between_a_triangle_and_a_sphere_go_to_the_triangle() {
    let sphere = Sphere { center: vec3(0.0, 0.0, -1.0), radius: 1.0 };
    let structures = Structures::new(&World::new(vec![flat_triangle(0.0)], vec![sphere]));
    let hits = structures.check(&ray(vec3(0.0, 0.0, 2.0), DOWN), &RayFilter::ALL);
    let found: Vec<_> = hits.iter().map(|h| (h.t, h.id.primitive)).collect();
    assert_eq!(found, [(2.0, 0), (2.0, 1), (4.0, 1)]);
}

#[test]
fn a_ray_from_inside_a_sphere_meets_its_far_side_only() {
    let sphere = Sphere { center: Vec3::ZERO, radius: 2.0 };
    let structures = Structures::new(&World::new(vec![], vec![sphere]));
    let hits = structures.check(&ray(vec3(0.0, 0.0, 1.0), DOWN), &RayFilter::ALL);
    assert_eq!(hits.iter().map(|h| h.t).collect::<Vec<_>>(), [3.0]);
}

#[test]
fn culling_hides_triangles_seen_from_behind_and_no_spheres() {
    let sphere = Sphere { center: vec3(0.0, 0.0, -5.0), radius: 1.0 };
    let structures = Structures::new(&World::new(vec![flat_triangle(0.0)], vec![sphere]));
    let culling = RayFilter { cull_back_faces: true, ..RayFilter::ALL };
    let above = structures.check(&ray(vec3(0.0, 0.0, 1.0), DOWN), &culling);
    assert_eq!(above.iter().map(|h| h.id.primitive).collect::<Vec<_>>(), [0, 1, 1]);
    let below = structures.check(&ray(vec3(0.0, 0.0, -9.0), -DOWN), &culling);
    assert_eq!(below.iter().map(|h| h.id.primitive).collect::<Vec<_>>(), [1, 1]);
}

#[test]
fn mirrored_instances_are_culled_by_their_own_winding() {
    let mut world = World::new(vec![], vec![]);
    let object = world.add_geometry(&[flat_triangle(0.0)], &[]);
    world.add_instance(object, affine(vec3(1.0, 1.0, -1.0), [0.0; 3], Vec3::ZERO));
    let structures = Structures::new(&world);
    let culling = RayFilter { cull_back_faces: true, ..RayFilter::ALL };
    // In its own space the ray comes from below.
    assert!(structures.check(&ray(vec3(0.0, 0.0, 1.0), DOWN), &culling).is_empty());
    assert_eq!(structures.check(&ray(vec3(0.0, 0.0, -1.0), -DOWN), &culling).len(), 1);
}

#[test]
fn t_means_the_same_inside_unevenly_scaled_instances() {
    let mut world = World::new(vec![], vec![]);
    let object = world.add_geometry(&[flat_triangle(0.0)], &[Sphere { center: DOWN, radius: 0.5 }]);
    world.add_instance(object, affine(vec3(1.0, 3.0, 4.0), [0.0; 3], vec3(0.0, 0.0, 10.0)));
    let structures = Structures::new(&world);
    let hits = structures.check(&ray(vec3(0.0, 0.0, 16.0), DOWN), &RayFilter::ALL);
    assert_eq!(hits.iter().map(|h| h.t).collect::<Vec<_>>(), [6.0, 8.0, 12.0]);
}

// --- Trees -----------------------------------------------------------------------------------------------------------

fn soup(count: usize, seed: u64) -> Vec<[Vec3; 3]> {
    let mut random = Random(seed);
    (0..count)
        .map(|_| {
            let at = random.in_cube() * 10.0;
            [0, 1, 2].map(|_| at + random.in_cube() * 0.1)
        })
        .collect()
}

fn node_bytes(bvh: &Bvh) -> Vec<[u32; 8]> {
    let bits = |n: &BvhNode| {
        let (a, b) = (n.min, n.max);
        [
            a.x.to_bits(),
            a.y.to_bits(),
            a.z.to_bits(),
            n.first,
            b.x.to_bits(),
            b.y.to_bits(),
            b.z.to_bits(),
            n.count,
        ]
    };
    bvh.nodes().iter().map(bits).collect()
}

#[test]
fn any_number_of_threads_builds_the_same_tree() {
    // More than the parallel binning and subtrees begin at; zeros of both signs, and many equal centroids.
    let mut triangles = soup(90_000, 5);
    triangles.extend((0..10_000).map(|i| flat_triangle(if i % 2 == 0 { 0.0 } else { -0.0 })));
    let mut random = Random(6);
    let spheres = (0..5000).map(|_| Sphere { center: random.in_cube() * 10.0, radius: 0.05 }).collect();
    let world = World::new(triangles, spheres);
    let build = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Bvh::build(&world.geometry(), &BuildOptions::default()))
    };
    let one = build(1);
    for threads in [2, 7] {
        let many = build(threads);
        assert!(node_bytes(&many) == node_bytes(&one), "{threads} threads");
        assert!(many.primitives().triangles() == one.primitives().triangles(), "{threads} threads");
        assert!(
            many.primitives().sphere_primitives() == one.primitives().sphere_primitives(),
            "{threads} threads"
        );
    }
}

/// Whether boxes hold what is inside, leaves hold one kind, and every primitive is in one leaf; returns the depth.
fn check_tree(world: &World, options: &BuildOptions) -> u32 {
    let bvh = Bvh::build(&world.geometry(), options);
    let geometry = &world.geometries[0];
    let triangle_bounds = bvh.primitives().triangle_bounds(geometry);
    let sphere_bounds = bvh.primitives().sphere_bounds(geometry);
    let holds = |outer: &Bounds, inner: &Bounds| outer.union(inner) == *outer;
    let mut seen = vec![0; (geometry.triangle_count + geometry.sphere_count) as usize];
    let mut pending = vec![bvh.roots()[0]];
    while let Some(at) = pending.pop() {
        let node = &bvh.nodes()[at as usize];
        if node.is_inner() {
            for child in [node.first, node.first + 1] {
                assert!(holds(&node.bounds(), &bvh.nodes()[child as usize].bounds()));
                pending.push(child);
            }
            continue;
        }
        let count = node.count & !BvhNode::SPHERES;
        assert!(count <= options.max_leaf_primitives, "{count}");
        for k in (node.first..).take(count as usize).map(|k| k as usize) {
            let (bounds, primitive) = if node.count & BvhNode::SPHERES == 0 {
                (&triangle_bounds[k], bvh.primitives().triangles()[k].primitive)
            } else {
                (&sphere_bounds[k], bvh.primitives().sphere_primitives()[k])
            };
            assert!(holds(&node.bounds(), bounds));
            seen[primitive as usize] += 1;
        }
    }
    assert!(seen.iter().all(|&n| n == 1));
    bvh.statistics().max_leaf_depth
}

#[test]
fn trees_hold_every_primitive_once_and_are_no_deeper_than_the_stack() {
    let tiny = |at: Vec3, size: f32| [at, at + vec3(size, 0.0, 0.0), at + vec3(0.0, size, 0.0)];
    let powers = |base: f32, count: i32| -> Vec<[Vec3; 3]> {
        (0..count).map(|k| base.powi(k - count / 2)).map(|x| tiny(vec3(x, 0.0, 0.0), x * 0.1)).collect()
    };
    let mut random = Random(3);
    let mixed = (0..2000).map(|_| Sphere { center: random.in_cube(), radius: 0.01 }).collect();
    let equal = vec![Sphere { center: vec3(1.0 / 3.0, 1.0 / 3.0, 0.0), radius: 0.25 }; 300];
    let nested: Vec<_> = (0..4000).map(|k| tiny(Vec3::ZERO, 1.01f32.powi(k - 2000))).collect();
    // Doubling distances, each with a crowd of its own that halving must still part.
    let crowded: Vec<_> = powers(2.0, 90).into_iter().flat_map(|t| vec![t; 700]).collect();
    let worlds = [
        ("powers of 2", World::new(powers(2.0, 90), vec![])),
        ("powers of 1.05", World::new(powers(1.05, 1500), vec![])),
        ("crowded powers of 2", World::new(crowded, vec![])),
        ("100,000 equal", World::new(vec![flat_triangle(0.5); 100_000], vec![])),
        ("nested", World::new(nested, vec![])),
        ("mixed", World::new(soup(2000, 9), mixed)),
        ("equal centroids of both kinds", World::new(vec![tiny(Vec3::ZERO, 2.0 / 3.0); 300], equal)),
        ("one", World::new(vec![flat_triangle(0.0)], vec![])),
    ];
    for (name, world) in &worlds {
        for (max_leaf_primitives, traversal_cost) in [(4, 1.0), (1, 0.0), (255, 1e9)] {
            let options = BuildOptions { max_leaf_primitives, traversal_cost, ..BuildOptions::default() };
            let depth = check_tree(world, &options);
            println!("{name}: depth {depth} with leaves of {max_leaf_primitives}");
            assert!((depth as usize) < MAX_BVH_DEPTH, "{name}: {depth}");
        }
    }
}

#[test]
fn the_deepest_trees_are_traversed_within_the_stack() {
    // Debug assertions check the stack's room.
    let triangle = |k: i32| {
        let x = 2f32.powi(k);
        [vec3(x, -x, -x), vec3(x, x, -x), vec3(x, -x, x)]
    };
    let triangles: Vec<_> = (-45..45).flat_map(|k| vec![triangle(k); 40]).collect();
    let world = World::new(triangles, vec![]);
    let tracer_options =
        BuildOptions { max_leaf_primitives: 1, traversal_cost: 0.0, ..BuildOptions::default() };
    let bvh = Bvh::build(&world.geometry(), &tracer_options);
    let (tracer, reference) = (bvh.tracer(IgnoreWork), Exhaustive::new(&world.geometry()));
    for ray in [
        ray(vec3(-1.0, -1e-15, -1e-15), vec3(1.0, 0.0, 0.0)),
        ray(vec3(4e13, -1.0, -1.0), vec3(-1.0, 0.0, -0.0)),
        ray(Vec3::ZERO, vec3(0.9, -0.3, -0.3).normalize()),
    ] {
        let expected = reference.tracer(IgnoreWork).closest_hit(&ray, &RayFilter::ALL);
        assert_same(&tracer.closest_hit(&ray, &RayFilter::ALL), &expected, &ray);
        // Nothing is left of the chain but its end, so every node on the way is entered.
        let late = Hit { t: f32::MAX, ..expected };
        assert!(tracer.next_hit(&ray, &RayFilter::ALL, &late).is_miss());
        let batch = ShadowBatch::<1> {
            origin: ray.origin,
            x: [ray.direction.x],
            y: [ray.direction.y],
            z: [ray.direction.z],
            t_max: [f32::INFINITY],
        };
        assert_eq!(tracer.occluded_batch(&batch, &RayFilter::ALL, &[true]), [!expected.is_miss()]);
    }
}

#[test]
fn corners_on_one_line_are_never_hit() {
    // With fused multiply-adds the cross product of a vector and its double is not zero: it is all rounding error.
    let mut random = Random(77);
    for case in 0..10 {
        // Multiples of 2^-18, so that the edges are exact and their products are not.
        let mut part = || (random.in_cube() * 262_144.0).abs().plus_scaled(Vec3::ONE, 1.0);
        let cut = |v: Vec3| vec3(v.x.trunc(), v.y.trunc(), v.z.trunc()) * (1.0 / 262_144.0);
        let edge = if case == 0 { vec3(0.1, 0.7, 0.3) } else { cut(part()) };
        let corner = if case < 5 { Vec3::ZERO } else { cut(part()) };
        let (middle, end) = (corner + edge, corner + edge * 2.0);
        assert_eq!((middle - corner) * 2.0, end - corner);
        let orders =
            [[corner, middle, end], [corner, end, middle], [end, corner, middle], [middle, end, corner]];
        let structures = Structures::new(&World::new(orders.to_vec(), vec![]));
        for _ in 0..10_000 {
            let target = corner.plus_scaled(edge, (2.0 * random.unit()) as f32);
            let from = target + random.direction() * (0.1 + random.unit() as f32);
            let aimed = ray(from, (target - from).normalize());
            assert!(structures.closest(&aimed).is_miss(), "{case}: {aimed:?}");
            assert!(structures.bvhs[0].tracer(IgnoreWork).closest_hit(&aimed, &RayFilter::ALL).is_miss());
        }
    }
}
