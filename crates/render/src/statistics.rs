//! What a render did: rays by kind, nodes, tests, and how long that took.

use eosphor_core::integrator::RayCounts;
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// Rays by kind, and the work on them. The counts of searches, nodes and tests, and the times, are taken only where asked for
/// ([`crate::RenderControl::count_work`]); otherwise they are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RayStatistics {
    /// Number of rays from the camera.
    pub camera: u64,
    /// Number of rays that mirrors reflect in one direction.
    pub reflected: u64,
    /// Number of rays that pass through surfaces, bent or straight.
    pub refracted: u64,
    /// Number of rays of glossy lobes.
    pub glossy: u64,
    /// Number of rays towards lights.
    pub shadow: u64,
    /// Queries about rays that were answered. A ray takes one; a shadow ray that is tinted on its way one more for each surface.
    pub searches: u64,
    /// Hierarchy nodes whose box was tested.
    pub nodes_visited: u64,
    /// Ray-primitive tests: what leaves that were reached hand to the tests.
    pub primitive_tests: u64,
    /// How long the searches took, where work was counted.
    pub times: QueryTimes,
}

/// How long searches took, by clocks that are read at the beginning and the end of each, and whenever one goes on from nodes to
/// primitives or back. What reading takes is taken off. The times of all threads are added up; a thread that has to wait for a
/// core takes longer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct QueryTimes {
    /// Nanoseconds of finding the way to primitives.
    pub traversal_nanoseconds: u64,
    /// Nanoseconds of testing primitives.
    pub intersection_nanoseconds: u64,
}

impl QueryTimes {
    /// Nanoseconds of traversal and tests together.
    pub fn all_nanoseconds(&self) -> u64 {
        self.traversal_nanoseconds + self.intersection_nanoseconds
    }
}

impl RayStatistics {
    /// Number of rays of all kinds.
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
        self.searches += o.searches;
        self.nodes_visited += o.nodes_visited;
        self.primitive_tests += o.primitive_tests;
        self.times.traversal_nanoseconds += o.times.traversal_nanoseconds;
        self.times.intersection_nanoseconds += o.times.intersection_nanoseconds;
    }
}
