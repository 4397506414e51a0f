//! What becomes of each key of a configuration, for those who want to know.

use super::format::{Config, StructureName};
use crate::files::loader::Loader;
use crate::files::source::Source;
use crate::files::{LoadOptions, requests};
use serde_json::Value;
use std::path::Path;

/// A key of a configuration of PG1.
#[derive(Clone, Debug, PartialEq)]
pub struct ConfigKey {
    /// Names of the key and of those around it, as in `renderer.max_depth`.
    pub key: String,
    /// The value, as JSON.
    pub value: String,
    /// What the key does in Eosphor.
    pub used: KeyUse,
}

/// What a key of a PG1 configuration does in Eosphor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyUse {
    /// The key is obeyed.
    As {
        /// What it becomes.
        setting: &'static str,
        /// Flags of the command line that win over it.
        flags: &'static [&'static str],
    },
    /// Nothing, for this reason.
    Not(&'static str),
}

/// All keys of the configuration of PG1 in this file, in the order of their names; none where it is no such file, or a wrong one.
pub fn config_keys(path: &Path) -> Vec<ConfigKey> {
    let Some(bytes) = requests::json_of(path).filter(|bytes| super::is_config(bytes)) else {
        return Vec::new();
    };
    let parsed = serde_json::from_slice::<Config>(&bytes).ok().zip(serde_json::from_slice(&bytes).ok());
    let Some((config, file)) = parsed else { return Vec::new() };
    let mut leaves = Vec::new();
    add_leaves(String::new(), &file, &mut leaves);
    let beside = path.parent().unwrap_or(Path::new(""));
    let of_leaf = |(key, value): (String, &Value)| {
        let used = use_of(&key, &config, beside);
        ConfigKey { key, value: value.to_string(), used }
    };
    leaves.into_iter().map(of_leaf).collect()
}

/// Keys with a value of their own; a vector is one.
fn add_leaves<'a>(way: String, value: &'a Value, leaves: &mut Vec<(String, &'a Value)>) {
    match value {
        Value::Object(entries) => {
            for (key, value) in entries {
                let way = if way.is_empty() { key.clone() } else { format!("{way}.{key}") };
                add_leaves(way, value, leaves);
            }
        }
        Value::Array(items) if items.iter().any(Value::is_object) => {
            items.iter().enumerate().for_each(|(i, item)| add_leaves(format!("{way}[{i}]"), item, leaves));
        }
        _ => leaves.push((way, value)),
    }
}

fn use_of(key: &str, config: &Config, beside: &Path) -> KeyUse {
    let used = |setting, flags| KeyUse::As { setting, flags };
    let renderer = &config.renderer;
    if let Some((_, limit)) = key.split_once("d_data_structure.") {
        let structure = renderer.acceleratied_data_structure.as_ref().map(|structure| structure.name);
        return match limit {
            "name" => used("accel", &["accel"]),
            _ if structure == Some(StructureName::None) => {
                KeyUse::Not("it is beside \"none\", which has none")
            }
            "max_depth" => used("tree-depth", &["tree-depth", "accel"]),
            _ => used("leaf-size", &["leaf-size", "accel"]),
        };
    }
    if let Some((_, of_light)) = key.split_once("point_lights") {
        return used(
            if of_light.ends_with("pos") { "position of a light" } else { "colour of a light" },
            &[],
        );
    }
    match key {
        "seed" => used("seed", &["seed"]),
        "obj_loader.triangulate" if config.obj_loader.triangulate == Some(false) => {
            KeyUse::Not("faces become triangles in any case")
        }
        "obj_loader.triangulate" => used("faces become triangles", &[]),
        "obj_loader.basepath" => match config.obj_loader.basepath.as_deref() {
            Some(base) if !is_in_folder(beside, base, &config.scene.source_file) => {
                KeyUse::Not("the model is not there but beside this file")
            }
            _ => used("folder of the model", &[]),
        },
        "renderer.render_mode" => used("backend", &["backend"]),
        "renderer.max_depth" => used("depth", &["depth", "preset"]),
        "renderer.samples_per_triangle" => used("light-samples", &["light-samples", "preset"]),
        "renderer.render_type" => used("lighting", &["lighting", "preset"]),
        // It counts with the lighting distance alone.
        "renderer.max_distance" => used("max-distance", &["max-distance", "preset"]),
        "renderer.shading_type" => used("normals", &["normals", "preset"]),
        "renderer.cull_backfaces" => used("cull", &["cull", "no-cull", "preset"]),
        "renderer.background_color" => used("background", &["background", "preset"]),
        "renderer.output.filename" if config.output.is_some() => {
            KeyUse::Not("the \"output\" of the whole file is taken")
        }
        "output.filename" | "renderer.output.filename" => used("output", &["output"]),
        "scene.source_file" => used("the model", &[]),
        "scene.camera.pos" => used("eye", &["eye"]),
        "scene.camera.dir" => used("direction", &["direction", "look-at"]),
        "scene.camera.up" => used("up", &["up"]),
        "scene.camera.fov" => used("fov", &["fov"]),
        "scene.camera.width" => used("width of the size", &["size", "preset"]),
        "scene.camera.height" => used("height of the size", &["size", "preset"]),
        "scene.camera.samples_per_pixel" => used("samples", &["samples", "ssaa", "preset"]),
        // An object or a list that is empty, or a key that is null.
        _ => KeyUse::Not("it says nothing"),
    }
}

/// Whether the model lies in the folder that the configuration names.
fn is_in_folder(beside: &Path, base: &str, model: &str) -> bool {
    let loader = Loader::new(Source::Disk, &LoadOptions::default());
    loader.find(&beside.join(base.replace('\\', "/")), model.as_bytes()).is_some()
}
