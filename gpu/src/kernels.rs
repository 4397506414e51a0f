//! The entry points: those of queues, of which some trace rays over one structure, and those that render a band of rows in one go.

use crate::band::render_band;
use crate::develop;
use crate::lights;
use crate::parameters::{array, indexed, instance_tree};
use crate::paths;
use crate::trees;
use crate::walk_function::{ByFunction, WalkFunction, walk_function};
use crate::walks;
use crate::watch::{Clock, Counting, Unwatched, Watching};
use eosphor_core::device::{
    BandLaunch, BvhPair, DevelopLaunch, Link, PairTracer, PairView, PathLaunch, Root, WarpMode, WideNode,
    WideTracer, WideView,
};
use eosphor_core::geometry::Sphere;
use eosphor_core::hierarchy::{
    BvhNode, BvhTracer, BvhView, ExhaustiveTracer, GridRoot, GridTracer, GridView, IgnoreWork, KdNode,
    KdRoot, KdTreeTracer, KdTreeView, OctreeNode, OctreeParametricTracer, OctreeRoot, OctreeTracer,
    OctreeView, PrimitivesView, Tracer, Watch,
};
use eosphor_core::integrator::Whitted;
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::ray::{Hit, Ray, RayFilter};
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

/// Defines a kernel over a structure. It takes the own parameters of the structure (`crates/cuda/src/structure.rs`), the
/// structure's primitives, the scene's arrays and the launch, in this order.
macro_rules! structure_kernel {
    ($($kernel:tt)*) => {
        scene_arrays! { define_structure_kernel($($kernel)*) }
    };
}

macro_rules! define_structure_kernel {
    (
        (
            $(#[$doc:meta])* $name:ident, $watching:ty,
            ($($own:ident: $type:ty),*) |$primitives:ident, $work:ident| $tracer:expr,
            |$view:ident, $traced:ident, $launch:ident: $launch_type:ty, $watch:ident| $body:expr
        )
        $($(#[$field_doc:meta])* $array:ident $label:literal $field:ident: $access:ident $item:ty,)*
    ) => {
        $(#[$doc])*
        ///
        /// # Safety
        ///
        /// References are to the first items of arrays, which are as long as the scene's indices and the launch's `counts` say; the
        /// launch is as its type and the function that is called here say.
        #[unsafe(no_mangle)]
        pub unsafe extern "ptx-kernel" fn $name(
            $($own: $type,)*
            packed_triangles: &PackedTriangle,
            packed_spheres: &Sphere,
            sphere_primitives: &u32,
            $($field: &$item,)*
            $launch: $launch_type,
        ) {
            // SAFETY: uploaded arrays: the references are first items of arrays that hold every index of the scene.
            unsafe {
                let $view = SceneView { $($field: reached!($access $field, $launch.counts.$field)),* };
                let $primitives = PrimitivesView {
                    triangles: indexed(packed_triangles),
                    spheres: indexed(packed_spheres),
                    sphere_primitives: indexed(sphere_primitives),
                    geometries: $view.geometries,
                    instances: array($view.instances.get_unchecked(0), $launch.counts.instances),
                };
                let $watch = <$watching>::new();
                let $work = $watch.work();
                let $traced = $watch.around($tracer);
                $body;
            }
        }
    };
}

/// Defines the kernel over a structure that renders a band of rows by Whitted's integrator: all in one.
macro_rules! megakernel {
    (
        $(#[$doc:meta])*
        $whitted:ident, ($($own:ident: $type:ty),*) |$primitives:ident, $work:ident| $tracer:expr
    ) => {
        structure_kernel! {
            $(#[$doc])* $whitted, Unwatched, ($($own: $type),*) |$primitives, $work| $tracer,
            |view, tracer, launch: BandLaunch, watch| render_band::<_, Whitted<1>>(&view, &tracer, &launch, &watch)
        }
    };
}

/// Defines the kernels of queues over a structure: those that find what rays hit, which lights are seen, and what of their light
/// comes through surfaces.
macro_rules! walk_kernels {
    (
        $(#[$doc:meta])*
        $hits:ident, $seen:ident, $crossed:ident, $watching:ident,
        ($($own:ident: $type:ty),*) |$primitives:ident, $work:ident| $tracer:expr
    ) => {
        structure_kernel! {
            $(#[$doc])* $hits, $watching, ($($own: $type),*) |$primitives, $work| $tracer,
            |view, tracer, launch: PathLaunch, watch| walks::find_hits(&view, &tracer, &launch, &watch)
        }
        structure_kernel! {
            $(#[$doc])* $seen, $watching, ($($own: $type),*) |$primitives, $work| $tracer,
            |view, tracer, launch: PathLaunch, watch| walks::see(&view, &tracer, &launch, &watch)
        }
        structure_kernel! {
            $(#[$doc])* $crossed, $watching, ($($own: $type),*) |$primitives, $work| $tracer,
            |view, tracer, launch: PathLaunch, watch| walks::cross(&view, &tracer, &launch, &watch)
        }
    };
}

/// Defines these kernels that also count and time what queries do, whose walk from hit to hit is a function of this name.
macro_rules! counting_kernels {
    (
        $(#[$doc:meta])*
        $walk:ident, $hits:ident, $seen:ident, $crossed:ident, $structure:ident,
        ($($own:ident: $type:ty),*) |$primitives:ident, $work:ident| $tracer:expr
    ) => {
        walk_function! { $walk, $structure<'_, &Watch<Clock>> }
        walk_kernels! {
            $(#[$doc])* $hits, $seen, $crossed, Counting, ($($own: $type),*) |$primitives, $work| ByFunction($tracer)
        }
    };
}

/// Defines both those that do not count and those that do.
macro_rules! walk_and_count_kernels {
    (
        $(#[$doc:meta])*
        $walk:ident, $hits:ident, $seen:ident, $crossed:ident,
        $count_walk:ident, $count_hits:ident, $count_seen:ident, $count_crossed:ident, $structure:ident,
        ($($own:ident: $type:ty),*) |$primitives:ident, $work:ident| $tracer:expr
    ) => {
        walk_function! { $walk, $structure<'_, IgnoreWork> }
        walk_kernels! {
            $(#[$doc])* $hits, $seen, $crossed, Unwatched, ($($own: $type),*) |$primitives, $work| ByFunction($tracer)
        }
        counting_kernels! {
            $(#[$doc])* $count_walk, $count_hits, $count_seen, $count_crossed, $structure,
            ($($own: $type),*) |$primitives, $work| $tracer
        }
    };
}

/// Defines a kernel of path tracing that traces no ray: it takes the scene's arrays and the launch.
macro_rules! path_kernel {
    ($($kernel:tt)*) => {
        scene_arrays! { define_path_kernel($($kernel)*) }
    };
}

macro_rules! define_path_kernel {
    (
        ($(#[$doc:meta])* $name:ident, |$view:ident, $launch:ident| $body:expr)
        $($(#[$field_doc:meta])* $array:ident $label:literal $field:ident: $access:ident $item:ty,)*
    ) => {
        $(#[$doc])*
        ///
        /// # Safety
        ///
        /// As for the kernels over a structure.
        #[unsafe(no_mangle)]
        pub unsafe extern "ptx-kernel" fn $name($($field: &$item,)* $launch: PathLaunch) {
            // SAFETY: uploaded arrays: the references are first items of arrays that hold every index of the scene.
            unsafe {
                let $view = SceneView { $($field: reached!($access $field, $launch.counts.$field)),* };
                $body;
            }
        }
    };
}

/// Makes bytes of the colours of a band.
///
/// # Safety
///
/// As for `develop::develop`.
#[unsafe(no_mangle)]
pub unsafe extern "ptx-kernel" fn develop_film(launch: DevelopLaunch) {
    // SAFETY: the launch is as its type says.
    unsafe { develop::develop(&launch) }
}

/// Begins a round of paths: one thread.
///
/// # Safety
///
/// As for `paths::begin`.
#[unsafe(no_mangle)]
pub unsafe extern "ptx-kernel" fn paths_begin(launch: PathLaunch) {
    // SAFETY: the launch is as its type says.
    unsafe { paths::begin(&launch) }
}

path_kernel! {
    /// Paths from the camera.
    paths_generate, |view, launch| paths::generate(&view, &launch)
}

path_kernel! {
    /// What paths do that leave the scene or have met what is matte.
    paths_shade_matte, |view, launch| paths::shade::<true>(&view, &launch)
}

path_kernel! {
    /// What the others do where they have met something.
    paths_shade, |view, launch| paths::shade::<false>(&view, &launch)
}

path_kernel! {
    /// What the samples of a pass make of the pixels.
    paths_settle, |view, launch| paths::settle(&view, &launch)
}

/// Makes the ring of free slots of trees.
///
/// # Safety
///
/// As for `trees::prepare`.
#[unsafe(no_mangle)]
pub unsafe extern "ptx-kernel" fn trees_prepare(launch: PathLaunch) {
    // SAFETY: the launch is as its type says.
    unsafe { trees::prepare(&launch) }
}

/// Begins a round of trees: one thread.
///
/// # Safety
///
/// As for `trees::begin`.
#[unsafe(no_mangle)]
pub unsafe extern "ptx-kernel" fn trees_begin(launch: PathLaunch) {
    // SAFETY: the launch is as its type says.
    unsafe { trees::begin(&launch) }
}

path_kernel! {
    /// Trees with rays from the camera.
    trees_generate, |view, launch| trees::generate(&view, &launch)
}

path_kernel! {
    /// What their rays do that end, in the scene or beyond it.
    trees_shade_ends, |view, launch| trees::shade_ends(&view, &launch)
}

path_kernel! {
    /// What the others do where they have met something.
    trees_shade, |view, launch| trees::shade(&view, &launch)
}

path_kernel! {
    /// Shadow rays of points that were met.
    trees_ask, |view, launch| lights::ask(&view, &launch)
}

path_kernel! {
    /// What lights give to these points.
    trees_sum, |view, launch| lights::sum(&view, &launch)
}

walk_and_count_kernels! {
    /// Without any structure: the reference.
    hit_after_exhaustive, hits_exhaustive, seen_exhaustive, crossed_exhaustive,
    count_hit_after_exhaustive, count_hits_exhaustive, count_seen_exhaustive, count_crossed_exhaustive, ExhaustiveTracer, () |primitives, work| ExhaustiveTracer::new(primitives, work)
}

/// Hands a definition what the kernels over a bounding volume hierarchy take, and the tracer.
macro_rules! over_bvh {
    (
        $define:ident, $(#[$doc:meta])* $($name:ident),*;
        placed $placed:literal, in step $in_step:literal
    ) => {
        $define! {
            $(#[$doc])*
            $($name,)* (
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

over_bvh! {
    megakernel,
    /// Over a bounding volume hierarchy.
    render_bvh; placed true, in step false
}

over_bvh! {
    megakernel,
    /// The same where there is no instance but the world.
    render_bvh_world; placed false, in step false
}

over_bvh! {
    walk_kernels,
    /// Over a bounding volume hierarchy.
    hits_bvh, seen_bvh, crossed_bvh, Unwatched;
    placed true, in step false
}

over_bvh! {
    walk_kernels,
    /// The same where there is no instance but the world.
    hits_bvh_world, seen_bvh_world, crossed_bvh_world, Unwatched;
    placed false, in step false
}

over_bvh! {
    walk_kernels,
    /// The same with the threads of a warp in step.
    hits_bvh_in_step, seen_bvh_in_step, crossed_bvh_in_step, Unwatched;
    placed true, in step true
}

walk_kernels! {
    /// Over a hierarchy with eight children a node.
    hits_bvh_wide, seen_bvh_wide, crossed_bvh_wide, Unwatched, (
        nodes: &WideNode,
        roots: &Root<u32>,
        instance_root: u32
    ) |primitives, _work| WideTracer::<true>::new(WideView { nodes: indexed(nodes), roots: indexed(roots), instance_root, primitives })
}

counting_kernels! {
    /// Over a bounding volume hierarchy as CPUs read it, whose walk counts.
    count_hit_after_bvh, count_hits_bvh, count_seen_bvh, count_crossed_bvh, BvhTracer, (
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

walk_and_count_kernels! {
    /// Over an octree, all octants that a ray meets.
    hit_after_octree, hits_octree, seen_octree, crossed_octree,
    count_hit_after_octree, count_hits_octree, count_seen_octree, count_crossed_octree, OctreeTracer, (
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

walk_and_count_kernels! {
    /// Over an octree, octants in the order of the ray.
    hit_after_octree_parametric, hits_octree_parametric, seen_octree_parametric, crossed_octree_parametric,
    count_hit_after_octree_parametric, count_hits_octree_parametric, count_seen_octree_parametric, count_crossed_octree_parametric, OctreeParametricTracer, (
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

walk_and_count_kernels! {
    /// Over a uniform grid.
    hit_after_grid, hits_grid, seen_grid, crossed_grid,
    count_hit_after_grid, count_hits_grid, count_seen_grid, count_crossed_grid, GridTracer, (
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

walk_and_count_kernels! {
    /// Over a kd-tree.
    hit_after_kdtree, hits_kdtree, seen_kdtree, crossed_kdtree,
    count_hit_after_kdtree, count_hits_kdtree, count_seen_kdtree, count_crossed_kdtree, KdTreeTracer, (
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
