//! What GPUs alone do: hierarchies in the form that they read, and walks whose threads go in warps. The only room with
//! `asm!`: loads and votes, no arithmetic. On a CPU everything here runs too, with warps of one thread.

mod deferred;
mod far_tracer;
mod launch;
mod light_queue;
mod pair_tracer;
mod pairs;
mod path_queue;
mod tree_queue;
mod walks;
mod warp;
mod wide;
mod wide_tracer;

pub use far_tracer::FarTracer;
pub use launch::{BandLaunch, DevelopLaunch, HitRow, RayTotals};
pub use light_queue::{
    LightQueue, NO_LIGHT, PROGRESS_ROWS, light_of_word, light_word, progress_of_rows, row_of_vector,
    rows_of_progress, vector_of_row,
};
pub use pair_tracer::PairTracer;
pub use pairs::{BvhPair, Link, PAIR_SLACK, PairView, Root, Target, WarpMode};
pub use path_queue::{
    HIT_ROWS, NODE_CHILDREN, PATH_ROWS, PathControl, PathLaunch, PathPlace, REQUEST_ROWS, Row, hit_of_rows,
    in_ring, is_outside, path_of_rows, query_of_request, query_of_rows, request_of_rows, rows_of_hit,
    rows_of_path, rows_of_request,
};
pub use tree_queue::{
    FRESH_NODE_ROWS, LIT_ROWS, LitPlace, NODE_ROWS, NODE_STRIDE, TreeNode, lit_of_rows, rows_of_fresh_node,
    rows_of_lit, was_traced,
};
pub use wide::{WideNode, WideView};
pub use wide_tracer::WideTracer;
