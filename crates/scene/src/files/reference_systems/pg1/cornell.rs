//! `builtin:cornell-pg1`: the Cornell box that PG1 publishes figures of.

use crate::error::SceneError;
use crate::files::builtin::load_cornell;
use crate::files::reference_systems::Preset;
use crate::files::{LoadOptions, LoadedScene};

const OBJ: &[u8] = include_bytes!("../../../../builtin/cornell-pg1/CornellBox-Sphere.obj");
const MTL: &[u8] = include_bytes!("../../../../builtin/cornell-pg1/CornellBox-Sphere.mtl");

/// The box of PG1: the files as they are, with PG1's camera and settings.
pub(in crate::files) fn cornell_pg1(options: &LoadOptions) -> Result<LoadedScene, SceneError> {
    let mut loaded = load_cornell("builtin:cornell-pg1", OBJ, MTL, options)?;
    // The only warning is about a stray dot at the end of the built-in file, which users cannot mend.
    loaded.warnings.clear();
    Preset::Pg1.apply(&mut loaded.scene);
    Ok(loaded)
}
