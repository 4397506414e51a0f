//! Kernels that answer queries about rays, without a picture: for benchmarks, and for programs that trace rays of their
//! own.

use crate::parameters::{array, indexed};
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x};
use eosphor_core::device::{
    BvhPair, FarTracer, HitRow, Link, PairTracer, PairView, Root, WarpMode, WideNode, WideTracer, WideView,
};
use eosphor_core::geometry::{Geometry, Instance, Sphere};
use eosphor_core::hierarchy::{PrimitivesView, Tracer};
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::ray::{Ray, RayFilter};

/// Defines a kernel that answers a query for each ray. After the hierarchy's own parameters come its primitives, the rays, their
/// number and the answers.
macro_rules! ray_kernel {
    (
        $(#[$doc:meta])* $name:ident($($own:ident: $type:ty),*) |$primitives:ident, $instances:literal| $tracer:expr,
        $answer:ty, |$asked:ident, $ray:ident, $hit_instance:ident| $query:expr
    ) => {
        $(#[$doc])*
        ///
        /// # Safety
        ///
        /// References are to the first items of a hierarchy's arrays, which are as long as their indices say; there are
        /// `count` rays, and there is room for as many answers.
        #[unsafe(no_mangle)]
        pub unsafe extern "ptx-kernel" fn $name(
            $($own: $type,)*
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
            // SAFETY: these read the thread's numbers; uploaded arrays: the references are first items of arrays that
            // hold every index of the hierarchy, and there are `count` rays and answers.
            unsafe {
                let number = (_block_idx_x() as u32) * (_block_dim_x() as u32) + _thread_idx_x() as u32;
                if number >= count {
                    return;
                }
                let $primitives = PrimitivesView {
                    triangles: indexed(packed_triangles),
                    spheres: indexed(packed_spheres),
                    sphere_primitives: indexed(sphere_primitives),
                    geometries: indexed(geometries),
                    instances: array(instances, if $instances { instance_count } else { 1 }),
                };
                let $asked = $tracer;
                let $ray = indexed(rays).get_unchecked(number as usize);
                let $hit_instance = hit_instances.add(number as usize);
                *answers.add(number as usize) = $query;
            }
        }
    };
}

/// Two kernels over a `bvh`: closest hit, and any hit (1 or 0). Kernels with `placed false` are for a world without
/// instances and need fewer registers.
macro_rules! bvh_ray_kernels {
    ($closest:ident, $occluded:ident, placed $placed:literal, in step $in_step:literal) => {
        ray_kernels! {
            $closest, $occluded, placed $placed,
            (pairs: &BvhPair, roots: &Root<Link>, instance_root: Link, warp_mode: WarpMode)
            |primitives| PairTracer::<$placed, $in_step>::new(PairView {
                    pairs: indexed(pairs),
                    roots: indexed(roots),
                    instance_root,
                    warp_mode,
                    primitives,
                })
        }
    };
}

/// The same for rays of which many start far away: from where they enter the box of the tree.
macro_rules! far_ray_kernels {
    ($closest:ident, $occluded:ident, placed $placed:literal) => {
        ray_kernels! {
            $closest, $occluded, placed $placed,
            (pairs: &BvhPair, roots: &Root<Link>, instance_root: Link, warp_mode: WarpMode)
            |primitives| FarTracer::<$placed>::new(PairView {
                    pairs: indexed(pairs),
                    roots: indexed(roots),
                    instance_root,
                    warp_mode,
                    primitives,
                })
        }
    };
}

/// The same over a hierarchy with eight children a node.
macro_rules! wide_ray_kernels {
    ($closest:ident, $occluded:ident, placed $placed:literal) => {
        ray_kernels! {
            $closest, $occluded, placed $placed,
            (nodes: &WideNode, roots: &Root<u32>, instance_root: u32)
            |primitives| WideTracer::<$placed>::new(WideView {
                    nodes: indexed(nodes),
                    roots: indexed(roots),
                    instance_root,
                    primitives,
                })
        }
    };
}

macro_rules! ray_kernels {
    (
        $closest:ident, $occluded:ident, placed $placed:tt,
        ($($own:ident: $type:ty),*) |$primitives:ident| $tracer:expr
    ) => {
        ray_kernel! {
            /// Finds closest hits.
            $closest($($own: $type),*) |$primitives, $placed| $tracer,
            HitRow, |tracer, ray, hit_instance| {
                let hit = tracer.closest_hit(ray, &RayFilter::ALL);
                if $placed {
                    *hit_instance = hit.id.instance;
                }
                HitRow::from(hit)
            }
        }
        ray_kernel! {
            /// Finds out whether anything is in the way.
            $occluded($($own: $type),*) |$primitives, $placed| $tracer,
            u32, |tracer, ray, _hit_instance| tracer.occluded(ray, &RayFilter::ALL) as u32
        }
    };
}

bvh_ray_kernels! { closest_hits_bvh, occluded_bvh, placed true, in step false }
bvh_ray_kernels! { closest_hits_world, occluded_world, placed false, in step false }
bvh_ray_kernels! { closest_hits_in_step, occluded_in_step, placed true, in step true }
bvh_ray_kernels! { closest_hits_world_in_step, occluded_world_in_step, placed false, in step true }
far_ray_kernels! { closest_hits_far, occluded_far, placed true }
far_ray_kernels! { closest_hits_world_far, occluded_world_far, placed false }
wide_ray_kernels! { closest_hits_wide, occluded_wide, placed true }
wide_ray_kernels! { closest_hits_world_wide, occluded_world_wide, placed false }
