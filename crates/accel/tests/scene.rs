//! Scenes made by hand.

use eosphor_accel::{
    Affine, Bounds, BuildOptions, Bvh, Bvh8, Exhaustive, Hit, IgnoreWork, MeshId, PrimitiveId, Ray,
    RayFilter, Scene, SceneError, Sphere, Tracer, Vec3, indexed, vec3,
};

const TRIANGLE: [Vec3; 3] = [vec3(0.0, 0.0, 0.0), vec3(3.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)];
const BALL: Sphere = Sphere { center: vec3(0.0, 0.0, 5.0), radius: 1.0 };

fn moved(x: f32, y: f32, z: f32) -> Affine {
    Affine { translation: vec3(x, y, z), ..Affine::IDENTITY }
}

fn down(x: f32, y: f32) -> Ray {
    Ray::new(vec3(x, y, 3.0), vec3(0.0, 0.0, -1.0))
}

#[test]
fn weights_belong_to_the_corners_as_given() {
    for turn in 0..3 {
        let mut corners = TRIANGLE;
        corners.rotate_left(turn);
        let scene = Scene::new(&[corners], &[]).unwrap();
        let hit = Exhaustive::new(&scene.geometry())
            .tracer(IgnoreWork)
            .closest_hit(&down(0.75, 0.5), &RayFilter::ALL);
        let w = scene.weights(&hit);
        let point = corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
        assert!((point - vec3(0.75, 0.5, 0.0)).length() < 1e-6, "{turn}: {w:?}");
        assert_eq!(scene.corners(hit.id), Some(corners));
    }
}

#[test]
fn primitives_and_instances_are_numbered_as_given() {
    let mut scene = Scene::new(&[TRIANGLE], &[BALL]).unwrap();
    let mesh = scene.mesh(&[TRIANGLE, TRIANGLE], &[BALL]).unwrap();
    assert_eq!(
        [scene.place(mesh, moved(10.0, 0.0, 0.0)), scene.place(mesh, moved(20.0, 0.0, 0.0))],
        [Ok(1), Ok(2)]
    );
    let bvh = Bvh::build(&scene.geometry(), &BuildOptions::default());
    let tracer = bvh.tracer(IgnoreWork);
    let id = |ray: Ray| tracer.closest_hit(&ray, &RayFilter::ALL).id;
    let up = |x: f32| Ray::new(vec3(x, 0.0, 3.0), vec3(0.0, 0.0, 1.0));
    assert_eq!(id(down(0.5, 0.5)), PrimitiveId { instance: 0, primitive: 0 });
    // Of two in one place the lower number is met.
    assert_eq!(id(down(20.5, 0.5)), PrimitiveId { instance: 2, primitive: 0 });
    assert_eq!(id(up(0.0)), PrimitiveId { instance: 0, primitive: 1 });
    assert_eq!(id(up(10.0)), PrimitiveId { instance: 1, primitive: 2 });
    assert_eq!(scene.corners(PrimitiveId { instance: 1, primitive: 2 }), None);
    assert_eq!(scene.corners(Hit::miss(1.0).id), None);
}

#[test]
fn a_refitted_hierarchy_gives_the_hits_of_a_new_one() {
    let mut scene = Scene::default();
    let mesh = scene.mesh(&[TRIANGLE], &[BALL]).unwrap();
    for k in 0..20 {
        scene.place(mesh, moved(4.0 * k as f32, 0.0, 0.0)).unwrap();
    }
    let mut bvh = Bvh8::build(&scene.geometry(), &BuildOptions::default());
    scene.replace(7, moved(-40.0, 2.0, -1.0)).unwrap();
    let larger = TRIANGLE.map(|p| p * 1.5);
    scene.reshape(mesh, &[larger], &[BALL]).unwrap();
    bvh.refit(&scene.geometry()).unwrap();
    let new = Exhaustive::new(&scene.geometry());
    let mut hits = 0;
    for k in 0..300 {
        let ray = down(0.37 * k as f32 - 45.0, 0.02 * k as f32 % 3.0);
        let hit = bvh.tracer().closest_hit(&ray, &RayFilter::ALL);
        assert_eq!(hit, new.tracer(IgnoreWork).closest_hit(&ray, &RayFilter::ALL), "{ray:?}");
        hits += !hit.is_miss() as u32;
    }
    assert!(hits > 30, "{hits}");
}

#[test]
fn boxes_hold_what_is_placed() {
    let mut scene = Scene::default();
    let mesh = scene.mesh(&[TRIANGLE], &[]).unwrap();
    scene.place(mesh, moved(5.0, 0.0, 0.0)).unwrap();
    let geometry = scene.geometry();
    assert_eq!((geometry.geometries()[1].extent, geometry.geometries()[0].extent), (3.0, 0.0));
    let exact = Bounds { min: vec3(5.0, 0.0, 0.0), max: vec3(8.0, 1.0, 0.0) };
    let bounds = geometry.instances()[1].world_bounds;
    let margins = [exact.min - bounds.min, bounds.max - exact.max];
    // By 2^-20 of what both maps make of absolute numbers.
    assert!(margins.iter().all(|m| m.min_component() >= 0.0 && m.max_component() < 40.0 / 1_048_576.0));
    assert!(margins[1].x > 8.0 / 1_048_576.0, "{bounds:?}");
}

#[test]
fn what_cannot_be_is_refused() {
    let with = |p: Vec3| Scene::new(&[TRIANGLE, [p, TRIANGLE[1], TRIANGLE[2]]], &[]).err();
    for bad in [f32::NAN, f32::INFINITY, 2e12] {
        assert_eq!(with(vec3(0.0, bad, 0.0)), Some(SceneError::Triangle(1)));
    }
    for radius in [0.0, -1.0, f32::NAN, 2e12] {
        assert_eq!(Scene::new(&[], &[Sphere { radius, ..BALL }]).err(), Some(SceneError::Sphere(0)));
    }
    assert_eq!(indexed(&TRIANGLE, &[[0, 1, 2], [0, 1, 3]]), Err(SceneError::Face(1)));
    assert_eq!(indexed(&TRIANGLE, &[[0, 1, 2]]), Ok(vec![TRIANGLE]));

    let mut scene = Scene::default();
    let mesh = scene.mesh(&[TRIANGLE], &[]).unwrap();
    let flat = Affine { columns: [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), Vec3::ZERO], ..Affine::IDENTITY };
    for map in [flat, moved(f32::NAN, 0.0, 0.0), moved(2e12, 0.0, 0.0)] {
        assert_eq!(scene.place(mesh, map), Err(SceneError::Transform), "{map:?}");
    }
    let one = scene.place(mesh, moved(9e11, 0.0, 0.0)).unwrap();
    assert_eq!(scene.replace(0, Affine::IDENTITY), Err(SceneError::Instance(0)));
    assert_eq!(scene.replace(one + 1, Affine::IDENTITY), Err(SceneError::Instance(2)));
    assert_eq!(scene.replace(one, flat), Err(SceneError::Transform));
    assert_eq!(scene.reshape(mesh, &[], &[]), Err(SceneError::Counts));
    assert_eq!(scene.reshape(mesh, &[TRIANGLE.map(|p| p * 1e11)], &[]), Err(SceneError::Transform));
    assert!(scene.clone().reshape(Scene::WORLD, &[], &[]).is_ok());
    let mut other = Scene::default();
    assert_eq!(other.place(mesh, Affine::IDENTITY), Err(SceneError::Mesh(mesh)));
    assert!(format!("{}", SceneError::Mesh(mesh)).contains("no mesh 1"));
    let _: MeshId = mesh;
}

#[test]
fn normals_are_of_unit_length_in_world_space() {
    let flat = [vec3(0.0, 0.0, 0.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0)];
    let ball = Sphere { center: vec3(5.0, 0.0, 0.0), radius: 1.0 };
    let mut scene = Scene::default();
    let mesh = scene.mesh(&[flat], &[ball]).unwrap();
    // Sheared along x by z, and stretched: normals lean the other way.
    let columns = [vec3(1.0, 0.0, 0.0), vec3(0.0, 3.0, 0.0), vec3(1.0, 0.0, 1.0)];
    let sheared = scene.place(mesh, Affine { columns, translation: vec3(0.0, 10.0, 0.0) }).unwrap();
    let large = Affine {
        columns: [vec3(1e6, 0.0, 0.0), vec3(0.0, 1e6, 0.0), vec3(0.0, 0.0, 1e6)],
        ..Affine::IDENTITY
    };
    let scaled = scene.place(mesh, large).unwrap();
    let bvh = Bvh8::build(&scene.geometry(), &BuildOptions::default());
    let normal = |origin: Vec3, direction: Vec3| {
        let ray = Ray::new(origin, direction);
        let hit = bvh.closest_hit(&ray).unwrap();
        (hit.id.instance, scene.normal(&ray, &hit).unwrap())
    };
    let down = vec3(0.0, 0.0, -1.0);
    assert_eq!(normal(vec3(0.5, 11.0, 4.0), down), (sheared, vec3(0.0, 0.0, 1.0)));
    assert_eq!(normal(vec3(0.25e6, 0.5e6, 4e6), down), (scaled, vec3(0.0, 0.0, 1.0)));
    // The ball is (x - z - 5)^2 + ((y - 10) / 3)^2 + z^2 = 1 there: met from its right, where the gradient is (1, 0, -1).
    let (instance, leaning) = normal(vec3(20.0, 10.0, 0.0), vec3(-1.0, 0.0, 0.0));
    let half = 0.5f32.sqrt();
    assert!(instance == sheared && (leaning - vec3(half, 0.0, -half)).length() < 1e-6, "{leaning:?}");
    let miss = Hit::miss(1.0);
    assert_eq!(scene.normal(&Ray::new(Vec3::ZERO, down), &miss), None);
}

#[test]
fn instances_have_masks() {
    let mut scene = Scene::new(&[TRIANGLE], &[BALL]).unwrap();
    let mesh = scene.mesh(&[TRIANGLE], &[]).unwrap();
    let above = scene.place(mesh, moved(0.0, 0.0, 1.0)).unwrap();
    assert_eq!(scene.masks(), [u32::MAX; 2]);
    scene.set_mask(0, 0b01).unwrap();
    scene.set_mask(above, 0b110).unwrap();
    assert_eq!(scene.set_mask(above + 1, 1), Err(SceneError::Instance(above + 1)));
    assert_eq!(scene.masks(), [0b01, 0b110]);

    let bvh = Bvh8::build(&scene.geometry(), &BuildOptions::default());
    let ray = down(0.5, 0.25);
    let masked = |mask| bvh.tracer().with_masks(scene.masks(), mask);
    let instance = |mask| masked(mask).closest_hit(&ray, &RayFilter::ALL).id.instance;
    assert_eq!([instance(0b111), instance(0b010), instance(0b001)], [above, above, 0]);
    assert!(masked(0b1000).closest_hit(&ray, &RayFilter::ALL).is_miss());
    assert!(masked(0b100).occluded(&ray, &RayFilter::ALL) && !masked(0).occluded(&ray, &RayFilter::ALL));
}

#[test]
#[should_panic = "1 masks for 2 instances"]
fn there_is_a_mask_for_each_instance() {
    let mut scene = Scene::new(&[TRIANGLE], &[]).unwrap();
    let mesh = scene.mesh(&[TRIANGLE], &[]).unwrap();
    scene.place(mesh, moved(0.0, 0.0, 1.0)).unwrap();
    Bvh8::build(&scene.geometry(), &BuildOptions::default()).tracer().with_masks(&[1], 1);
}

#[test]
fn a_closure_sees_what_is_behind_what_it_refuses() {
    // Ten in one place, at one `t`.
    let bvh = Bvh8::from_mesh(&TRIANGLE.map(|v| [v.x, v.y, v.z]), &[[0, 1, 2]; 10]).unwrap();
    let ray = down(0.5, 0.25);
    let mut seen = Vec::new();
    assert_eq!(
        bvh.closest_hit_where(&ray, |hit| (hit.id.primitive > 6, seen.push(hit.id.primitive)).0)
            .unwrap()
            .id
            .primitive,
        7
    );
    assert!((0..=7).all(|k| seen.contains(&k)), "{seen:?}");
    assert_eq!(bvh.closest_hit_where(&ray, |_| true), bvh.closest_hit(&ray));
    assert!(bvh.occluded_where(&ray, |hit| hit.id.primitive == 9) && !bvh.occluded_where(&ray, |_| false));
}
