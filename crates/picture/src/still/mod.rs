//! Stills in pieces: strips of rows, of which samples are taken a few at a time, and a file beside the picture that keeps
//! what is done ([`Checkpoint`]), so that a still that ends early goes on from there, and several machines can take some of its
//! samples each ([`merge_samples`]).

mod checkpoint;
mod identity;
mod merge;
mod plan;
mod strip;
mod sums_file;

pub use checkpoint::{Checkpoint, checkpoint_path, sample_share_path};
pub use identity::{Part, SampleShare};
pub use merge::{MergeError, merge_samples};
pub use plan::StripPlan;
pub use strip::Strip;
pub use sums_file::SumsError;
