//! The configuration files of PG1.

use super::loader::Loader;
use crate::error::SceneError;
use crate::model::Instance;
use std::path::Path;

/// Adds the meshes and materials of a file, placed as it says; its cameras and lights are left out.
#[allow(dead_code, reason = "to be filled")]
pub(super) fn read_model(_loader: &mut Loader, path: &Path) -> Result<Vec<Instance>, SceneError> {
    Err(super::unknown_format(path, None))
}
