//! Kernels that answer queries about rays, without a picture: for benchmarks, and for programs that trace rays of their
//! own.

use crate::parameters::{array, indexed};
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x};
use eosphor_core::geometry::{Geometry, Instance, Sphere};
use eosphor_core::hierarchy::{BvhNode, BvhTracer, BvhView, IgnoreWork, PrimitivesView, Tracer};
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::ray::{Hit, Ray, RayFilter};

/// Defines a kernel that answers a query for each ray. After the hierarchy come the rays, their number and the answers.
macro_rules! ray_kernel {
    ($(#[$doc:meta])* $name:ident: $answer:ty, |$count:ident| $instances:expr, |$tracer:ident, $ray:ident| $query:expr) => {
        $(#[$doc])*
        ///
        /// # Safety
        ///
        /// References are to the first items of a hierarchy's arrays, which are as long as their indices say; there are
        /// `count` rays, and there is room for as many answers.
        #[unsafe(no_mangle)]
        pub unsafe extern "ptx-kernel" fn $name(
            nodes: &BvhNode,
            roots: &u32,
            instance_order: &u32,
            instance_root: u32,
            packed_triangles: &PackedTriangle,
            packed_spheres: &Sphere,
            sphere_primitives: &u32,
            geometries: &Geometry,
            instances: &Instance,
            $count: u64,
            rays: &Ray,
            count: u32,
            answers: *mut $answer,
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
                    instances: array(instances, $instances),
                };
                let $tracer = BvhTracer {
                    bvh: BvhView {
                        nodes: indexed(nodes),
                        roots: indexed(roots),
                        instance_root,
                        instance_order: indexed(instance_order),
                        primitives,
                    },
                    work: IgnoreWork,
                };
                let $ray = indexed(rays).get_unchecked(number as usize);
                *answers.add(number as usize) = $query;
            }
        }
    };
}

ray_kernel! {
    /// Finds closest hits.
    closest_hits_bvh: Hit, |instance_count| instance_count, |tracer, ray| tracer.closest_hit(ray, &RayFilter::ALL)
}

ray_kernel! {
    /// Finds out whether anything is in the way: 1 or 0.
    occluded_bvh: u32, |instance_count| instance_count, |tracer, ray| tracer.occluded(ray, &RayFilter::ALL) as u32
}

// Without the walk over instances there are registers for a third more threads.

ray_kernel! {
    /// The same where there is no instance but the world.
    closest_hits_world: Hit, |_instance_count| 1, |tracer, ray| tracer.closest_hit(ray, &RayFilter::ALL)
}

ray_kernel! {
    /// The same where there is no instance but the world.
    occluded_world: u32, |_instance_count| 1, |tracer, ray| tracer.occluded(ray, &RayFilter::ALL) as u32
}
