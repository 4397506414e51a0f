//! What scene files ask for besides the picture: devices, hierarchies, and the file to write.

use super::reference_systems::pg1;
use super::source::Source;
use crate::model::DeviceSettings;
use serde::Deserialize;
use std::path::Path;

/// What a scene file asks for besides the picture: as [`crate::Scene::device`] and [`crate::Scene::output`].
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct SceneRequests {
    /// On what device to render the scene, and through which hierarchy.
    pub device: DeviceSettings,
    /// Path of the picture to write, as the file says it.
    pub output: Option<String>,
    /// Whether the file is a configuration of PG1, which has names of its own.
    #[serde(skip)]
    pub is_pg1: bool,
}

/// Reads that alone, before a device is opened for the scene. Nothing where the file is no JSON or cannot be read: [`crate::load`]
/// says what is wrong with it.
pub fn scene_requests(path: &Path) -> SceneRequests {
    let Some(bytes) = json_of(path) else { return SceneRequests::default() };
    match pg1::is_config(&bytes) {
        true => pg1::requests(&bytes),
        false => serde_json::from_slice(&bytes).unwrap_or_default(),
    }
}

/// The text of a JSON file; nothing where it is called otherwise or cannot be read.
pub(super) fn json_of(path: &Path) -> Option<Vec<u8>> {
    if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
        return None;
    }
    let bytes = Source::Disk.read(path).ok()?;
    Some(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes).to_vec())
}
