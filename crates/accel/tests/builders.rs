//! Every builder gives the hits of no structure at all; trees are bounded, the same for any number of threads, and can
//! take new shapes.

mod support;

use eosphor_accel::bvh8::{Child, EMPTY, INSTANCE, LEAF, PLACE, SPHERE};
use eosphor_accel::{BuildOptions, Builder, Bvh, Bvh8, Exhaustive, Quality, RefitError};
use eosphor_core::geometry::{Bounds, Sphere};
use eosphor_core::hierarchy::{BvhNode, IgnoreWork, MAX_BVH_DEPTH, Tracer};
use eosphor_core::intersect::LARGEST_NUMBER;
use eosphor_core::intersect::sphere_bounds;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::{Hit, Ray, RayFilter};
use support::{Random, World, affine};

fn all_options() -> impl Iterator<Item = BuildOptions> {
    Builder::ALL.into_iter().map(BuildOptions::of)
}

/// Whether triangles may stand in several leaves of a hierarchy with eight children a node.
fn cuts(options: &BuildOptions) -> bool {
    matches!(options.builder, Builder::Spatial | Builder::Binned | Builder::Morton)
}

/// Triangles of many sizes: some long and crossing the whole, so that spatial splits have what to cut.
fn city(count: usize, seed: u64) -> Vec<[Vec3; 3]> {
    let mut random = Random(seed);
    (0..count)
        .map(|k| {
            let at = random.in_cube() * 10.0;
            let size = if k % 7 == 0 { 12.0 } else { 0.3 };
            let tip = if k % 5 == 0 { vec3(1.0, 0.01, 0.02) } else { Vec3::ONE };
            [at, at + random.in_cube() * tip * size, at + random.in_cube() * tip * size]
        })
        .collect()
}

fn balls(count: usize, seed: u64) -> Vec<Sphere> {
    let mut random = Random(seed);
    (0..count)
        .map(|_| Sphere { center: random.in_cube() * 10.0, radius: 0.05 + 0.3 * random.unit() as f32 })
        .collect()
}

fn rays(world: &World, count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random(seed);
    let extent = world.extent().max(1e-3);
    (0..count)
        .map(|k| {
            let mut origin = random.in_cube() * (extent * if k % 3 == 0 { 0.5 } else { 2.0 });
            let mut direction = random.direction();
            if k % 2 == 0 && !world.triangles.is_empty() {
                // At an edge or a corner.
                let [a, b, c] = world.triangles[random.below(world.triangles.len())];
                let p = a + (b - a) * random.unit() as f32;
                let target = if k % 4 == 0 { p } else { p + (c - p) * (random.below(3) as f32 * 0.5) };
                direction = (target - origin).normalize_or(direction);
            } else if k % 5 == 0 {
                direction = vec3(0.0, if k % 10 == 0 { 1.0 } else { -1.0 }, 0.0);
                origin.x = 0.0;
            }
            Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
        })
        .collect()
}

fn bits(hit: &Hit) -> (u32, u32, u32, eosphor_core::ray::PrimitiveId) {
    (hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.id)
}

fn assert_same_hits(world: &World, bvh: &Bvh, rays: &[Ray], name: &str) {
    let exhaustive = Exhaustive::new(&world.geometry());
    let (reference, tracer) = (exhaustive.tracer(IgnoreWork), bvh.tracer(IgnoreWork));
    for ray in rays {
        let expected = reference.closest_hit(ray, &RayFilter::ALL);
        let hit = tracer.closest_hit(ray, &RayFilter::ALL);
        assert_eq!(bits(&hit), bits(&expected), "{name}: {hit:?} instead of {expected:?} for {ray:?}");
        assert_eq!(tracer.occluded(ray, &RayFilter::ALL), !expected.is_miss(), "{name}: {ray:?}");
        let next = reference.next_hit(ray, &RayFilter::ALL, &expected);
        assert_eq!(bits(&tracer.next_hit(ray, &RayFilter::ALL, &expected)), bits(&next), "{name}: {ray:?}");
    }
}

fn holds(outer: &Bounds, inner: &Bounds) -> bool {
    outer.union(inner) == *outer
}

/// Walks an 8-wide hierarchy: boxes hold what is inside, every primitive is reached, and (without spatial splits) once
/// and with all of its box. Returns the depth.
fn check_wide(world: &World, bvh: &Bvh8, whole: bool, name: &str) -> usize {
    let mut deepest = 0;
    for (number, geometry) in world.geometries.iter().enumerate() {
        let mut seen = vec![0; (geometry.triangle_count + geometry.sphere_count) as usize];
        let everything = Bounds { min: Vec3::splat(f32::NEG_INFINITY), max: Vec3::splat(f32::INFINITY) };
        let mut pending = vec![(bvh.roots()[number], everything, 0)];
        while let Some((child, bounds, depth)) = pending.pop() {
            deepest = deepest.max(depth);
            if child == EMPTY {
                assert!(depth > 0 || seen.is_empty(), "{name}");
                continue;
            }
            if child & LEAF == 0 {
                pending.extend(
                    children_of(bvh, child, &bounds, name).into_iter().map(|(c, b)| (c, b, depth + 1)),
                );
            } else if child & SPHERE != 0 {
                let place = (child & PLACE) as usize;
                let primitive = bvh.sphere_primitives()[place];
                let at = geometry.first_sphere + primitive - geometry.triangle_count;
                assert_eq!(bvh.spheres()[place], world.spheres[at as usize], "{name}");
                assert!(holds(&bounds, &sphere_bounds(&bvh.spheres()[place])), "{name}");
                seen[primitive as usize] += 1;
            } else {
                let block = &bvh.blocks()[(child & PLACE) as usize];
                let used = block.primitive.iter().take_while(|&&p| p != u32::MAX).count();
                assert!(used > 0 && block.primitive[used..].iter().all(|&p| p == u32::MAX), "{name}");
                for lane in 0..used {
                    let triangle = block.get(lane);
                    if whole {
                        assert!(holds(&bounds, &triangle.bounds()), "{name}: {triangle:?} {bounds:?}");
                    }
                    seen[triangle.primitive as usize] += 1;
                }
            }
        }
        assert!(seen.iter().all(|&n| if whole { n == 1 } else { n >= 1 }), "{name}");
    }
    deepest
}

/// The children of a node, whose boxes lie in its own; empty ones are inside out, and all orders name all places once,
/// empty ones first.
fn children_of(bvh: &Bvh8, node: Child, bounds: &Bounds, name: &str) -> Vec<(Child, Bounds)> {
    let node = &bvh.nodes()[node as usize];
    let boxes: Vec<(Child, Bounds)> = (0..8)
        .map(|k| {
            let p = &node.planes;
            let b = Bounds { min: vec3(p[0][k], p[2][k], p[4][k]), max: vec3(p[1][k], p[3][k], p[5][k]) };
            (node.children[k], b)
        })
        .collect();
    for order in node.orders {
        let places: Vec<usize> = (0..8).map(|k| (order >> (3 * k) & 7) as usize).collect();
        let mut sorted = places.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, [0, 1, 2, 3, 4, 5, 6, 7], "{name}");
        assert!(places.windows(2).all(|w| boxes[w[0]].0 == EMPTY || boxes[w[1]].0 != EMPTY), "{name}");
    }
    for (child, b) in &boxes {
        assert!(
            if *child == EMPTY { b.min.x > b.max.x } else { holds(bounds, b) },
            "{name}: {child:x} {b:?}"
        );
    }
    boxes
}

#[test]
fn hits_are_the_same_through_every_builder() {
    let mut worlds = vec![
        World::new(city(1500, 1), vec![]),
        World::new(city(300, 2), balls(300, 3)),
        World::new(vec![], balls(50, 4)),
    ];
    let mut placed = World::new(city(40, 5), balls(5, 6));
    let geometry = placed.add_geometry(&city(300, 7), &balls(20, 8));
    let mut random = Random(9);
    for _ in 0..12 {
        let angles = [random.unit() * 6.0, random.unit() * 6.0, 0.3];
        placed.add_instance(geometry, affine(vec3(0.5, 0.7, -0.4), angles, random.in_cube() * 20.0));
    }
    worlds.push(placed);
    for (number, world) in worlds.iter().enumerate() {
        let rays = rays(world, 1000, 10 + number as u64);
        for options in all_options() {
            let name = format!("world {number}, {}", options.builder);
            assert_same_hits(world, &Bvh::build(&world.geometry(), &options), &rays, &name);
            let small = BuildOptions { max_leaf_primitives: 1, traversal_cost: 0.1, ..options };
            assert_same_hits(world, &Bvh::build(&world.geometry(), &small), &rays[..300], &name);
        }
    }
}

#[test]
fn wide_trees_hold_everything() {
    let mut world = World::new(city(3000, 1), balls(500, 2));
    let geometry = world.add_geometry(&city(700, 3), &[]);
    for k in 0..30 {
        world.add_instance(geometry, affine(Vec3::ONE, [k as f64, 0.0, 0.0], vec3(k as f32, 0.0, 0.0)));
    }
    for options in all_options() {
        let name = options.builder.to_string();
        let bvh = Bvh8::build(&world.geometry(), &options);
        check_wide(&world, &bvh, !cuts(&options), &name);
        let mut pending = vec![bvh.instance_root()];
        let mut seen = vec![0; world.instances.len()];
        while let Some(child) = pending.pop() {
            if child == EMPTY {
                continue;
            }
            if child & LEAF == 0 {
                pending.extend(bvh.nodes()[child as usize].children);
            } else {
                assert!(child & INSTANCE != 0 && child & SPHERE == 0, "{name}");
                seen[(child & PLACE) as usize] += 1;
            }
        }
        assert!(seen[0] == 0 && seen[1..].iter().all(|&n| n == 1), "{name}: {seen:?}");
    }
}

#[test]
fn spatial_splits_cut_and_lose_no_point_of_a_triangle() {
    let world = World::new(city(3000, 4), vec![]);
    let bvh = Bvh8::build(&world.geometry(), &Quality::High.options());
    // Leaves by primitive.
    let mut parts: Vec<Vec<Bounds>> = vec![Vec::new(); world.triangles.len()];
    let mut references = 0;
    for n in 0..bvh.nodes().len() {
        let everything = Bounds { min: Vec3::splat(f32::NEG_INFINITY), max: Vec3::splat(f32::INFINITY) };
        for (child, bounds) in children_of(&bvh, n as Child, &everything, "high") {
            if child != EMPTY && child & LEAF != 0 {
                for primitive in bvh.blocks()[(child & PLACE) as usize].primitive {
                    if primitive != u32::MAX {
                        parts[primitive as usize].push(bounds);
                        references += 1;
                    }
                }
            }
        }
    }
    assert!(references > world.triangles.len() * 11 / 10, "{references}");
    assert!(references <= world.triangles.len() * 13 / 10, "{references}");
    let mut random = Random(5);
    for (triangle, parts) in world.triangles.iter().zip(&parts) {
        for _ in 0..40 {
            let (mut u, mut v) = (random.unit() as f32, random.unit() as f32);
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            if random.below(3) == 0 {
                u = 0.0;
            }
            let [a, b, c] = *triangle;
            let p = a + (b - a) * u + (c - a) * v;
            let around = Bounds { min: p, max: p }.with_slack();
            assert!(parts.iter().any(|b| holds(b, &around)), "{p:?} of {triangle:?}: {parts:?}");
        }
    }
}

#[test]
fn any_number_of_threads_builds_the_same() {
    // More than what is split by all threads together.
    let mut triangles = city(66_000, 5);
    triangles.extend((0..4000).map(|k| {
        let z = if k % 2 == 0 { 0.0 } else { -0.0 };
        [vec3(0.0, 0.0, z), vec3(1.0, 0.0, z), vec3(0.0, 1.0, z)]
    }));
    let world = World::new(triangles, balls(3000, 6));
    for options in all_options().filter(|o| o.builder != Builder::Hybrid) {
        let build = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                (Bvh::build(&world.geometry(), &options), Bvh8::build(&world.geometry(), &options))
            })
        };
        let (one, one8) = build(1);
        for threads in [2, 3, 8] {
            let (many, many8) = build(threads);
            let name = format!("{}, {threads} threads", options.builder);
            // Debug writes distinguish zeros by their sign.
            let text = |nodes: &[BvhNode]| -> Vec<[u32; 8]> {
                let b = f32::to_bits;
                let of = |n: &BvhNode| {
                    let (l, h) = (n.min, n.max);
                    [b(l.x), b(l.y), b(l.z), n.first, b(h.x), b(h.y), b(h.z), n.count]
                };
                nodes.iter().map(of).collect()
            };
            assert!(text(many.nodes()) == text(one.nodes()), "{name}");
            assert!(many.primitives().triangles() == one.primitives().triangles(), "{name}");
            assert!(many.primitives().sphere_primitives() == one.primitives().sphere_primitives(), "{name}");
            assert!(many8.nodes() == one8.nodes() && many8.blocks() == one8.blocks(), "{name}");
            assert!(
                many8.sphere_primitives() == one8.sphere_primitives() && many8.roots() == one8.roots(),
                "{name}"
            );
        }
    }
}

#[test]
fn nasty_input_is_bounded() {
    let tiny = |at: Vec3, size: f32| [at, at + vec3(size, 0.0, 0.0), at + vec3(0.0, size, 0.0)];
    let powers: Vec<_> = (-60..60).map(|k| tiny(vec3(2f32.powi(k), 0.0, 0.0), 2f32.powi(k) * 0.1)).collect();
    let crowds: Vec<_> = powers.iter().flat_map(|t| vec![*t; 100]).collect();
    let nested: Vec<_> = (0..3000).map(|k| tiny(Vec3::ZERO, 1.01f32.powi(k - 2000))).collect();
    let crossing: Vec<_> = (0..2000)
        .map(|k| {
            let a = k as f32 * 0.003;
            [vec3(a.cos(), a.sin(), -1.0), vec3(-a.cos(), -a.sin(), 1.0), vec3(a.sin(), 0.1, a.cos())]
        })
        .collect();
    let flat: Vec<_> = city(3000, 1).iter().map(|t| t.map(|p| vec3(p.x, 0.5, p.z))).collect();
    let line: Vec<_> = (0..3000).map(|k| [vec3(k as f32, 0.0, 0.0); 3]).collect();
    // To the end of the range; what lies beyond is no SceneGeometry (`adversarial`).
    let largest = city(500, 2).as_flattened().iter().fold(0.0, |m: f32, p| m.max(p.abs().max_component()));
    let huge: Vec<_> =
        city(500, 2).iter().map(|t| t.map(|p| p * (LARGEST_NUMBER / largest * 0.99))).collect();
    let equal_balls = vec![Sphere { center: vec3(0.5, 0.5, 0.5), radius: 0.25 }; 500];
    let worlds = [
        ("crowds", World::new(crowds, vec![])),
        ("nested", World::new(nested, vec![])),
        ("crossing", World::new(crossing, vec![])),
        ("flat", World::new(flat, vec![])),
        ("line", World::new(line, vec![])),
        ("huge", World::new(huge, vec![Sphere { center: Vec3::ZERO, radius: 0.99 * LARGEST_NUMBER }; 20])),
        ("20,000 equal", World::new(vec![tiny(Vec3::ONE, 1.0); 20_000], equal_balls)),
        ("one", World::new(vec![tiny(Vec3::ONE, 1.0)], vec![])),
        ("one ball", World::new(vec![], balls(1, 1))),
        ("empty", World::new(vec![], vec![])),
    ];
    for (name, world) in &worlds {
        for options in all_options() {
            let name = format!("{name}, {}", options.builder);
            let bvh = Bvh::build(&world.geometry(), &options);
            let depth = bvh.statistics().max_leaf_depth as usize;
            assert!(depth < MAX_BVH_DEPTH && depth <= options.max_depth as usize + 1, "{name}: {depth}");
            assert!(bvh.sah_cost() >= 0.0, "{name}");
            let bvh8 = Bvh8::build(&world.geometry(), &options);
            let depth = check_wide(world, &bvh8, !cuts(&options), &name);
            assert!(depth < MAX_BVH_DEPTH, "{name}: {depth}");
            assert_same_hits(world, &bvh, &rays(world, 12, 3), &name);
        }
    }
}

#[test]
fn refitted_trees_have_the_hits_of_new_ones() {
    let mut world = World::new(city(800, 1), balls(100, 2));
    let geometry = world.add_geometry(&city(200, 3), &balls(10, 4));
    for k in 0..8 {
        world.add_instance(
            geometry,
            affine(Vec3::ONE, [0.2 * f64::from(k), 0.0, 0.0], vec3(k as f32, 5.0, 0.0)),
        );
    }
    let moved = {
        let twist = |p: Vec3| vec3(p.x + 0.5 * p.y, p.y * 1.5, p.z - 0.2 * p.x);
        let part = |number: usize| {
            let g = &world.geometries[number];
            let t = &world.triangles[g.first_triangle as usize..][..g.triangle_count as usize];
            let s = &world.spheres[g.first_sphere as usize..][..g.sphere_count as usize];
            let triangles: Vec<_> = t.iter().map(|t| t.map(twist)).collect();
            let spheres: Vec<_> =
                s.iter().map(|s| Sphere { center: twist(s.center), radius: s.radius * 1.2 }).collect();
            (triangles, spheres)
        };
        let (triangles, spheres) = part(0);
        let mut moved = World::new(triangles, spheres);
        let (triangles, spheres) = part(1);
        let geometry = moved.add_geometry(&triangles, &spheres);
        for k in 0..8 {
            moved.add_instance(
                geometry,
                affine(vec3(1.0, 2.0, 1.0), [0.0, 0.3, 0.0], vec3(0.0, k as f32, 3.0)),
            );
        }
        moved
    };
    let rays = rays(&moved, 1500, 7);
    for options in all_options() {
        let name = format!("{} refitted", options.builder);
        let mut bvh = Bvh::build(&world.geometry(), &options);
        bvh.refit(&moved.geometry()).unwrap();
        assert_same_hits(&moved, &bvh, &rays, &name);
        let mut bvh8 = Bvh8::build(&world.geometry(), &options);
        bvh8.refit(&moved.geometry()).unwrap();
        // Whole boxes, though maybe several of some triangles.
        check_wide(&moved, &bvh8, !cuts(&options), &name);
        // The same shapes again are the same boxes.
        let (before, before8) = (bvh.nodes().to_vec(), bvh8.clone());
        bvh.refit(&moved.geometry()).unwrap();
        bvh8.refit(&moved.geometry()).unwrap();
        assert!(
            bvh.nodes() == before && bvh8.nodes() == before8.nodes() && bvh8.blocks() == before8.blocks(),
            "{name}"
        );
        let other = World::new(city(799, 1), balls(101, 2));
        assert!(matches!(bvh.refit(&other.geometry()), Err(RefitError::Counts { .. })));
        assert!(matches!(bvh8.refit(&other.geometry()), Err(RefitError::Counts { .. })));
    }
}

#[test]
fn refitting_another_number_of_primitives_is_an_error() {
    let world = World::new(city(80, 1), balls(10, 2));
    let mut bvh = Bvh::build(&world.geometry(), &BuildOptions::default());
    let fewer = World::new(city(79, 1), balls(10, 2));
    let error = bvh.refit(&fewer.geometry()).unwrap_err();
    assert_eq!(error, RefitError::Geometry { number: 0 });
    assert!(error.to_string().contains("geometry 0"), "{error}");
    assert_same_hits(&world, &bvh, &rays(&world, 100, 1), "unchanged");
}

/// A floor that is large beside all else is cut beforehand: without, its box would be that of every node above it. But
/// where everything is large, nothing is.
#[test]
fn few_large_triangles_are_cut() {
    let floor = |k: usize| {
        let corner = |x: f32, y: f32| vec3(x, y, 0.1 * x - 0.2 * y);
        let turned = if k == 0 { 1.0 } else { -1.0 };
        [corner(-10.0, -10.0 * turned), corner(10.0, 10.0 * turned), corner(10.0 * turned, -10.0)]
    };
    let mut triangles = city(2000, 1);
    triangles.retain(|t| (t[1] - t[0]).length().max((t[2] - t[0]).length()) < 1.0);
    let references = |triangles: &[[Vec3; 3]], builder: Builder| {
        let world = World::new(triangles.to_vec(), vec![]);
        let options = BuildOptions { cut_large_triangles: true, ..BuildOptions::of(builder) };
        let bvh = Bvh8::build(&world.geometry(), &options);
        bvh.blocks().iter().flat_map(|b| b.primitive).filter(|&p| p != u32::MAX).count() - triangles.len()
    };
    assert_eq!(references(&triangles, Builder::Binned), 0);
    triangles.extend([floor(0), floor(1)]);
    for builder in [Builder::Binned, Builder::Morton] {
        let parts = references(&triangles, builder);
        assert!((10..=triangles.len() / 16).contains(&parts), "{builder}: {parts}");
    }
    assert_eq!(references(&triangles, Builder::Sweep), 0);
    let all_large: Vec<_> = city(2000, 1).into_iter().step_by(7).collect();
    assert!(references(&all_large, Builder::Binned) <= all_large.len() / 16);
}

#[test]
fn binned_and_spatial_trees_are_about_as_good_as_the_sweep() {
    let world = World::new(city(20_000, 1), vec![]);
    let cost = |builder: Builder| Bvh::build(&world.geometry(), &BuildOptions::of(builder)).sah_cost();
    let sweep = cost(Builder::Sweep);
    assert!(cost(Builder::Binned) <= 1.05 * sweep, "{} {sweep}", cost(Builder::Binned));
    assert!(cost(Builder::Spatial) <= 0.95 * sweep, "{} {sweep}", cost(Builder::Spatial));
    // A tree of one leaf costs its primitives.
    let three = World::new(vec![[Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)]; 3], vec![]);
    assert_eq!(Bvh::build(&three.geometry(), &BuildOptions::default()).sah_cost(), 3.0);
}

#[test]
fn names_of_builders_and_qualities_are_read_as_they_are_written() {
    for builder in Builder::ALL {
        assert_eq!(builder.to_string().parse::<Builder>(), Ok(builder));
    }
    for quality in Quality::ALL {
        assert_eq!(quality.to_string().parse::<Quality>(), Ok(quality));
    }
    let error = "best".parse::<Quality>().unwrap_err();
    assert_eq!(error, "unknown quality 'best': choose one of low, medium, high");
    assert_eq!("sah".parse::<Builder>().unwrap_err().split(": ").count(), 2);
    assert_eq!(BuildOptions::from(Quality::Low).builder, Builder::Morton);
}
