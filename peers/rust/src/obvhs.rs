//! obvhs: a hierarchy of two children a node, and the compressed one of eight.

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::{Ray as OwnRay, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle as OwnTriangle;
use peer_harness::{Hit, Library, MISS, Options, Quality, Ray, Triangle};
use std::time::Duration;

/// `Bvh2`, with its triangles in the order of its leaves, which its documentation recommends.
pub struct Binary {
    hierarchy: Bvh2,
    triangles: Vec<RtTriangle>,
}

/// `CwBvh`, likewise.
pub struct Wide {
    hierarchy: CwBvh,
    triangles: Vec<RtTriangle>,
}

fn parameters(options: &Options) -> BvhBuildParams {
    match options.quality {
        Quality::Low => BvhBuildParams::fast_build(),
        Quality::Medium => BvhBuildParams::medium_build(),
        Quality::High => BvhBuildParams::very_slow_build(),
    }
}

fn own_triangles(mesh: &[Triangle]) -> Vec<OwnTriangle> {
    mesh.iter()
        .map(|corners| {
            let [v0, v1, v2] = corners.map(Vec3A::from);
            OwnTriangle { v0, v1, v2 }
        })
        .collect()
}

fn in_leaf_order(triangles: &[OwnTriangle], indices: &[u32]) -> Vec<RtTriangle> {
    indices.iter().map(|&index| RtTriangle::from(&triangles[index as usize])).collect()
}

fn own_ray(ray: &Ray) -> OwnRay {
    OwnRay::new(ray.origin.into(), ray.direction.into(), ray.t_min, ray.t_max)
}

fn hit(found: bool, hit: &RayHit, indices: &[u32]) -> Hit {
    match found {
        true => Hit { t: hit.t, triangle: indices[hit.primitive_id as usize] },
        false => Hit { t: 0.0, triangle: MISS },
    }
}

/// The two hierarchies have methods of the same names, and no trait for them.
macro_rules! library {
    ($name:ident, $build:ident) => {
        impl Library for $name {
            type Mesh = Vec<OwnTriangle>;

            fn prepare(mesh: &[Triangle], _: &Options) -> Result<Self::Mesh, String> {
                Ok(own_triangles(mesh))
            }

            fn build(mesh: Self::Mesh, options: &Options) -> Result<Self, String> {
                let hierarchy = $build(&mesh, parameters(options), &mut Duration::default());
                let triangles = in_leaf_order(&mesh, &hierarchy.primitive_indices);
                Ok(Self { hierarchy, triangles })
            }

            fn closest_hits(&self, rays: &[Ray], _: bool, hits: &mut [Hit]) {
                for (ray, found) in rays.iter().zip(hits) {
                    let mut closest = RayHit::none();
                    let is_hit = self.hierarchy.ray_traverse(own_ray(ray), &mut closest, |ray, index| {
                        self.triangles[index].intersect(ray)
                    });
                    *found = hit(is_hit, &closest, &self.hierarchy.primitive_indices);
                }
            }

            fn any_hits(&self, rays: &[Ray], _: bool, hits: &mut [bool]) {
                for (ray, found) in rays.iter().zip(hits) {
                    *found = !self
                        .hierarchy
                        .ray_traverse_miss(own_ray(ray), |ray, index| self.triangles[index].intersect(ray));
                }
            }
        }
    };
}

library!(Binary, build_bvh2_from_tris);
library!(Wide, build_cwbvh_from_tris);
