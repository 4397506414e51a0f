//! Kernels that answer queries about rays, without a picture: for benchmarks, and for programs that trace rays of their
//! own.

use crate::parameters::{array, indexed};
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x};
use eosphor_core::geometry::{Geometry, Instance, Sphere};
use eosphor_core::hierarchy::{BvhPair, Company, Link, PairTracer, PairView, PrimitivesView, Tracer};
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::ray::{Hit, Ray, RayFilter};

/// Defines a kernel that answers a query for each ray. After the hierarchy come the rays, their number and the answers.
macro_rules! ray_kernel {
    ($(#[$doc:meta])* $name:ident: $answer:ty, placed $placed:literal, |$tracer:ident, $ray:ident, $hit_instance:ident| $query:expr) => {
        $(#[$doc])*
        ///
        /// # Safety
        ///
        /// References are to the first items of a hierarchy's arrays, which are as long as their indices say; there are
        /// `count` rays, and there is room for as many answers.
        #[unsafe(no_mangle)]
        pub unsafe extern "ptx-kernel" fn $name(
            pairs: &BvhPair,
            roots: &Link,
            instance_root: Link,
            world_extent: f32,
            company: Company,
            packed_triangles: &PackedTriangle,
            packed_spheres: &Sphere,
            sphere_primitives: &u32,
            geometries: &Geometry,
            instances: &Instance,
            instance_count: u64,
            rays: &Ray,
            count: u32,
            answers: *mut $answer,
            hit_instances: *mut u32,
        ) {
            // SAFETY: these read the thread's numbers; the rest is the kernel's own contract.
            unsafe {
                let number = (_block_idx_x() as u32) * (_block_dim_x() as u32) + _thread_idx_x() as u32;
                if number >= count {
                    return;
                }
                let primitives = PrimitivesView {
                    triangles: indexed(packed_triangles),
                    spheres: indexed(packed_spheres),
                    sphere_primitives: indexed(sphere_primitives),
                    geometries: indexed(geometries),
                    instances: array(instances, if $placed { instance_count } else { 1 }),
                };
                let $tracer = PairTracer::<$placed> {
                    view: PairView {
                        pairs: indexed(pairs),
                        roots: indexed(roots),
                        instance_root,
                        world_extent,
                        company,
                        primitives,
                    },
                };
                let $ray = indexed(rays).get_unchecked(number as usize);
                let $hit_instance = hit_instances.add(number as usize);
                *answers.add(number as usize) = $query;
            }
        }
    };
}

/// A hit as kernels write it: 16 bytes at once. The instance, where there are any, goes to an array of its own.
#[repr(C, align(16))]
pub struct HitRow {
    t: f32,
    u: f32,
    v: f32,
    primitive: u32,
}

impl HitRow {
    #[inline(always)]
    fn new(hit: Hit) -> HitRow {
        HitRow { t: hit.t, u: hit.u, v: hit.v, primitive: hit.id.primitive }
    }
}

ray_kernel! {
    /// Finds closest hits.
    closest_hits_bvh: HitRow, placed true, |tracer, ray, hit_instance| {
        let hit = tracer.closest_hit(ray, &RayFilter::ALL);
        *hit_instance = hit.id.instance;
        HitRow::new(hit)
    }
}

ray_kernel! {
    /// Finds out whether anything is in the way: 1 or 0.
    occluded_bvh: u32, placed true, |tracer, ray, _hit_instance| tracer.occluded(ray, &RayFilter::ALL) as u32
}

// Without the walk over instances there are registers for more threads.

ray_kernel! {
    /// The same where there is no instance but the world.
    closest_hits_world: HitRow, placed false, |tracer, ray, _hit_instance| {
        HitRow::new(tracer.closest_hit(ray, &RayFilter::ALL))
    }
}

ray_kernel! {
    /// The same where there is no instance but the world.
    occluded_world: u32, placed false, |tracer, ray, _hit_instance| tracer.occluded(ray, &RayFilter::ALL) as u32
}
