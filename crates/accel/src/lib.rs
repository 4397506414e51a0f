//! Acceleration hierarchies for ray tracing: parallel builders with deterministic results, and CPU traversals.
//!
//! Everything is built over a [`SceneGeometry`] and answers `eosphor-core`'s queries
//! ([`eosphor_core::hierarchy::Tracer`]) with the canonical hit: every structure gives the same answers, bit for bit.

mod batch;
mod bvh;
pub mod bvh8;
mod exhaustive;
mod packed;
mod packet;
mod simd;
mod simd_level;
mod statistics;

pub use batch::{BatchTracer, Coherence, Filters, OneByOne};
pub use bvh::{BuildOptions, Builder, Bvh, Quality};
pub use bvh8::{Bvh8, Bvh8Tracer};
pub use exhaustive::Exhaustive;
pub use packed::{PackedPrimitives, SceneGeometry};
pub use packet::PacketTracer;
pub use simd_level::SimdLevel;
pub use statistics::HierarchyStatistics;
