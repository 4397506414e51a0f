//! parry3d: the hierarchy of a library for collisions.

use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::{Ray as OwnRay, RayCast};
use parry3d::shape::Triangle as OwnTriangle;
use peer_harness::{Hit, Library, MISS, Options, Quality, Ray, Triangle};

/// `Bvh` over triangles. `TriMesh` is the same, but always builds by `Binned`, and its rays have no nearest distance.
pub struct Mesh {
    hierarchy: Bvh,
    triangles: Vec<OwnTriangle>,
}

impl Mesh {
    #[inline(always)]
    fn distance(&self, triangle: u32, ray: &OwnRay, t_min: f32, t_max: f32) -> Option<f32> {
        self.triangles[triangle as usize].cast_local_ray(ray, t_max, true).filter(|t| *t >= t_min)
    }
}

fn own_ray(ray: &Ray) -> OwnRay {
    OwnRay::new(Vector::from(ray.origin), Vector::from(ray.direction))
}

impl Library for Mesh {
    type Mesh = Vec<OwnTriangle>;

    fn prepare(mesh: &[Triangle], _: &Options) -> Result<Self::Mesh, String> {
        Ok(mesh
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(Vector::from);
                OwnTriangle::new(a, b, c)
            })
            .collect())
    }

    fn build(triangles: Self::Mesh, options: &Options) -> Result<Self, String> {
        let strategy = match options.quality {
            Quality::Low | Quality::Medium => BvhBuildStrategy::Binned,
            // "Best when ray-casting performance is critical", as its documentation says.
            Quality::High => BvhBuildStrategy::Ploc,
        };
        let bounds: Vec<Aabb> = triangles.iter().map(OwnTriangle::local_aabb).collect();
        Ok(Self { hierarchy: Bvh::from_leaves(strategy, &bounds), triangles })
    }

    fn closest_hits(&self, rays: &[Ray], _: bool, hits: &mut [Hit]) {
        for (ray, found) in rays.iter().zip(hits) {
            let own = own_ray(ray);
            let closest = self
                .hierarchy
                .cast_ray(&own, ray.t_max, |triangle, t_max| self.distance(triangle, &own, ray.t_min, t_max));
            *found = match closest {
                Some((triangle, t)) => Hit { t, triangle },
                None => Hit { t: 0.0, triangle: MISS },
            };
        }
    }

    fn any_hits(&self, rays: &[Ray], _: bool, hits: &mut [bool]) {
        for (ray, found) in rays.iter().zip(hits) {
            let own = own_ray(ray);
            // The library has no query for any hit. A hit that counts as the nearest possible ends the search for a
            // closest one: no box is nearer.
            let first = self.hierarchy.cast_ray(&own, ray.t_max, |triangle, _| {
                self.distance(triangle, &own, ray.t_min, ray.t_max).map(|_| f32::NEG_INFINITY)
            });
            *found = first.is_some();
        }
    }
}
