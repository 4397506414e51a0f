//! Stills in pieces: strips of rows, of which samples are taken a few at a time, and a file beside the picture that keeps
//! what is done ([`Checkpoint`]), so that a still that ends early goes on from there.

mod checkpoint;
mod plan;
mod strip;

pub use checkpoint::{Checkpoint, CheckpointError, SceneIdentity, checkpoint_path};
pub use plan::StripPlan;
pub use strip::Strip;
