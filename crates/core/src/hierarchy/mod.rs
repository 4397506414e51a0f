//! Finding hits: the queries, the hierarchies as devices read them, and their scalar traversals.

mod bvh;
mod candidates;
mod cell_ray;
mod exhaustive;
mod far;
mod far_tracer;
mod grid;
mod kdtree;
mod octree;
mod pair_tracer;
mod pairs;
mod put_off;
mod references;
mod search;
mod stack;
mod tracer;
mod two_level;
mod walks;
mod warp;
mod watch;
mod wide;
mod wide_tracer;
mod work;

pub use bvh::{BvhNode, BvhTracer, BvhView, MAX_BVH_DEPTH};
pub use candidates::PrimitivesView;
pub(crate) use candidates::item;
pub use exhaustive::ExhaustiveTracer;
pub use far::{Entry, FAR, FarRay, is_far, moved_at};
pub use far_tracer::FarTracer;
pub use grid::{GridRoot, GridTracer, GridView, MAX_GRID_CELLS};
pub use kdtree::{KdNode, KdRoot, KdTreeTracer, KdTreeView, MAX_KD_DEPTH};
pub use octree::{
    MAX_OCTREE_DEPTH, OctreeNode, OctreeParametricTracer, OctreeRoot, OctreeTracer, OctreeView,
};
pub use pair_tracer::PairTracer;
pub use pairs::{BvhPair, Company, Link, PAIR_SLACK, PairView, Root, Target};
pub use references::SPHERE_REFERENCE;
pub use search::{LOST, bounds_of_last, moved_end, moved_start, upper, widening};
pub use stack::Stack;
pub use tracer::{ShadowBatch, Tracer};
pub use two_level::InstanceTreeView;
pub use watch::{Phase, PhaseClock, Watch, Watched};
pub use wide::{WideNode, WideView};
pub use wide_tracer::WideTracer;
pub use work::{CountWork, IgnoreWork, Work};
