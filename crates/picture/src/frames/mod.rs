//! Animations as numbered files: their names, and what is done of them.

mod claims;
mod manifest;
mod pattern;

pub use manifest::{FramesIdentity, Manifest, ManifestError, Wanted};
pub use pattern::{FramePattern, PatternError};
