//! How a scene asks to be rendered: on what, through which hierarchy, into which file. None of it changes a pixel.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// On what, and through which hierarchy, a scene asks to be rendered. It changes no pixel; flags of the command line win.
/// Limits of a hierarchy hold with the `accel` beside them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct DeviceSettings {
    /// The device: the first GPU or else the CPU where not given.
    pub backend: Option<DeviceKind>,
    /// The hierarchy over the primitives: `bvh8` on the CPU and `bvh` on GPUs where not given.
    pub accel: Option<Structure>,
    /// How bounding volume hierarchies are built.
    pub builder: Option<TreeBuilder>,
    /// Primitives that a leaf of a `bvh` (up to 255) or of an octree may hold; octrees divide cells with more where that pays.
    #[schemars(range(min = 1, max = 4_294_967_295u32))]
    pub leaf_size: Option<u32>,
    /// Depth of the deepest leaves of a `bvh` (up to 64), an octree (16) or a kd-tree (46).
    #[schemars(range(min = 1, max = 64))]
    pub tree_depth: Option<u32>,
    /// What the surface area heuristic of a `bvh`, an octree or a kd-tree takes for visiting a node and for a primitive's test.
    #[schemars(inner(range(min = 0, max = 1_000_000)))]
    pub sah_costs: Option<[f32; 2]>,
}

/// Names of an enumeration, as files and command lines have them.
macro_rules! names {
    ($(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $text:tt,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        pub enum $name {
            $($(#[$variant_doc])* #[serde(rename = $text)] $variant,)*
        }

        impl $name {
            /// All values, in the order of their definition.
            pub const ALL: &'static [$name] = &[$($name::$variant,)*];

            /// The name that scene files use.
            pub fn name(self) -> &'static str {
                match self {
                    $($name::$variant => $text,)*
                }
            }
        }
    };
}

names! {
    /// Kinds of devices.
    DeviceKind {
        /// The first GPU, or else the CPU.
        Auto = "auto",
        /// The CPU.
        Cpu = "cpu",
        /// NVIDIA GPUs: the first one.
        Cuda = "cuda",
    }
}

names! {
    /// Acceleration structures.
    Structure {
        /// Every ray tests every primitive.
        None = "none",
        /// Bounding volume hierarchy.
        Bvh = "bvh",
        /// The same with eight children a node, for CPUs.
        Bvh8 = "bvh8",
        /// Octree, all octants that a ray meets.
        Octree = "octree",
        /// Octree, octants in the order of the ray.
        OctreeParametric = "octree-parametric",
        /// Uniform grid.
        Grid = "grid",
        /// kd-tree.
        KdTree = "kdtree",
    }
}

names! {
    /// Builders of bounding volume hierarchies.
    TreeBuilder {
        /// Splits at the middle of the longest side (spatial median).
        Median = "median",
        /// All splits along every axis.
        Sweep = "sweep",
        /// Splits between bins.
        Binned = "binned",
        /// Spatial median for many primitives, then sweep.
        Hybrid = "hybrid",
        /// By the order along a curve.
        Morton = "morton",
        /// Splits of triangles, too.
        Spatial = "spatial",
    }
}
