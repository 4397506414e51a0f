//! What renders count: the same for any threads and tiles, and what others count by themselves. Counting changes no pixel.

use eosphor_accel::UseTracer;
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::{CountWork, ExhaustiveTracer, IgnoreWork, Tracer};
use eosphor_core::integrator::{RayCounts, render_pixel};
use eosphor_core::intersect::{LocalRay, Slab};
use eosphor_core::math::vec3;
use eosphor_core::ray::{Hit, Ray, RayFilter};
use eosphor_core::settings::ShadowMode;
use eosphor_render::{
    Accel, Backend, CpuBackend, CpuOptions, Film, Hierarchy, RayStatistics, RenderControl, build_hierarchy,
};
use eosphor_scene::{Instance, LoadOptions, Preset, Scene, SceneData, Transform, load};
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A query that a render asks.
#[derive(Clone, Copy)]
enum Query {
    Closest,
    Any,
    Next(Hit),
}

/// Answers by testing everything, and writes down what is asked.
struct Recorder<'a> {
    tracer: ExhaustiveTracer<'a, IgnoreWork>,
    asked: RefCell<Vec<(Ray, RayFilter, Query)>>,
}

impl Recorder<'_> {
    fn note(&self, ray: &Ray, filter: &RayFilter, query: Query) {
        self.asked.borrow_mut().push((*ray, *filter, query));
    }
}

impl Tracer for Recorder<'_> {
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        self.note(ray, filter, Query::Closest);
        self.tracer.closest_hit(ray, filter)
    }
    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        self.note(ray, filter, Query::Any);
        self.tracer.occluded(ray, filter)
    }
    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        self.note(ray, filter, Query::Next(*after));
        self.tracer.next_hit(ray, filter, after)
    }
}

/// All that a picture asks, and its rays.
fn asked(scene: &SceneData) -> (Vec<(Ray, RayFilter, Query)>, RayStatistics) {
    let Hierarchy::Exhaustive(all) = build_hierarchy(Accel::None, &Default::default(), scene).unwrap() else {
        unreachable!("what was asked for")
    };
    let recorder = Recorder { tracer: all.tracer(IgnoreWork), asked: RefCell::default() };
    let view = scene.view();
    let mut counts = RayCounts::default();
    for y in 0..view.settings.height {
        for x in 0..view.settings.width {
            render_pixel::<_, 16>(&view, &recorder, x, y, &mut counts);
        }
    }
    (recorder.asked.into_inner(), counts.into())
}

fn render(scene: &Arc<SceneData>, options: CpuOptions, count_work: bool) -> (Film, RayStatistics) {
    let prepared = CpuBackend::new(options).unwrap().prepare(Arc::clone(scene)).unwrap();
    let cancel = AtomicBool::new(false);
    let control = RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work, frame: None };
    let rendered = prepared.render(&control).unwrap();
    assert!(rendered.complete);
    (rendered.film, rendered.statistics)
}

fn options(accel: Accel, threads: usize) -> CpuOptions {
    CpuOptions { accel, threads: Some(threads), ..CpuOptions::default() }
}

/// Without what clocks say.
fn counts(statistics: &RayStatistics) -> RayStatistics {
    RayStatistics { times: Default::default(), ..*statistics }
}

/// The Cornell box, small; coloured shadows, glass and a mirror.
fn cornell() -> Scene {
    let mut scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
    (scene.settings.size, scene.settings.samples, scene.settings.light_samples) = ([20, 16], 1, 3);
    scene
}

/// The same with all of it placed three times, so that there are instances.
fn placed() -> Scene {
    let mut scene = cornell();
    scene.settings.shadows = ShadowMode::Opaque;
    let own = scene.instances.clone();
    for offset in [vec3(1.5, 0.5, -4.0), vec3(-1.5, 0.25, -3.0)] {
        let placed = own.iter().map(|instance| Instance {
            world_from_object: Transform { translate: offset, ..Transform::default() },
            ..instance.clone()
        });
        scene.instances.extend(placed);
    }
    scene
}

fn flat(scene: &Scene) -> Arc<SceneData> {
    Arc::new(SceneData::flatten(scene).unwrap().0)
}

/// How much the scalar traversal of a structure has to do for one query, counted by itself.
fn count(hierarchy: &Hierarchy, (ray, filter, query): &(Ray, RayFilter, Query)) -> (u64, u64) {
    struct Ask<'a>(&'a Ray, &'a RayFilter, &'a Query);
    impl UseTracer for Ask<'_> {
        type Output = ();
        fn run<T: Tracer>(self, tracer: T) {
            let Ask(ray, filter, query) = self;
            match query {
                Query::Closest => drop(tracer.closest_hit(ray, filter)),
                Query::Any => drop(tracer.occluded(ray, filter)),
                Query::Next(after) => drop(tracer.next_hit(ray, filter, after)),
            }
        }
    }
    #[derive(Clone, Copy)]
    struct Told<'a>(&'a CountWork);
    impl eosphor_core::hierarchy::Work for Told<'_> {
        fn nodes(&self, count: u32) {
            self.0.nodes(count);
        }
        fn primitives(&self, count: u32) {
            self.0.primitives(count);
        }
    }
    let work = CountWork::default();
    hierarchy.with_counting_tracer(hierarchy, Told(&work), Ask(ray, filter, query));
    (work.nodes.get(), work.primitives.get())
}

#[test]
fn counting_changes_no_pixel_and_threads_no_count() {
    for (name, scene) in [("cornell", cornell()), ("placed", placed())] {
        let scene = flat(&scene);
        for &accel in Accel::ALL {
            let (film, rays) = render(&scene, options(accel, 2), false);
            assert_eq!(
                (rays.searches, rays.nodes_visited, rays.primitive_tests),
                (0, 0, 0),
                "{name} {accel}"
            );
            assert_eq!(rays.times, Default::default(), "{name} {accel}: clocks run unasked");
            let (counted, one) = render(&scene, options(accel, 1), true);
            assert!(film == counted, "{name} {accel}: counting changes the picture");
            for other in [options(accel, 3), CpuOptions { tile: Some(5), ..options(accel, 2) }] {
                let (again, several) = render(&scene, other, true);
                assert!(film == again, "{name} {accel}");
                assert_eq!(counts(&one), counts(&several), "{name} {accel}");
            }
            assert_eq!(one.total_rays(), rays.total_rays(), "{name} {accel}");
        }
    }
}

/// Every search of every ray is written down by a scheduler and a tracer of the test, and done again.
#[test]
fn counts_are_those_of_the_searches_that_a_picture_asks() {
    for (name, scene) in [("cornell", cornell()), ("placed", placed())] {
        let scene = flat(&scene);
        let (searches, rays) = asked(&scene);
        for &accel in Accel::ALL {
            let (_, found) = render(&scene, options(accel, 2), true);
            let hierarchy = build_hierarchy(accel, &CpuOptions::default().hierarchy, &scene).unwrap();
            let mut expected = RayStatistics { searches: searches.len() as u64, ..rays };
            for search in &searches {
                let (nodes, tests) = count(&hierarchy, search);
                expected.nodes_visited += nodes;
                expected.primitive_tests += tests;
            }
            assert_eq!(counts(&found), expected, "{name} {accel}");
        }
    }
}

/// Without a hierarchy each search tests everything, and each ray is one search where shadows are opaque.
#[test]
fn without_a_hierarchy_every_ray_tests_every_primitive() {
    let mut scene = cornell();
    Preset::Pg1.apply(&mut scene);
    (scene.settings.size, scene.settings.light_samples) = ([12, 12], 3);
    let scene = flat(&scene);
    let (_, rays) = render(&scene, options(Accel::None, 2), true);
    assert!(rays.shadow > 0 && rays.reflected > 0);
    assert_eq!((scene.triangles.len(), scene.instances.len()), (2188, 1));
    assert_eq!(rays.searches, rays.total_rays());
    assert_eq!((rays.nodes_visited, rays.primitive_tests), (0, 2188 * rays.total_rays()));
}

/// What misses everything visits every node whose parent it enters, in any order.
#[test]
fn rays_that_miss_visit_what_they_enter() {
    let scene = flat(&placed());
    let (searches, _) = asked(&scene);
    let Hierarchy::Bvh(bvh) = build_hierarchy(Accel::Bvh, &Default::default(), &scene).unwrap() else {
        unreachable!("what was asked for")
    };
    let hierarchy = Hierarchy::Bvh(bvh.clone());
    let (nodes, order) = (&bvh.nodes(), &bvh.instance_order());
    // Nodes and tests below a node; `leaf` is told of leaves that are entered.
    fn below(
        nodes: &[eosphor_core::hierarchy::BvhNode],
        at: u32,
        enters: &dyn Fn(&Bounds) -> bool,
        leaf: &mut dyn FnMut(u32, u32),
    ) -> u64 {
        let node = &nodes[at as usize];
        if !enters(&node.bounds()) {
            return 1;
        }
        if !node.is_inner() {
            leaf(node.first, node.count & 0x7FFF_FFFF);
            return 1;
        }
        1 + below(nodes, node.first, enters, leaf) + below(nodes, node.first + 1, enters, leaf)
    }
    let mut misses = 0;
    for search in &searches {
        let (ray, filter, query) = search;
        let is_miss = match query {
            Query::Closest => bvh.tracer(IgnoreWork).closest_hit(ray, filter).is_miss(),
            Query::Any => !bvh.tracer(IgnoreWork).occluded(ray, filter),
            Query::Next(_) => false,
        };
        // What culls and leaves out changes no visit, but a triangle that is left out is no hit.
        if !is_miss {
            continue;
        }
        misses += 1;
        let (mut visited, mut tests) = (0, 0);
        let enters = |slab: &Slab, t_min: f32, bounds: &Bounds| {
            let (near, far) = slab.interval(bounds, t_min);
            Slab::passes(near, far, ray.t_max)
        };
        let mut entered = Vec::new();
        let world = LocalRay::new(ray, scene.geometries[0].extent);
        visited += below(nodes, bvh.roots()[0], &|b| enters(&world.slab, world.t_min, b), &mut |_, count| {
            tests += u64::from(count);
        });
        let slab = Slab::new(ray.origin, ray.direction, 0.0);
        visited +=
            below(nodes, bvh.instance_root(), &|b| enters(&slab, ray.t_min, b), &mut |first, count| {
                entered.extend_from_slice(&order[first as usize..][..count as usize]);
            });
        for number in entered {
            let instance = &scene.instances[number as usize];
            if !enters(&slab, ray.t_min, &instance.world_bounds) {
                continue;
            }
            let extent = scene.geometries[instance.geometry as usize].extent;
            let local = LocalRay::mapped(ray, &instance.object_from_world, extent);
            let root = bvh.roots()[instance.geometry as usize];
            visited += below(nodes, root, &|b| enters(&local.slab, local.t_min, b), &mut |_, count| {
                tests += u64::from(count);
            });
        }
        assert_eq!(count(&hierarchy, search), (visited, tests), "{ray:?}");
    }
    assert!(misses > 100, "{misses}");
}
