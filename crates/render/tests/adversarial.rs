//! Programs without `unsafe` that mean harm, with scenes and tracers of their own: they get an error, a panic with a message or a
//! picture. `cargo xtask asan` runs them under AddressSanitizer.
#![forbid(unsafe_code)]

use eosphor_core::hierarchy::{ExhaustiveTracer, IgnoreWork, Tracer};
use eosphor_core::integrator::{RayCounts, render_pixel};
use eosphor_core::integrator::{pixel_features, transmittance};
use eosphor_core::math::Vec3;
use eosphor_core::ray::{Hit, PrimitiveId, Ray, RayFilter};
use eosphor_core::shading::{EvaluatedMaterial, SurfacePoint};
use eosphor_render::{Accel, Backend, CpuBackend, CpuOptions, Hierarchy, HierarchyOptions, build_hierarchy};
use eosphor_scene::{LoadOptions, SceneData, load};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

fn glass() -> SceneData {
    let mut scene = load("builtin:glass", &LoadOptions::default()).unwrap().scene;
    scene.settings.size = [8, 6];
    SceneData::flatten(&scene).unwrap().0
}

fn panics<R>(program: impl FnOnce() -> R) -> bool {
    catch_unwind(AssertUnwindSafe(program)).is_err()
}

/// Says what it likes, whatever there is.
struct Liar(Hit);

impl Tracer for Liar {
    fn closest_hit(&self, _: &Ray, _: &RayFilter) -> Hit {
        self.0
    }
    fn occluded(&self, _: &Ray, _: &RayFilter) -> bool {
        false
    }
    fn next_hit(&self, _: &Ray, _: &RayFilter, _: &Hit) -> Hit {
        Hit::miss(0.0)
    }
}

fn hit(instance: u32, primitive: u32) -> Hit {
    Hit { t: 1.0, t_rest: 0.0, u: 0.25, v: 0.25, id: PrimitiveId { instance, primitive } }
}

#[test]
fn scenes_that_were_changed_after_flattening_are_refused_by_backends() {
    let backend = CpuBackend::new(CpuOptions::default()).unwrap();
    let changes: [fn(&mut SceneData); 10] = [
        |data| data.triangles.truncate(data.triangles.len() - 1),
        |data| data.geometries[0].triangle_count += 1,
        |data| data.geometries[0].first_triangle = u32::MAX,
        |data| data.geometries.clear(),
        |data| data.instances.clear(),
        |data| data.instances[0].geometry = 500_000_000,
        |data| data.triangle_shading[0].material = 500_000_000,
        |data| data.triangle_shading[0].extra = 500_000_000,
        |data| data.triangles[0][0].x = f32::NAN,
        |data| data.geometries[0].extent = f32::INFINITY,
    ];
    for (number, change) in changes.into_iter().enumerate() {
        let mut data = glass();
        change(&mut data);
        let refused = backend.prepare(Arc::new(data.clone())).map(|_| ()).unwrap_err().to_string();
        assert!(refused.starts_with("the scene does not hold together: "), "{number}: {refused}");
        // What is wrong with shapes is found by those who build, too.
        let built = build_hierarchy(Accel::Bvh, &HierarchyOptions::default(), &data);
        assert_eq!(built.is_err(), !(6..=7).contains(&number), "{number}");
    }
}

#[test]
fn hits_of_what_is_not_there_panic_where_they_are_shaded() {
    let data = glass();
    let view = data.view();
    let ray = Ray::new(Vec3::ZERO, Vec3::splat(0.577));
    let count = data.geometries[0].triangle_count + data.geometries[0].sphere_count;
    for hit in [hit(0, count), hit(0, u32::MAX - 1), hit(data.instances.len() as u32, 0), hit(u32::MAX, 0)] {
        assert!(panics(|| SurfacePoint::<EvaluatedMaterial>::new(&view, &ray, &hit)), "{hit:?}");
        assert!(panics(|| render_pixel::<_, 4>(&view, &Liar(hit), 0, 0, &mut RayCounts::default())));
        assert!(panics(|| pixel_features(&view, &Liar(hit), 0, 0)));
    }
}

#[test]
fn tracers_that_always_hit_end_at_the_depth_limit() {
    let mut data = glass();
    data.settings.max_depth = u32::MAX;
    for primitive in 0..data.geometries[0].triangle_count + data.geometries[0].sphere_count {
        let mut hit = hit(0, primitive);
        for t in [1e-3, 1.0, f32::NAN, f32::INFINITY] {
            hit.t = t;
            let mut counts = RayCounts::default();
            if data.settings.samples > 1 {
                data.settings.samples = 1;
            }
            render_pixel::<_, 1>(&data.view(), &Liar(hit), 3, 3, &mut counts);
            assert!(counts.camera == 1);
        }
    }
    let ray = Ray::new(Vec3::ZERO, Vec3::splat(0.577));
    transmittance(&data.view(), &Liar(hit(0, 0)), &ray, &RayFilter::ALL);
}

#[test]
fn pixels_that_are_not_in_the_picture_are_pixels() {
    let data = glass();
    let Hierarchy::Exhaustive(all) =
        build_hierarchy(Accel::None, &HierarchyOptions::default(), &data).unwrap()
    else {
        unreachable!("what was asked for")
    };
    let tracer: ExhaustiveTracer<IgnoreWork> = all.tracer(IgnoreWork);
    for (x, y) in [(0, u32::MAX), (u32::MAX, 0), (u32::MAX, u32::MAX)] {
        render_pixel::<_, 4>(&data.view(), &tracer, x, y, &mut RayCounts::default());
    }
}
