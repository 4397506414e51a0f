//! What pictures say of themselves.

use serde::{Deserialize, Serialize};

/// Raised whenever pixels change, for any scene: pictures of one version, scene and command line are the same.
pub const PICTURE_VERSION: u32 = 11;

/// What pictures say of the program that made them.
pub(super) const SOFTWARE: &str = concat!("Eosphor ", env!("CARGO_PKG_VERSION"));

/// What PNG and EXR files say of themselves besides the program and [`PICTURE_VERSION`]. Other formats name the program
/// only, `.data` nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Metadata {
    /// What the pixels depend on: [`crate::scene_hash`].
    pub scene_hash: Option<String>,
    /// How the program was called. The only part of a file that is not a function of scene and settings.
    pub command_line: Option<String>,
}

/// For formats whose header is written before the end is known: one length, so that it can be written over.
pub(super) fn completeness(complete: bool) -> &'static str {
    if complete { "complete  " } else { "incomplete" }
}
