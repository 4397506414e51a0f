//! The hierarchy that a backend traces rays through.

use crate::HierarchyOptions;
use crate::backend::cpu::{Queries, SimdLevel, Watch, Watched, with_level};
use eosphor_accel::{
    Bvh, Bvh8, Exhaustive, GeometryError, Grid, GridOptions, HierarchyStatistics, KdTree, Octree,
    OctreeOptions, OneByOne, SceneGeometry,
};
use eosphor_core::geometry::Instance;
use eosphor_core::hierarchy::IgnoreWork;
use eosphor_scene::SceneData;
use serde::Serialize;
use std::fmt;
use std::str::FromStr;

/// The table of structures: everything that is said of each is said here. A line gives its documentation, its name in
/// [`Accel`], on the command line and in [`Hierarchy`], its type, how it is built, the scalar tracer that counts, and the
/// tracer that is fast.
macro_rules! structures {
    ($(
        $(#[$doc:meta])*
        $accel:ident, $name:literal, $hierarchy:ident($structure:ty),
        build: |$scene:ident, $options:ident| $build:expr,
        scalar: |$s:ident, $s_top:ident, $work:ident| $scalar:expr,
        batches: |$b:ident, $b_top:ident, $simd:ident| $batches:expr;
    )*) => {
        /// Acceleration structures.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
        pub enum Accel {
            $($(#[$doc])* #[serde(rename = $name)] $accel,)*
        }

        impl Accel {
            /// All, for help texts.
            pub const ALL: &'static [Accel] = &[$(Accel::$accel),*];

            /// Its name on the command line.
            pub fn name(self) -> &'static str {
                match self {
                    $(Accel::$accel => $name,)*
                }
            }
        }

        /// A structure, built.
        #[derive(Clone, Debug)]
        pub enum Hierarchy {
            $(
                #[doc = concat!("For [`Accel::", stringify!($accel), "`].")]
                $hierarchy($structure),
            )*
        }

        impl Hierarchy {
            /// Builds over a scene, on the threads of the current rayon pool. The result does not depend on their
            /// number. Options that the structure does not have change nothing.
            ///
            /// # Panics
            /// Where the scene's arrays do not hold together, or coordinates are out of range ([`crate::check_scene`]).
            pub fn build(accel: Accel, options: &HierarchyOptions, scene: &SceneData) -> Hierarchy {
                Hierarchy::over(accel, options, geometry_of(scene).expect("scene data that holds together"))
            }

            /// The top level alone: over instances of geometries that a hierarchy of this kind has. It is all that has to be
            /// built for a frame in which instances are elsewhere.
            ///
            /// # Panics
            /// Where coordinates of an instance are out of range: those of a `Moment` are not.
            pub fn build_top(accel: Accel, instances: &[Instance]) -> Hierarchy {
                let geometry = SceneGeometry::of_instances(instances).expect("instances in range");
                Hierarchy::over(accel, &HierarchyOptions::default(), geometry)
            }

            fn over(accel: Accel, options: &HierarchyOptions, geometry: SceneGeometry) -> Hierarchy {
                match accel {
                    $(Accel::$accel => {
                        let ($scene, $options) = (&geometry, options);
                        Hierarchy::$hierarchy($build)
                    })*
                }
            }

            /// What it is.
            pub fn accel(&self) -> Accel {
                match self {
                    $(Hierarchy::$hierarchy(_) => Accel::$accel,)*
                }
            }

            /// It in numbers, under the name that it has here: both octrees are one structure for those who build them.
            pub fn statistics(&self) -> HierarchyStatistics {
                match self {
                    $(Hierarchy::$hierarchy(structure) => {
                        HierarchyStatistics { structure: $name, ..structure.statistics() }
                    })*
                }
            }

            /// Calls `ask` with its fast tracer. `top` has the instances: itself, or one of [`Hierarchy::build_top`].
            pub(crate) fn with_batches<R>(
                &self,
                top: &Hierarchy,
                simd: SimdLevel,
                ask: impl FnOnce(&dyn Queries) -> R,
            ) -> R {
                match (self, top) {
                    $((Hierarchy::$hierarchy($b), Hierarchy::$hierarchy($b_top)) => {
                        let $simd = simd;
                        with_level(&$batches, simd, ask)
                    })*
                    _ => unreachable!("a top level of the same kind"),
                }
            }

            /// Calls `ask` with a tracer that takes rays one by one, and is watched; `top` as above.
            pub(crate) fn with_counting<R>(
                &self,
                top: &Hierarchy,
                watch: &Watch,
                simd: SimdLevel,
                ask: impl FnOnce(&dyn Queries) -> R,
            ) -> R {
                match (self, top) {
                    $((Hierarchy::$hierarchy($s), Hierarchy::$hierarchy($s_top)) => {
                        let $work = watch;
                        with_level(&OneByOne(Watched { tracer: $scalar, watch }), simd, ask)
                    })*
                    _ => unreachable!("a top level of the same kind"),
                }
            }
        }
    };
}

structures! {
    /// Every ray tests every primitive.
    None, "none", Exhaustive(Exhaustive),
    build: |scene, _options| Exhaustive::new(scene),
    scalar: |s, top, work| s.tracer_with_instances_of(top, work),
    batches: |s, top, _simd| OneByOne(s.tracer_with_instances_of(top, IgnoreWork));

    /// Bounding volume hierarchy.
    Bvh, "bvh", Bvh(Bvh),
    build: |scene, options| Bvh::build(scene, &options.bvh()),
    scalar: |s, top, work| s.tracer_with_instances_of(top, work),
    batches: |s, top, _simd| OneByOne(s.tracer_with_instances_of(top, IgnoreWork));

    /// The same with eight children a node and SIMD traversals: the fastest on the CPU.
    Bvh8, "bvh8", Bvh8(Bvh8),
    build: |scene, options| Bvh8::build(scene, &options.bvh()),
    scalar: |s, top, work| s.counting_tracer(work).with_instances_of(top),
    batches: |s, top, simd| s.tracer_at(simd).unwrap_or_else(|| s.tracer()).with_instances_of(top);

    /// Octree, all octants that a ray meets, as PG1 has it.
    Octree, "octree", Octree(Octree),
    build: |scene, options| Octree::build(scene, &options.octree(OctreeOptions::default())),
    scalar: |s, top, work| s.tracer_with_instances_of(top, work),
    batches: |s, top, _simd| OneByOne(s.tracer_with_instances_of(top, IgnoreWork));

    /// Octree of smaller leaves, octants in the order of the ray (Revelles et al. 2000).
    OctreeParametric, "octree-parametric", OctreeParametric(Octree),
    build: |scene, options| Octree::build(scene, &options.octree(OctreeOptions::parametric())),
    scalar: |s, top, work| s.parametric_tracer_with_instances_of(top, work),
    batches: |s, top, _simd| OneByOne(s.parametric_tracer_with_instances_of(top, IgnoreWork));

    /// Uniform grid.
    Grid, "grid", Grid(Grid),
    build: |scene, _options| Grid::build(scene, &GridOptions::default()),
    scalar: |s, top, work| s.tracer_with_instances_of(top, work),
    batches: |s, top, _simd| OneByOne(s.tracer_with_instances_of(top, IgnoreWork));

    /// kd-tree, SAH.
    KdTree, "kdtree", KdTree(KdTree),
    build: |scene, options| KdTree::build(scene, &options.kdtree()),
    scalar: |s, top, work| s.tracer_with_instances_of(top, work),
    batches: |s, top, _simd| OneByOne(s.tracer_with_instances_of(top, IgnoreWork));
}

/// A scene as builders read it.
pub(crate) fn geometry_of(scene: &SceneData) -> Result<SceneGeometry<'_>, GeometryError> {
    SceneGeometry::new(&scene.triangles, &scene.spheres, &scene.geometries, &scene.instances)
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
