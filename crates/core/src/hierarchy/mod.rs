//! Finding hits: the queries, the hierarchies as devices read them, and their scalar traversals.

mod bvh;
mod candidates;
mod exhaustive;
mod stack;
mod tracer;
mod work;

pub use bvh::{BvhNode, BvhTracer, BvhView, MAX_BVH_DEPTH};
pub use candidates::PrimitivesView;
pub(crate) use candidates::item;
pub use exhaustive::ExhaustiveTracer;
pub use stack::Stack;
pub use tracer::{ShadowBatch, Tracer};
pub use work::{CountWork, IgnoreWork, Work};
