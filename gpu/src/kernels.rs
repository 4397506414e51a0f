//! The entry points: each renders a band of rows over one structure.

use crate::band::render_band;
use crate::parameters::{array, indexed, instance_tree};
use crate::watch::{Counting, Unwatched, Watching};
use eosphor_core::device::{
    BandLaunch, BvhPair, Link, PairTracer, PairView, Root, WarpMode, WideNode, WideTracer, WideView,
};
use eosphor_core::geometry::Sphere;
use eosphor_core::hierarchy::{
    BvhNode, BvhTracer, BvhView, ExhaustiveTracer, GridRoot, GridTracer, GridView, KdNode, KdRoot,
    KdTreeTracer, KdTreeView, OctreeNode, OctreeParametricTracer, OctreeRoot, OctreeTracer, OctreeView,
    PrimitivesView,
};
use eosphor_core::integrator::{Path, Whitted};
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::scene_arrays;
use eosphor_core::view::SceneView;

/// What a parameter is to the kernel.
macro_rules! reached {
    (one $first:ident, $count:expr) => {
        $first
    };
    (indexed $first:ident, $count:expr) => {
        indexed($first)
    };
    (counted $first:ident, $count:expr) => {
        array($first, $count)
    };
}

/// Defines a kernel that renders a band of rows. It takes the own parameters of the structure (`crates/cuda/src/structure.rs`),
/// the structure's primitives, the scene's arrays and the launch, in this order.
macro_rules! render_kernel {
    ($($kernel:tt)*) => {
        scene_arrays! { define_render_kernel($($kernel)*) }
    };
}

macro_rules! define_render_kernel {
    (
        ($(#[$doc:meta])* $name:ident, $integrator:ty, $watching:ty, ($($own:ident: $type:ty),*) |$primitives:ident, $work:ident| $tracer:expr)
        $($(#[$field_doc:meta])* $array:ident $label:literal $field:ident: $access:ident $item:ty,)*
    ) => {
        $(#[$doc])*
        ///
        /// # Safety
        ///
        /// References are to the first items of arrays, which are as long as the scene's indices and `launch.counts` say; the
        /// launch's `sums`, or where they are null its `film`, have room for the pixels of its rows; its `sharing` is at most 5.
        #[unsafe(no_mangle)]
        pub unsafe extern "ptx-kernel" fn $name(
            $($own: $type,)*
            packed_triangles: &PackedTriangle,
            packed_spheres: &Sphere,
            sphere_primitives: &u32,
            $($field: &$item,)*
            launch: BandLaunch,
        ) {
            // SAFETY: uploaded arrays: the references are first items of arrays that hold every index of the scene.
            unsafe {
                let view = SceneView { $($field: reached!($access $field, launch.counts.$field)),* };
                let $primitives = PrimitivesView {
                    triangles: indexed(packed_triangles),
                    spheres: indexed(packed_spheres),
                    sphere_primitives: indexed(sphere_primitives),
                    geometries: view.geometries,
                    instances: array(view.instances.get_unchecked(0), launch.counts.instances),
                };
                let watching = <$watching>::new();
                let $work = watching.work();
                let tracer = watching.around($tracer);
                render_band::<_, $integrator>(&view, &tracer, &launch, &watching);
            }
        }
    };
}

/// Defines two kernels over a structure: one for each integrator.
macro_rules! render_kernels {
    (
        $(#[$doc:meta])*
        $whitted:ident, $path:ident, $watching:ty, ($($own:ident: $type:ty),*) |$primitives:ident, $work:ident| $tracer:expr
    ) => {
        render_kernel! { $(#[$doc])* $whitted, Whitted<1>, $watching, ($($own: $type),*) |$primitives, $work| $tracer }
        render_kernel! { $(#[$doc])* $path, Path, $watching, ($($own: $type),*) |$primitives, $work| $tracer }
    };
}

/// Defines four kernels over a structure: for each integrator one that renders, and one that also counts and times what queries do.
macro_rules! render_and_count_kernels {
    (
        $(#[$doc:meta])*
        $whitted:ident, $path:ident, $count:ident, $count_path:ident,
        ($($own:ident: $type:ty),*) |$primitives:ident, $work:ident| $tracer:expr
    ) => {
        render_kernels! { $(#[$doc])* $whitted, $path, Unwatched, ($($own: $type),*) |$primitives, $work| $tracer }
        render_kernels! { $(#[$doc])* $count, $count_path, Counting, ($($own: $type),*) |$primitives, $work| $tracer }
    };
}

render_and_count_kernels! {
    /// Without any structure: the reference.
    render_exhaustive, path_exhaustive, count_exhaustive, count_path_exhaustive, () |primitives, work| ExhaustiveTracer::new(primitives, work)
}

/// Defines kernels over a bounding volume hierarchy.
macro_rules! bvh_kernel {
    ($(#[$doc:meta])* $whitted:ident, $path:ident, placed $placed:literal, in step $in_step:literal) => {
        render_kernels! {
            $(#[$doc])*
            $whitted, $path, Unwatched, (
                pairs: &BvhPair,
                roots: &Root<Link>,
                instance_root: Link,
                warp_mode: WarpMode
            ) |primitives, _work| PairTracer::<$placed, $in_step>::new(PairView {
                    pairs: indexed(pairs),
                    roots: indexed(roots),
                    instance_root,
                    warp_mode,
                    primitives,
                })
        }
    };
}

bvh_kernel! {
    /// Over a bounding volume hierarchy.
    render_bvh, path_bvh, placed true, in step false
}

bvh_kernel! {
    /// The same where there is no instance but the world.
    render_bvh_world, path_bvh_world, placed false, in step false
}

bvh_kernel! {
    /// The same with the threads of a warp in step.
    render_bvh_in_step, path_bvh_in_step, placed true, in step true
}

render_kernels! {
    /// Over a hierarchy with eight children a node.
    render_bvh_wide, path_bvh_wide, Unwatched, (
        nodes: &WideNode,
        roots: &Root<u32>,
        instance_root: u32
    ) |primitives, _work| WideTracer::<true>::new(WideView { nodes: indexed(nodes), roots: indexed(roots), instance_root, primitives })
}

render_kernels! {
    /// Over a bounding volume hierarchy as CPUs read it, whose walk counts.
    count_bvh, count_path_bvh, Counting, (
        nodes: &BvhNode,
        roots: &u32,
        instance_nodes: &BvhNode,
        instance_order: &u32,
        instance_root: u32
    ) |primitives, work| BvhTracer::new(BvhView {
            nodes: indexed(nodes),
            roots: indexed(roots),
            instances: instance_tree(instance_nodes, instance_order, instance_root),
            primitives,
        }, work)
}

render_and_count_kernels! {
    /// Over an octree, all octants that a ray meets.
    render_octree, path_octree, count_octree, count_path_octree, (
        nodes: &OctreeNode,
        roots: &OctreeRoot,
        references: &u32,
        instance_nodes: &BvhNode,
        instance_order: &u32,
        instance_root: u32
    ) |primitives, work| OctreeTracer::new(OctreeView {
            nodes: indexed(nodes),
            roots: indexed(roots),
            references: indexed(references),
            instances: instance_tree(instance_nodes, instance_order, instance_root),
            primitives,
        }, work)
}

render_and_count_kernels! {
    /// Over an octree, octants in the order of the ray.
    render_octree_parametric, path_octree_parametric, count_octree_parametric, count_path_octree_parametric, (
        nodes: &OctreeNode,
        roots: &OctreeRoot,
        references: &u32,
        instance_nodes: &BvhNode,
        instance_order: &u32,
        instance_root: u32
    ) |primitives, work| OctreeParametricTracer::new(OctreeView {
            nodes: indexed(nodes),
            roots: indexed(roots),
            references: indexed(references),
            instances: instance_tree(instance_nodes, instance_order, instance_root),
            primitives,
        }, work)
}

render_and_count_kernels! {
    /// Over a uniform grid.
    render_grid, path_grid, count_grid, count_path_grid, (
        starts: &u32,
        roots: &GridRoot,
        references: &u32,
        instance_nodes: &BvhNode,
        instance_order: &u32,
        instance_root: u32
    ) |primitives, work| GridTracer::new(GridView {
            roots: indexed(roots),
            starts: indexed(starts),
            references: indexed(references),
            instances: instance_tree(instance_nodes, instance_order, instance_root),
            primitives,
        }, work)
}

render_and_count_kernels! {
    /// Over a kd-tree.
    render_kdtree, path_kdtree, count_kdtree, count_path_kdtree, (
        nodes: &KdNode,
        roots: &KdRoot,
        references: &u32,
        instance_nodes: &BvhNode,
        instance_order: &u32,
        instance_root: u32
    ) |primitives, work| KdTreeTracer::new(KdTreeView {
            nodes: indexed(nodes),
            roots: indexed(roots),
            references: indexed(references),
            instances: instance_tree(instance_nodes, instance_order, instance_root),
            primitives,
        }, work)
}
