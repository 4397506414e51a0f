//! Acceleration hierarchies for ray tracing: parallel builders with deterministic results, and CPU traversals.
//!
//! Everything is built over a [`SceneGeometry`] and answers `eosphor-core`'s queries
//! ([`eosphor_core::hierarchy::Tracer`]) with the canonical hit: every structure gives the same answers, bit for bit.

mod bvh;
mod cells;
mod exhaustive;
mod grid;
mod kdtree;
mod octree;
mod packed;
mod packet;
mod statistics;

pub use bvh::{BuildOptions, Bvh};
pub use exhaustive::Exhaustive;
pub use grid::{Grid, GridOptions};
pub use kdtree::{KdTree, KdTreeOptions};
pub use octree::{Octree, OctreeOptions, Overlap};
pub use packed::{PackedPrimitives, SceneGeometry};
pub use packet::PacketTracer;
pub use statistics::HierarchyStatistics;
