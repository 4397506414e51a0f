//! No light gets out of closed bodies: not along rays that start inside, nor along those that start where shading says.

use super::bodies::Bodies;
use super::judge::flatten;
use crate::double::{Double, Shape};
use crate::random::{Random, rays};
use crate::shapes::{Closed, cube, icosphere, torus};
use crate::vector::*;
use eosphor_accel::{BuildOptions, Bvh, Bvh8, SceneGeometry};
use eosphor_core::hierarchy::{IgnoreWork, Tracer};
use eosphor_core::math::Vec3;
use eosphor_core::ray::{PrimitiveId, Ray, RayFilter};
use eosphor_core::shading::SurfacePoint;
use eosphor_scene::SceneData;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Above a surface: mostly near its normal, often close to the surface itself.
fn above(random: &mut Random, normal: V) -> V {
    let d = random.direction();
    let flat = along(d, normal, -dot(d, normal));
    let height = if random.unit() < 0.5 { dot(d, normal).abs() } else { 10f64.powf(-5.0 * random.unit()) };
    unit(along(flat, normal, height))
}

/// A closed body about `inside`, by itself or with something large and far.
struct Room {
    name: String,
    data: SceneData,
    inside: V,
    /// Alone, for double precision.
    body: Double,
}

impl Room {
    fn new(shape: &Closed, size: f64, shift: f64, inside: V, far: bool) -> Room {
        let axes = [[2.0, 3.0, 6.0], [3.0, -6.0, 2.0], [6.0, 2.0, -3.0]].map(|a| scaled(a, 1.0 / 7.0));
        let at = scaled(unit([0.61, -0.52, 0.6]), shift * size);
        let mut bodies = Bodies::turned(size, at, axes);
        let matte = bodies.matte(0.5, 0.5, 0.5);
        bodies.closed(shape, 1.0, [0.0; 3], matte);
        bodies.lamp(inside, 1.0);
        bodies.camera(inside, [0.0, 0.1, 0.0], 60.0);
        let triangles = flatten(&bodies.scene).triangles;
        let body = Double::new(triangles.iter().map(|t| Shape::Triangle(t.map(double))).collect());
        if far {
            bodies.sphere([3e6, -2e6, 1e6], 1e6, matte);
        }
        let name = format!(
            "{} of {size:e}, {shift:e} sizes away{}",
            shape.name,
            if far { ", far ball" } else { "" }
        );
        Room { name, data: flatten(&bodies.scene), inside: double(single(bodies.point(inside))), body }
    }

    /// Paths of `bounces` rays from inside; returns how many rays hit nothing, or what is not the body, and how many
    /// started outside.
    fn escapes(&self, tracer: &(impl Tracer + Sync), paths: u64, bounces: u32) -> [u64; 2] {
        let (escaped, outside) = (AtomicU64::new(0), AtomicU64::new(0));
        let view = self.data.view();
        (0..paths).into_par_iter().for_each(|path| {
            let mut random = Random(path.wrapping_mul(0x2545_f491_4f6c_dd1d));
            let mut ray = Ray::new(single(self.inside), single(random.direction()));
            let mut start = PrimitiveId::NONE;
            for _ in 0..bounces {
                let hit = tracer.closest_hit(&ray, &RayFilter { start, ..RayFilter::ALL });
                let world = self.data.geometries[0].triangle_count;
                if hit.is_miss() || hit.id.instance > 0 || hit.id.primitive >= world {
                    escaped.fetch_add(1, Relaxed);
                    // Whether the ray had been put outside, where all of what follows is right.
                    let (o, d) = (double(ray.origin), double(ray.direction));
                    let gone = self.body.closest(o, d, f64::INFINITY, None).is_none();
                    outside.fetch_add(u64::from(gone), Relaxed);
                    return;
                }
                let point: SurfacePoint = SurfacePoint::new(&view, &ray, &hit);
                let direction: Vec3 = single(above(&mut random, double(point.geometric_normal)));
                ray = Ray::new(point.offset_origin(direction), direction);
                start = hit.id;
            }
        });
        [escaped.into_inner(), outside.into_inner()]
    }
}

#[test]
fn no_ray_gets_out_of_a_closed_body() {
    let shapes =
        [(cube(), [0.1, -0.2, 0.3]), (icosphere(2), [0.1, -0.2, 0.3]), (torus(48, 24), [0.7, 0.05, 0.0])];
    let settings = [
        (1.0, 0.0, false),
        (1e-3, 0.0, false),
        (1e3, 1.0, false),
        (1.0, 1e2, false),
        (1.0, 1e4, false),
        (1.0, 0.0, true),
    ];
    let mut failed = Vec::new();
    let paths = rays(200_000) / 10 / (settings.len() * shapes.len()) as u64 / 2;
    for (shape, inside) in &shapes {
        for (size, shift, far) in settings {
            let room = Room::new(shape, size, shift, *inside, far);
            let geometry = SceneGeometry::new(
                &room.data.triangles,
                &room.data.spheres,
                &room.data.geometries,
                &room.data.instances,
            )
            .expect("arrays that hold together");
            let (bvh, bvh8) = (
                Bvh::build(&geometry, &BuildOptions::default()),
                Bvh8::build(&geometry, &BuildOptions::default()),
            );
            let [a, b] = room.escapes(&bvh.tracer(IgnoreWork), paths, 10);
            let [c, d] = room.escapes(&bvh8.tracer(), paths, 10);
            println!("{}: of {} rays {} get out, {} start outside", room.name, 20 * paths, a + c, b + d);
            if a + c > 0 {
                failed.push(format!("{}: {} of {} get out", room.name, a + c, 20 * paths));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
