//! Finding hits: the queries, the hierarchies as devices read them, and their scalar traversals.
//!
//! # Closed views
//!
//! A view (`BvhView`, `PairView`, ...) is plain borrowed arrays. Traversals follow the numbers in them without looking where they
//! lead, so the constructors of tracers are unsafe, and their callers promise that the view is **closed**:
//!
//! - Every number of a node, root, reference, primitive, geometry or instance in these arrays is the number of an item in the
//!   array that it names, and every range lies in its array. There is a geometry 0, and instance 0 is the world.
//! - From each root no path is longer than the `MAX_..._DEPTH` of its structure, so that stacks of fixed size suffice.
//!
//! - Coordinates are within [`LARGEST_NUMBER`](crate::intersect::LARGEST_NUMBER), and maps of instances are finite. (Rays may have
//!   any numbers.)
//!
//! `eosphor-accel` builds closed views and makes tracers safely. Without `unsafe` there is no tracer over other arrays:
//!
//! ```compile_fail,E0133
//! # use eosphor_core::hierarchy::{BvhTracer, BvhView, IgnoreWork};
//! fn over(lies: BvhView) {
//!     BvhTracer::new(lies, IgnoreWork);
//! }
//! ```
//!
//! ```compile_fail,E0451
//! # use eosphor_core::hierarchy::{IgnoreWork, OctreeTracer, OctreeView};
//! fn over(lies: OctreeView) {
//!     OctreeTracer { tree: lies, work: IgnoreWork };
//! }
//! ```
//!
//! ```compile_fail,E0616
//! # use eosphor_core::device::PairTracer;
//! fn shrink(mut tracer: PairTracer<true>) {
//!     tracer.view.pairs = &[];
//! }
//! ```

mod bvh;
pub(crate) mod candidates;
mod cell_ray;
mod exhaustive;
pub(crate) mod far;
mod grid;
mod kdtree;
pub(crate) mod moved;
mod moved_bounds;
mod octree;
mod references;
pub(crate) mod search;
pub(crate) mod stack;
mod tracer;
mod two_level;
mod watch;
mod work;

pub use bvh::{BvhNode, BvhTracer, BvhView, MAX_BVH_DEPTH};
pub use candidates::PrimitivesView;

pub use exhaustive::ExhaustiveTracer;
pub use far::{BoxEntry, FAR, FarRay, is_far, moved_at};
pub use grid::{GridRoot, GridTracer, GridView, MAX_GRID_CELLS};
pub use kdtree::{KdNode, KdRoot, KdTreeTracer, KdTreeView, MAX_KD_DEPTH};
pub use moved_bounds::{LOST, moved_end, moved_start, widening};
pub use octree::{
    MAX_OCTREE_DEPTH, OctreeNode, OctreeParametricTracer, OctreeRoot, OctreeTracer, OctreeView,
};
pub use references::SPHERE_REFERENCE;
pub use search::{bounds_of_last, upper};
pub use stack::Stack;
pub use tracer::{ShadowBatch, Tracer};
pub use two_level::InstanceTreeView;
pub use watch::{Phase, PhaseClock, Watch, Watched};
pub use work::{CountWork, IgnoreWork, Work};
