//! What a render did: rays by kind, nodes, tests.

use eosphor_core::whitted::RayCounts;
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// Rays by kind, and the work on them. The counts of nodes and tests are taken only where asked for
/// ([`crate::RenderControl::count_work`]); otherwise they are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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

impl From<RayCounts> for RayStatistics {
    #[inline(always)]
    fn from(counts: RayCounts) -> RayStatistics {
        let RayCounts { camera, reflected, refracted, glossy, shadow } = counts;
        RayStatistics { camera, reflected, refracted, glossy, shadow, ..RayStatistics::default() }
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
