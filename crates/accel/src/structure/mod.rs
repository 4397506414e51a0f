//! Which structure: the closed set of them, and one that was chosen at run time.

mod options;

pub use options::{HierarchyOption, HierarchyOptions, MisfitKind, OptionMisfit, SahCosts};

use crate::{
    BatchTracer, Bvh, Bvh8, Exhaustive, GeometryError, Grid, GridOptions, HierarchyStatistics, KdTree,
    Octree, OctreeOptions, OneByOne, RefitError, SceneGeometry, SimdLevel,
};
use eosphor_core::geometry::Instance;
use eosphor_core::hierarchy::{IgnoreWork, InstanceTreeView, Tracer, Work};
use std::fmt;
use std::str::FromStr;

/// Something to do with a [`Tracer`] whose type depends on the structure: a closure that is generic over it, for
/// [`Hierarchy::with_counting_tracer`].
pub trait UseTracer {
    /// What it returns.
    type Output;
    /// Calls the closure with this tracer.
    fn run<T: Tracer>(self, tracer: T) -> Self::Output;
}

/// Something to do with a [`BatchTracer`] whose type depends on the structure: a closure that is generic over it, for
/// [`Hierarchy::with_batch_tracer`].
pub trait UseBatchTracer {
    /// What it returns.
    type Output;
    /// Calls the closure with this tracer.
    fn run<T: BatchTracer>(self, tracer: &T) -> Self::Output;
}

/// The table of structures: everything that is said of each is said here. A line gives its documentation, its name in
/// [`Accel`], on the command line and in [`Hierarchy`], its type, how it is built, and from a geometry on,
/// the scalar tracer that counts, and the tracer that is fast, and the binary tree over its instances where it has one.
macro_rules! structures {
    ($(
        $(#[$doc:meta])*
        $accel:ident, $name:literal, $hierarchy:ident($structure:ty),
        build: |$scene:ident, $options:ident| $build:expr,
        rebuild: |$r:ident, $first:ident, $r_scene:ident, $r_options:ident| $rebuild:expr,
        scalar: |$s:ident, $s_top:ident, $work:ident| $scalar:expr,
        batches: |$b:ident, $b_top:ident, $simd:ident| $batches:expr,
        instances: |$i:ident| $instances:expr;
    )*) => {
        /// The acceleration structures of this crate. All give the same hits; `Bvh8` is the fastest on the CPU.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize))]
        pub enum Accel {
            $($(#[$doc])* #[cfg_attr(feature = "serde", serde(rename = $name))] $accel,)*
        }

        impl Accel {
            /// All structures, in the order of help texts.
            pub const ALL: &'static [Accel] = &[$(Accel::$accel),*];

            /// The name of the structure, which [`str::parse`] takes.
            pub fn name(self) -> &'static str {
                match self {
                    $(Accel::$accel => $name,)*
                }
            }
        }

        /// A structure that was chosen at run time, built.
        #[derive(Clone, Debug)]
        pub enum Hierarchy {
            $(
                #[doc = concat!("For [`Accel::", stringify!($accel), "`].")]
                $hierarchy($structure),
            )*
        }

        impl Hierarchy {
            /// Builds a structure over a scene, on the threads of the current rayon pool. The result does not depend on their
            /// number. Options that the structure does not have change nothing.
            pub fn build(accel: Accel, options: &HierarchyOptions, scene: &SceneGeometry) -> Hierarchy {
                match accel {
                    $(Accel::$accel => {
                        let ($scene, $options) = (scene, options);
                        Hierarchy::$hierarchy($build)
                    })*
                }
            }

            /// The top level alone: over instances of geometries that a hierarchy of this kind has. It is all that has to be
            /// built for a frame in which instances are elsewhere.
            ///
            /// # Errors
            /// Where coordinates of an instance are out of range.
            pub fn build_top(accel: Accel, instances: &[Instance]) -> Result<Hierarchy, GeometryError> {
                let instances = SceneGeometry::of_instances(instances)?;
                Ok(Hierarchy::build(accel, &HierarchyOptions::default(), &instances))
            }

            /// Builds what is over the geometries from number `first` on anew, and what is over the instances. The result is
            /// what [`Hierarchy::build`] makes of the scene, if the geometries before are as they were. It is what has to be
            /// done for a frame in which the last geometries have other shapes.
            ///
            /// # Errors
            /// Where the geometries before have other ranges in the scene; nothing is changed then.
            pub fn rebuild_from(
                &mut self,
                first: usize,
                scene: &SceneGeometry,
                options: &HierarchyOptions,
            ) -> Result<(), RefitError> {
                match self {
                    $(Hierarchy::$hierarchy($r) => {
                        let ($first, $r_scene, $r_options) = (first, scene, options);
                        $rebuild
                    })*
                }
            }

            /// Which structure it is.
            pub fn accel(&self) -> Accel {
                match self {
                    $(Hierarchy::$hierarchy(_) => Accel::$accel,)*
                }
            }

            /// The hierarchy in numbers. The structure's name is that of [`Accel::name`], which tells the two octrees apart.
            pub fn statistics(&self) -> HierarchyStatistics {
                match self {
                    $(Hierarchy::$hierarchy(structure) => {
                        HierarchyStatistics { structure: $name, ..structure.statistics() }
                    })*
                }
            }

            /// The binary tree over the instances, for structures that keep it apart from their own nodes.
            pub fn instance_tree(&self) -> Option<InstanceTreeView<'_>> {
                match self {
                    $(Hierarchy::$hierarchy($i) => $instances,)*
                }
            }

            /// Hands the fastest tracer of the structure to `user` and returns what that makes of it; `level` matters to `Bvh8`
            /// alone.
            /// `top` has the instances: this hierarchy itself, or one of [`Hierarchy::build_top`].
            ///
            /// # Panics
            /// Where `top` is of another kind, or has instances of geometries that this one lacks.
            pub fn with_batch_tracer<U: UseBatchTracer>(&self, top: &Hierarchy, level: SimdLevel, user: U) -> U::Output {
                match (self, top) {
                    $((Hierarchy::$hierarchy($b), Hierarchy::$hierarchy($b_top)) => {
                        let $simd = level;
                        user.run(&$batches)
                    })*
                    _ => panic!("a top level of {} for a {}", top.accel(), self.accel()),
                }
            }

            /// Hands the tracer that takes rays one by one and tells `work` what it does to `user`, and returns what that makes of
            /// it.
            /// `top` has the instances: this hierarchy itself, or one of [`Hierarchy::build_top`].
            ///
            /// # Panics
            /// Where `top` is of another kind, or has instances of geometries that this one lacks.
            pub fn with_counting_tracer<W: Work + Copy, U: UseTracer>(&self, top: &Hierarchy, work: W, user: U) -> U::Output {
                match (self, top) {
                    $((Hierarchy::$hierarchy($s), Hierarchy::$hierarchy($s_top)) => {
                        let $work = work;
                        user.run($scalar)
                    })*
                    _ => panic!("a top level of {} for a {}", top.accel(), self.accel()),
                }
            }
        }
    };
}

structures! {
    /// Every ray tests every primitive.
    None, "none", Exhaustive(Exhaustive),
    build: |scene, _options| Exhaustive::new(scene),
    rebuild: |s, first, scene, _options| s.rebuild_from(first, scene),
    scalar: |s, top, work| s.tracer_with_instances_of(top, work),
    batches: |s, top, _simd| OneByOne(s.tracer_with_instances_of(top, IgnoreWork)),
    instances: |_s| None;

    /// Bounding volume hierarchy with two children a node.
    Bvh, "bvh", Bvh(Bvh),
    build: |scene, options| Bvh::build(scene, &options.bvh()),
    rebuild: |s, first, scene, options| s.rebuild_from(first, scene, &options.bvh()),
    scalar: |s, top, work| s.tracer_with_instances_of(top, work),
    batches: |s, top, _simd| OneByOne(s.tracer_with_instances_of(top, IgnoreWork)),
    instances: |s| Some(s.instance_tree());

    /// Bounding volume hierarchy with eight children a node and SIMD traversals: the fastest on the CPU.
    Bvh8, "bvh8", Bvh8(Bvh8),
    build: |scene, options| Bvh8::build(scene, &options.bvh()),
    rebuild: |s, first, scene, options| s.rebuild_from(first, scene, &options.bvh()),
    scalar: |s, top, work| s.counting_tracer(work).with_instances_of(top),
    batches: |s, top, simd| s.tracer_at(simd).unwrap_or_else(|| s.tracer()).with_instances_of(top),
    instances: |_s| None;

    /// Octree, whose traversal visits all octants that a ray meets, as PG1's does.
    Octree, "octree", Octree(Octree),
    build: |scene, options| Octree::build(scene, &options.octree(OctreeOptions::default())),
    rebuild: |s, first, scene, options| s.rebuild_from(first, scene, &options.octree(OctreeOptions::default())),
    scalar: |s, top, work| s.tracer_with_instances_of(top, work),
    batches: |s, top, _simd| OneByOne(s.tracer_with_instances_of(top, IgnoreWork)),
    instances: |s| Some(s.instance_tree());

    /// Octree of smaller leaves, whose traversal visits octants in the order of the ray (Revelles et al. 2000).
    OctreeParametric, "octree-parametric", OctreeParametric(Octree),
    build: |scene, options| Octree::build(scene, &options.octree(OctreeOptions::parametric())),
    rebuild: |s, first, scene, options| s.rebuild_from(first, scene, &options.octree(OctreeOptions::parametric())),
    scalar: |s, top, work| s.parametric_tracer_with_instances_of(top, work),
    batches: |s, top, _simd| OneByOne(s.parametric_tracer_with_instances_of(top, IgnoreWork)),
    instances: |s| Some(s.instance_tree());

    /// Uniform grid.
    Grid, "grid", Grid(Grid),
    build: |scene, _options| Grid::build(scene, &GridOptions::default()),
    rebuild: |s, first, scene, _options| s.rebuild_from(first, scene, &GridOptions::default()),
    scalar: |s, top, work| s.tracer_with_instances_of(top, work),
    batches: |s, top, _simd| OneByOne(s.tracer_with_instances_of(top, IgnoreWork)),
    instances: |s| Some(s.instance_tree());

    /// kd-tree, built by the surface area heuristic.
    KdTree, "kdtree", KdTree(KdTree),
    build: |scene, options| KdTree::build(scene, &options.kdtree()),
    rebuild: |s, first, scene, options| s.rebuild_from(first, scene, &options.kdtree()),
    scalar: |s, top, work| s.tracer_with_instances_of(top, work),
    batches: |s, top, _simd| OneByOne(s.tracer_with_instances_of(top, IgnoreWork)),
    instances: |s| Some(s.instance_tree());
}

impl fmt::Display for Accel {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Accel {
    type Err = String;
    fn from_str(s: &str) -> Result<Accel, String> {
        Accel::ALL.iter().find(|a| a.name() == s).copied().ok_or_else(|| {
            let names: Vec<&str> = Accel::ALL.iter().map(|a| a.name()).collect();
            format!("unknown acceleration structure '{s}': choose one of {}", names.join(", "))
        })
    }
}
