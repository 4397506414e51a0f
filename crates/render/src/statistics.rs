//! What a render did: rays by kind, hierarchy, tests.

use eosphor_accel::HierarchyStatistics;
use serde::Serialize;
use std::ops::AddAssign;

/// Rays by kind, and the work on them. The counts of nodes and tests are taken only where asked for
/// ([`crate::RenderControl::count_work`]); otherwise they are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RayStatistics {
    /// Rays from the camera.
    pub camera: u64,
    /// Sharp mirror rays.
    pub reflected: u64,
    /// Rays through surfaces.
    pub refracted: u64,
    /// Rays of glossy lobes.
    pub glossy: u64,
    /// Rays towards lights.
    pub shadow: u64,
    /// Hierarchy nodes whose box was tested.
    pub nodes_visited: u64,
    /// Ray-primitive tests.
    pub primitive_tests: u64,
}

impl RayStatistics {
    /// All rays.
    pub fn total_rays(&self) -> u64 {
        self.camera + self.reflected + self.refracted + self.glossy + self.shadow
    }
}

impl AddAssign for RayStatistics {
    fn add_assign(&mut self, o: RayStatistics) {
        self.camera += o.camera;
        self.reflected += o.reflected;
        self.refracted += o.refracted;
        self.glossy += o.glossy;
        self.shadow += o.shadow;
        self.nodes_visited += o.nodes_visited;
        self.primitive_tests += o.primitive_tests;
    }
}

/// A hierarchy in numbers (PG1's table T4).
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct BuildStatistics {
    /// Name of the structure.
    pub structure: String,
    /// Primitives inside.
    pub primitives: u64,
    /// Nodes, leaves included.
    pub nodes: u64,
    /// Leaves.
    pub leaves: u64,
    /// Mean depth of the leaves; the root has depth 0.
    pub mean_leaf_depth: f64,
    /// Largest depth of a leaf.
    pub max_leaf_depth: u32,
    /// Primitives in the fullest leaf.
    pub max_leaf_primitives: u32,
    /// Mean primitives a leaf.
    pub mean_leaf_primitives: f64,
    /// Expected cost of a ray by the surface area heuristic (node visit 1, primitive test 1).
    pub sah_cost: f64,
    /// Bytes of nodes and packed primitives.
    pub bytes: u64,
    /// Seconds it took to build.
    pub build_seconds: f64,
}

impl From<HierarchyStatistics> for BuildStatistics {
    fn from(s: HierarchyStatistics) -> BuildStatistics {
        BuildStatistics {
            structure: s.structure.into(),
            primitives: s.primitives,
            nodes: s.nodes,
            leaves: s.leaves,
            mean_leaf_depth: s.mean_leaf_depth,
            max_leaf_depth: s.max_leaf_depth,
            max_leaf_primitives: s.max_leaf_primitives,
            mean_leaf_primitives: s.mean_leaf_primitives,
            sah_cost: s.sah_cost,
            bytes: s.bytes,
            build_seconds: s.build_seconds,
        }
    }
}
