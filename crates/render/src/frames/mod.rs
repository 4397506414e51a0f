//! Animations as numbered files: their names, and what is done of them.

mod manifest;
mod pattern;

pub use manifest::{FramesIdentity, Manifest, ManifestError};
pub use pattern::{FramePattern, PatternError};
