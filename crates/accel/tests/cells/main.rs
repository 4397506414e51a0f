//! Octree, grid and kd-tree give the hit of no structure at all, bit for bit.

#[path = "../support/mod.rs"]
mod support;
mod worlds;

use eosphor_accel::{Exhaustive, Grid, GridOptions, KdTree, KdTreeOptions, Octree, OctreeOptions, Overlap};
use eosphor_core::geometry::Sphere;
use eosphor_core::hierarchy::{CountWork, IgnoreWork, ShadowBatch, Tracer};
use eosphor_core::math::{Affine, Vec3, vec3};
use eosphor_core::ray::{Hit, Ray, RayFilter};
use proptest::prelude::*;
use support::{Random, World};
use worlds::{KINDS, Kind, placement, primitives};

/// One world under every structure, with settings from coarse to fine.
struct Structures {
    exhaustive: Exhaustive,
    octrees: Vec<Octree>,
    grids: Vec<Grid>,
    kdtrees: Vec<KdTree>,
}

impl Structures {
    fn new(world: &World) -> Structures {
        let scene = world.geometry();
        let (octree, grid, kdtree) =
            (OctreeOptions::default(), GridOptions::default(), KdTreeOptions::default());
        let octree_fine =
            OctreeOptions { max_leaf_primitives: 1, max_depth: 6, only_if_cheaper: false, ..octree };
        let grid_fine = GridOptions { density: 100.0, max_duplication: 200.0, ..grid };
        let kdtree_fine =
            KdTreeOptions { traversal_cost: 0.01, patience: 5, max_depth: 40, empty_bonus: 0.8, ..kdtree };
        Structures {
            exhaustive: Exhaustive::new(&scene),
            octrees: [octree, octree_fine].map(|o| Octree::build(&scene, &o)).into(),
            grids: [grid, grid_fine].map(|o| Grid::build(&scene, &o)).into(),
            kdtrees: [kdtree, kdtree_fine].map(|o| KdTree::build(&scene, &o)).into(),
        }
    }

    /// Asks everything about a ray; returns all its hits.
    fn check(&self, ray: &Ray, filter: &RayFilter) -> Vec<Hit> {
        let reference = self.exhaustive.tracer(IgnoreWork);
        let all = chain(&reference, ray, filter);
        for octree in &self.octrees {
            check_one("octree", &octree.tracer(IgnoreWork), ray, filter, &all);
            check_one("parametric", &octree.parametric_tracer(IgnoreWork), ray, filter, &all);
        }
        for grid in &self.grids {
            check_one("grid", &grid.tracer(IgnoreWork), ray, filter, &all);
        }
        for kdtree in &self.kdtrees {
            check_one("kdtree", &kdtree.tracer(IgnoreWork), ray, filter, &all);
        }
        all
    }

    /// [`Structures::check`], then with the ray's ends at and next to hits, and without the first triangle.
    fn check_ends(&self, ray: &Ray, filter: &RayFilter) {
        let all = self.check(ray, filter);
        let Some(first) = all.first() else { return };
        for hit in [first, &all[all.len() / 2]] {
            let t = hit.t64() as f32;
            self.check(&Ray { t_max: t, ..*ray }, filter);
            self.check(&Ray { t_max: t.next_down(), ..*ray }, filter);
            self.check(&Ray { t_min: t, ..*ray }, filter);
        }
        self.check(ray, &RayFilter { start: first.id, ..*filter });
    }
}

fn check_one(name: &str, tracer: &impl Tracer, ray: &Ray, filter: &RayFilter, all: &[Hit]) {
    let bits = |h: &Hit| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.id);
    let (closest, expected) =
        (tracer.closest_hit(ray, filter), all.first().copied().unwrap_or(Hit::miss(ray.t_max)));
    assert_eq!(bits(&closest), bits(&expected), "{name}: {closest:?} instead of {expected:?} for {ray:?}");
    assert_eq!(tracer.occluded(ray, filter), !all.is_empty(), "{name}: {ray:?}");
    check_batch(name, tracer, ray, filter);
    let hits = chain(tracer, ray, filter);
    assert_eq!(hits.len(), all.len(), "{name}: {hits:?} instead of {all:?} for {ray:?}");
    for (hit, expected) in hits.iter().zip(all) {
        assert_eq!(bits(hit), bits(expected), "{name}: {hit:?} instead of {expected:?} for {ray:?}");
    }
}

/// Rays that go together are answered as each alone: the ray and others from its origin, of all octants.
fn check_batch(name: &str, tracer: &impl Tracer, ray: &Ray, filter: &RayFilter) {
    let sign = |lane: usize, bit: usize| if lane & bit == 0 { 1.0 } else { -1.0 };
    let batch = ShadowBatch::<9> {
        origin: ray.origin,
        x: std::array::from_fn(|lane| ray.direction.x * sign(lane, 1)),
        y: std::array::from_fn(|lane| ray.direction.y * sign(lane, 2)),
        z: std::array::from_fn(|lane| ray.direction.z * sign(lane, 4)),
        t_max: std::array::from_fn(|lane| if lane == 8 { f32::INFINITY } else { ray.t_max }),
    };
    let active: [bool; 9] = std::array::from_fn(|lane| lane != 3);
    let expected: [bool; 9] =
        std::array::from_fn(|lane| !active[lane] || tracer.occluded(&batch.ray(lane), filter));
    assert_eq!(tracer.occluded_batch(&batch, filter, &active), expected, "{name}: {batch:?}");
}

/// All hits, one after the other, up to a number that shows whether any is left out or repeated.
fn chain(tracer: &impl Tracer, ray: &Ray, filter: &RayFilter) -> Vec<Hit> {
    let mut hits: Vec<Hit> = Vec::new();
    let mut after = Hit::miss(f32::NEG_INFINITY);
    while hits.len() < 8 {
        let hit = tracer.next_hit(ray, filter, &after);
        if hit.is_miss() {
            assert_eq!(hit.t.to_bits(), ray.t_max.to_bits(), "a miss says t_max");
            break;
        }
        hits.push(hit);
        after = hit;
    }
    hits
}

fn cases(count: u32) -> ProptestConfig {
    ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(count) }
}

proptest! {
    #![proptest_config(cases(32))]

    #[test]
    fn structures_agree(seed in any::<u64>(), kind in 0..KINDS.len(), culling in any::<bool>()) {
        let mut random = Random(seed);
        let count = [1, 5, 30, 200][random.below(4)];
        let (triangles, spheres) = primitives(KINDS[kind], count, &mut random);
        let world = World::new(triangles, spheres);
        let structures = Structures::new(&world);
        let filter = RayFilter { cull_back_faces: culling, ..RayFilter::ALL };
        for _ in 0..24 {
            structures.check_ends(&worlds::ray(&world, &mut random, 1.0, Vec3::ZERO), &filter);
        }
    }

    #[test]
    fn structures_agree_on_instances(seed in any::<u64>(), kind in 0..KINDS.len()) {
        let mut random = Random(seed);
        let (triangles, spheres) = primitives(Kind::Mixed, 8, &mut random);
        let mut world = World::new(triangles, spheres);
        let (triangles, spheres) = primitives(KINDS[kind], 60, &mut random);
        let geometry = world.add_geometry(&triangles, &spheres);
        for _ in 0..1 + random.below(5) {
            let map = placement(&mut random);
            world.add_instance(geometry, map);
        }
        let structures = Structures::new(&world);
        for k in 0..16 {
            let mut ray = worlds::ray(&world, &mut random, 1.0, Vec3::ZERO);
            // Aimed at placed corners.
            if let (Some(t), true) = (triangles.first(), k % 2 == 0) {
                let instance = &world.instances[random.below(world.instances.len())];
                ray.direction = (instance.world_from_object.point(t[1]) - ray.origin).normalize_or(ray.direction);
            }
            structures.check_ends(&ray, &RayFilter::ALL);
        }
    }

    #[test]
    fn structures_agree_far_from_the_origin_and_at_any_scale(
        seed in any::<u64>(),
        kind in 0..KINDS.len(),
        scale in -6i32..10,
        offset in prop_oneof![Just(0.0f32), 0.0f32..12.0],
    ) {
        let mut random = Random(seed);
        let scale = 10f32.powi(scale);
        let offset = if offset == 0.0 { Vec3::ZERO } else { random.in_cube() * 10f32.powf(offset) };
        let (triangles, spheres) = primitives(KINDS[kind], 30, &mut random);
        let put = |p: Vec3| p * scale + offset;
        let world = World::new(
            triangles.iter().map(|t| t.map(put)).collect(),
            spheres.iter().map(|s| Sphere { center: put(s.center), radius: s.radius * scale }).collect(),
        );
        let structures = Structures::new(&world);
        for _ in 0..12 {
            structures.check_ends(&worlds::ray(&world, &mut random, scale, offset), &RayFilter::ALL);
        }
    }

    #[test]
    fn rays_that_are_no_rays_miss(
        seed in any::<u64>(),
        component in 0usize..3,
        poison in prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(f32::NEG_INFINITY)],
    ) {
        let mut random = Random(seed);
        let (triangles, spheres) = primitives(Kind::Mixed, 60, &mut random);
        let mut world = World::new(triangles.clone(), spheres.clone());
        let geometry = world.add_geometry(&triangles, &spheres);
        let map = placement(&mut random);
        world.add_instance(geometry, map);
        let structures = Structures::new(&world);
        let good = worlds::ray(&world, &mut random, 1.0, Vec3::ZERO);
        let poisoned = |v: Vec3| {
            let mut parts: [f32; 3] = v.into();
            parts[component] = poison;
            Vec3::from(parts)
        };
        for bad in [
            Ray { origin: poisoned(good.origin), ..good },
            Ray { direction: poisoned(good.direction), ..good },
            Ray { origin: Vec3::splat(poison), direction: Vec3::splat(poison), ..good },
            Ray { direction: Vec3::ZERO, ..good },
            Ray { t_max: f32::NAN, ..good },
            Ray { t_max: f32::NEG_INFINITY, ..good },
            Ray { t_min: f32::NAN, ..good },
            Ray { t_min: f32::INFINITY, ..good },
        ] {
            prop_assert_eq!(structures.check(&bad, &RayFilter::ALL), vec![], "{:?}", bad);
        }
    }

    #[test]
    fn coordinates_that_overflow_change_no_hit(seed in any::<u64>(), far in 12f32..38.0, small in 12f32..38.0) {
        // Larger coordinates are out of range, and no SceneGeometry. Rays may start beyond.
        const MOST: f32 = 16.5;
        let mut random = Random(seed);
        let (triangles, spheres) = primitives(Kind::Mixed, 40, &mut random);
        let size = [1.0, 10f32.powf((far * 0.5).min(MOST)), 10f32.powf(-small * 0.5)][random.below(3)];
        let world = World::new(
            triangles.iter().map(|t| t.map(|p| p * size)).collect(),
            spheres.iter().map(|s| Sphere { center: s.center * size, radius: s.radius * size }).collect(),
        );
        let structures = Structures::new(&world);
        for _ in 0..8 {
            let ray = worlds::ray(&world, &mut random, size, Vec3::ZERO);
            let away = ray.direction * -10f32.powf(far * random.unit() as f32);
            structures.check(&Ray { origin: ray.origin + away, ..ray }, &RayFilter::ALL);
            let length = 10f32.powf(-small * random.unit() as f32);
            structures.check(&Ray { direction: ray.direction * length, ..ray }, &RayFilter::ALL);
            structures.check(&Ray { direction: ray.direction * (1.0 / length), ..ray }, &RayFilter::ALL);
        }
    }
}

// --- Cases by hand ---------------------------------------------------------------------------------------------------

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
}

#[test]
fn empty_worlds_are_missed() {
    let mut instanced = World::new(vec![], vec![]);
    let nothing = instanced.add_geometry(&[], &[]);
    instanced.add_instance(nothing, Affine::IDENTITY);
    let mut random = Random(1);
    for world in [World::new(vec![], vec![]), instanced] {
        let structures = Structures::new(&world);
        for _ in 0..50 {
            let hits = structures.check(&worlds::ray(&world, &mut random, 1.0, Vec3::ZERO), &RayFilter::ALL);
            assert!(hits.is_empty());
        }
    }
}

#[test]
fn thousands_of_equal_primitives_end_in_bounded_memory() {
    let slanted = [vec3(-1.0, -0.9, -0.8), vec3(0.9, 0.1, -0.2), vec3(-0.3, 0.8, 1.0)];
    let spheres = vec![Sphere { center: vec3(0.3, 0.1, 0.0), radius: 0.5 }; 1000];
    let world = World::new(vec![slanted; 5000], spheres);
    let scene = world.geometry();
    let octree = Octree::build(&scene, &OctreeOptions { max_depth: 16, ..OctreeOptions::pg1() });
    let grid = Grid::build(&scene, &GridOptions::default());
    let kdtree = KdTree::build(&scene, &KdTreeOptions::default());
    for references in [&octree.references(), &grid.references(), &kdtree.references()] {
        assert!(references.len() < 40 * 6000, "{}", references.len());
    }
    let structures = Structures::new(&world);
    let mut random = Random(4);
    for _ in 0..5 {
        structures.check(&worlds::ray(&world, &mut random, 1.0, Vec3::ZERO), &RayFilter::ALL);
    }
}

#[test]
fn any_number_of_threads_builds_the_same_structures() {
    let mut random = Random(8);
    // More than parallel binning and subtrees begin at.
    let mut triangles: Vec<[Vec3; 3]> = (0..40_000)
        .map(|_| {
            let at = random.in_cube();
            [0, 1, 2].map(|_| at + random.in_cube() * 0.02)
        })
        .collect();
    triangles.extend(primitives(Kind::OnPlanes, 200, &mut random).0);
    let world = World::new(triangles, primitives(Kind::SpheresOnly, 2000, &mut random).1);
    let build = |threads: usize| {
        let scene = world.geometry();
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
            (
                Octree::build(&scene, &OctreeOptions::default()),
                Grid::build(&scene, &GridOptions::default()),
                KdTree::build(&scene, &KdTreeOptions::default()),
            )
        })
    };
    let (octree, grid, kdtree) = build(1);
    for threads in [2, 7] {
        let (o, g, k) = build(threads);
        assert!(
            o.nodes() == octree.nodes()
                && o.references() == octree.references()
                && o.roots() == octree.roots()
        );
        assert!(
            g.starts() == grid.starts() && g.references() == grid.references() && g.roots() == grid.roots()
        );
        assert!(
            k.nodes() == kdtree.nodes()
                && k.references() == kdtree.references()
                && k.roots() == kdtree.roots()
        );
    }
}

#[test]
fn statistics_count_what_is_there() {
    let mut random = Random(12);
    let (triangles, spheres) = primitives(Kind::Mixed, 4000, &mut random);
    let world = World::new(triangles, spheres);
    let scene = world.geometry();
    let count = (world.triangles.len() + world.spheres.len()) as u64;
    let octree = Octree::build(&scene, &OctreeOptions::default()).statistics();
    let grid = Grid::build(&scene, &GridOptions::default()).statistics();
    let kdtree = KdTree::build(&scene, &KdTreeOptions::default()).statistics();
    for s in [&octree, &grid, &kdtree] {
        assert_eq!(s.primitives, count);
        assert!(s.references >= count && s.leaves > 100 && s.nodes > s.leaves, "{s:?}");
        assert!(s.sah_cost > 1.0 && s.sah_cost < count as f64, "{s:?}");
        assert_eq!(s.mean_leaf_primitives, s.references as f64 / s.leaves as f64);
        assert!(s.max_leaf_primitives as f64 >= s.mean_leaf_primitives);
        assert!(s.max_leaf_depth as f64 >= s.mean_leaf_depth);
    }
    assert_eq!(octree.empty_leaves, 0, "octants without primitives have no node");
    assert_eq!(kdtree.nodes, 2 * kdtree.leaves - 1);
    assert!(octree.max_leaf_depth <= OctreeOptions::default().max_depth);
}

#[test]
fn ordered_walks_stop_at_the_first_hit() {
    // A stack of tessellated planes: behind the first one, nothing need be looked at.
    let mut triangles = Vec::new();
    for layer in 0..50 {
        let z = -(layer as f32);
        for (i, j) in (0..10).flat_map(|i| (0..10).map(move |j| (i as f32, j as f32))) {
            triangles.push([vec3(i, j, z), vec3(i + 1.0, j, z), vec3(i + 1.0, j + 1.0, z)]);
            triangles.push([vec3(i, j, z), vec3(i + 1.0, j + 1.0, z), vec3(i, j + 1.0, z)]);
        }
    }
    let world = World::new(triangles, vec![]);
    let scene = world.geometry();
    let down = ray(vec3(4.3, 5.2, 3.0), vec3(0.0, 0.0, -1.0));
    let tests = |work: &CountWork| work.primitives.get();
    let octree = Octree::build(&scene, &OctreeOptions::default());
    let (basic, parametric) =
        (octree.tracer(CountWork::default()), octree.parametric_tracer(CountWork::default()));
    let grid = Grid::build(&scene, &GridOptions::default());
    let kdtree = KdTree::build(&scene, &KdTreeOptions::default());
    let (grid, kdtree) = (grid.tracer(CountWork::default()), kdtree.tracer(CountWork::default()));
    let t = [
        basic.closest_hit(&down, &RayFilter::ALL).t,
        parametric.closest_hit(&down, &RayFilter::ALL).t,
        grid.closest_hit(&down, &RayFilter::ALL).t,
        kdtree.closest_hit(&down, &RayFilter::ALL).t,
    ];
    assert_eq!(t, [3.0; 4]);
    assert!(tests(&basic.work) >= 50, "one in every layer: {}", tests(&basic.work));
    for work in [&parametric.work, &grid.work, &kdtree.work] {
        assert!((1..40).contains(&tests(work)), "{}", tests(work));
    }
}

/// Five walls whose corners are corners of cells, and two tessellated balls.
fn cornell_box() -> World {
    let mut triangles = Vec::new();
    let mut quad = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| triangles.extend([[a, b, c], [a, c, d]]);
    let corner = |k: u32| {
        let pick = |bit: u32, low: f32, high: f32| if k & bit == 0 { low } else { high };
        vec3(pick(4, -1.0, 1.0), pick(2, 0.0, 2.0), pick(1, -1.0, 1.0))
    };
    for [a, b, c, d] in [[0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [0, 2, 3, 1], [4, 5, 7, 6]] {
        quad(corner(a), corner(b), corner(c), corner(d));
    }
    let (rings, sectors) = (10, 16);
    for center in [vec3(-0.4, 0.3, -0.3), vec3(0.45, 0.3, 0.25)] {
        let at = |ring: usize, sector: usize| {
            let theta = std::f32::consts::PI * ring as f32 / rings as f32;
            let phi = std::f32::consts::TAU * (sector % sectors) as f32 / sectors as f32;
            center + vec3(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()) * 0.3
        };
        for (i, j) in (0..rings).flat_map(|i| (0..sectors).map(move |j| (i, j))) {
            quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        }
    }
    World::new(triangles, vec![])
}

#[test]
fn every_camera_and_shadow_ray_of_a_cornell_box_agrees() {
    let world = cornell_box();
    let structures = Structures::new(&world);
    let reference = structures.exhaustive.tracer(IgnoreWork);
    let same = |name: &str, tracer: &dyn Fn(&Ray) -> Hit, ray: &Ray, expected: &Hit| {
        let bits = |h: &Hit| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.id);
        let hit = tracer(ray);
        assert_eq!(bits(&hit), bits(expected), "{name}: {hit:?} instead of {expected:?} for {ray:?}");
    };
    let all = RayFilter::ALL;
    let (octree, fine) = (&structures.octrees[0], &structures.octrees[1]);
    let (grid, kdtree) = (&structures.grids[0], &structures.kdtrees[0]);
    for (x, y) in (0..100).flat_map(|y| (0..100).map(move |x| (x, y))) {
        let at = |k: i32| (k as f32 - 49.5) * (0.31 / 50.0);
        let camera = ray(vec3(0.0, 1.0, 4.42), vec3(at(x), at(y), -1.0).normalize());
        let first = reference.closest_hit(&camera, &all);
        let point = camera.origin.plus_scaled(camera.direction, first.t.min(10.0));
        let to_light = (vec3(0.1, 1.98, 0.1) - point).normalize();
        for r in [camera, ray(point, to_light)] {
            let expected = reference.closest_hit(&r, &all);
            same("octree", &|r| octree.tracer(IgnoreWork).closest_hit(r, &all), &r, &expected);
            for octree in [octree, fine] {
                let tracer = octree.parametric_tracer(IgnoreWork);
                same("parametric", &|r| tracer.closest_hit(r, &all), &r, &expected);
            }
            same("grid", &|r| grid.tracer(IgnoreWork).closest_hit(r, &all), &r, &expected);
            same("kdtree", &|r| kdtree.tracer(IgnoreWork).closest_hit(r, &all), &r, &expected);
        }
    }
}

#[test]
fn a_padded_separating_axis_test_saves_references() {
    let mut random = Random(21);
    let world = World::new(primitives(Kind::Soup, 3000, &mut random).0, vec![]);
    let build = |overlap| {
        let options = OctreeOptions { overlap, only_if_cheaper: false, max_depth: 5, ..Default::default() };
        Octree::build(&world.geometry(), &options).statistics().references
    };
    let [bounds, triangle, unpadded] =
        [Overlap::Bounds, Overlap::Triangle, Overlap::UnpaddedTriangle].map(build);
    assert!(bounds > triangle && triangle >= unpadded && unpadded >= 3000, "{bounds} {triangle} {unpadded}");
}
