//! Arrays whose numbers do not hold together.

use crate::message_of;
use eosphor_accel::{
    Affine, BatchTracer, Bounds, BuildOptions, Bvh8, Coherence, Filters, Geometry, GeometryError, Hit,
    Instance, PrimitiveId, Ray, RayFilter, Scene, SceneGeometry, Sphere, Vec3, vec3,
};

const NO_MATERIAL: u32 = u32::MAX;

fn geometry([first_triangle, triangle_count, first_sphere, sphere_count]: [u32; 4]) -> Geometry {
    Geometry {
        first_triangle,
        triangle_count,
        first_sphere,
        sphere_count,
        extent: 1.0,
        first_sphere_object: 0,
    }
}

fn instance(geometry: u32) -> Instance {
    Instance {
        object_from_world: Affine::IDENTITY,
        world_from_object: Affine::IDENTITY,
        world_bounds: Bounds { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) },
        geometry,
        material: NO_MATERIAL,
        object: 0,
    }
}

const TRIANGLE: [Vec3; 3] = [vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)];
const BALL: Sphere = Sphere { center: Vec3::ZERO, radius: 1.0 };

#[test]
fn ranges_that_leave_gaps_overlap_or_go_beyond_are_refused() {
    let (triangles, spheres) = ([TRIANGLE; 4], [BALL; 2]);
    let world = [instance(0)];
    let error =
        |geometries: &[Geometry]| SceneGeometry::new(&triangles, &spheres, geometries, &world).unwrap_err();
    for (ranges, number) in [
        (vec![[1, 3, 0, 2]], 0),
        (vec![[0, 5, 0, 2]], 0),
        (vec![[0, 4, 0, 3]], 0),
        (vec![[0, 2, 0, 1], [3, 1, 1, 1]], 1),
        (vec![[0, 2, 0, 1], [1, 3, 1, 1]], 1),
        (vec![[0, 2, 0, 1], [2, 2, 0, 2]], 1),
        (vec![[0, 4, 0, 2], [4, u32::MAX, 2, u32::MAX]], 1),
        (vec![[0, u32::MAX, 0, 0], [u32::MAX, u32::MAX, 0, 0]], 0),
    ] {
        let geometries: Vec<Geometry> = ranges.into_iter().map(geometry).collect();
        assert_eq!(error(&geometries), GeometryError::Range { geometry: number });
    }
    assert_eq!(error(&[geometry([0, 3, 0, 2])]), GeometryError::LeftOver);
    assert_eq!(error(&[]), GeometryError::NoWorld);
}

#[test]
fn instances_of_geometries_that_are_not_there_are_refused() {
    let geometries = [geometry([0, 1, 0, 0]), geometry([1, 0, 0, 0])];
    let error =
        |instances: &[Instance]| SceneGeometry::new(&[TRIANGLE], &[], &geometries, instances).unwrap_err();
    assert_eq!(error(&[instance(0), instance(2)]), GeometryError::Instance { number: 1 });
    assert_eq!(error(&[instance(0), instance(1), instance(u32::MAX)]), GeometryError::Instance { number: 2 });
    assert_eq!(error(&[instance(1)]), GeometryError::Instance { number: 0 });
    assert_eq!(error(&[]), GeometryError::NoWorld);
}

#[test]
fn batches_of_unequal_lengths_panic() {
    let scene = Scene::new(&[TRIANGLE; 40], &[]).unwrap();
    let bvh = Bvh8::build(&scene.geometry(), &BuildOptions::default());
    let tracer = bvh.tracer();
    let rays = [Ray::new(vec3(0.2, 0.2, 3.0), vec3(0.0, 0.0, -1.0)); 64];
    let all = Filters::Shared(&RayFilter::ALL);
    for coherence in [Coherence::Auto, Coherence::Coherent, Coherence::Incoherent] {
        for length in [0, 1, 63, 65] {
            let mut hits = vec![Hit::miss(0.0); length];
            message_of(|| tracer.closest_hits(&rays, all, coherence, &mut hits));
            message_of(|| tracer.next_hits(&rays, all, coherence, &mut hits));
            message_of(|| tracer.occluded_rays(&rays, all, coherence, &mut vec![false; length]));
            let filters = vec![RayFilter::ALL; length];
            let mut hits = vec![Hit::miss(0.0); rays.len()];
            message_of(|| tracer.closest_hits(&rays, Filters::Each(&filters), coherence, &mut hits));
        }
        tracer.closest_hits(&[], Filters::Each(&[]), coherence, &mut []);
    }
}

#[test]
fn hits_of_nothing_have_weights_and_no_corners() {
    let scene = Scene::new(&[TRIANGLE], &[BALL]).unwrap();
    for id in [(0, 1), (0, 2), (0, u32::MAX), (1, 0), (u32::MAX, 0)] {
        let id = PrimitiveId { instance: id.0, primitive: id.1 };
        assert_eq!(scene.corners(id), None);
        scene.weights(&Hit { t: 1.0, t_rest: 0.0, u: f32::NAN, v: 0.0, id });
    }
}

#[test]
fn lanes_that_blocks_do_not_have_panic() {
    let mut block = eosphor_accel::bvh8::TriangleBlock::EMPTY;
    let triangle = block.get(0);
    for lane in [4, 5, usize::MAX] {
        assert!(message_of(|| block.get(lane)).contains("out of bounds"));
        assert!(message_of(|| block.set(lane, &triangle)).contains("out of bounds"));
    }
}
