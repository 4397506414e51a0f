//! What scene files ask for besides the picture: devices, hierarchies, and the file to write.

use super::builtin;
use super::loader::MAX_BASES;
use super::reference_systems::pg1;
use super::source::Source;
use crate::model::DeviceSettings;
use serde::Deserialize;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// What a scene file asks for besides the picture: as [`crate::Scene::device`] and [`crate::Scene::output`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneRequests {
    /// On what device to render the scene, and through which hierarchy.
    pub device: DeviceSettings,
    /// Path of the picture to write, as the file says it.
    pub output: Option<String>,
    /// Whether the file is a configuration of PG1, which has names of its own.
    pub is_pg1: bool,
}

/// The keys of a scene file that ask for something, and its base, which may ask for the rest.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Keys {
    device: Map<String, Value>,
    output: Option<String>,
    base: Option<PathBuf>,
}

/// Reads that alone, before a device is opened for the scene. Nothing where the file is no JSON or cannot be read: [`crate::load`]
/// says what is wrong with it.
pub fn scene_requests(path: &Path) -> SceneRequests {
    let mut path = path.to_path_buf();
    let (mut device, mut output) = (Map::new(), None);
    // (Longer chains are not loaded.)
    for depth in 0..=MAX_BASES {
        let Some(bytes) = json_of(&path) else { break };
        if pg1::is_config(&bytes) {
            let requests = pg1::requests(&bytes);
            if depth == 0 {
                return requests;
            }
            add_missing(&mut device, keys_of(&requests.device));
            output = output.or(requests.output);
            break;
        }
        let keys: Keys = serde_json::from_slice(&bytes).unwrap_or_default();
        add_missing(&mut device, keys.device);
        output = output.or(keys.output);
        match keys.base.filter(|base| builtin::name_of(base).is_none()) {
            Some(base) => path = path.parent().unwrap_or(Path::new("")).join(base),
            None => break,
        }
    }
    let device = serde_json::from_value(Value::Object(device));
    device.map(|device| SceneRequests { device, output, is_pg1: false }).unwrap_or_default()
}

/// Keys that are not there yet.
fn add_missing(device: &mut Map<String, Value>, more: Map<String, Value>) {
    for (key, value) in more {
        device.entry(key).or_insert(value);
    }
}

fn keys_of(device: &DeviceSettings) -> Map<String, Value> {
    match serde_json::to_value(device) {
        Ok(Value::Object(keys)) => keys,
        _ => Map::new(),
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
