//! The keys of a JSON scene.

use super::material::{Entries, MaterialEntry};
use crate::model::{Camera, Light, RenderSettings, Transform};
use eosphor_core::math::Vec3;
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::path::PathBuf;

/// A whole file.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct SceneFile {
    #[serde(rename = "eosphor")]
    pub(super) _version: u32,
    #[serde(rename = "$schema", default)]
    pub(super) _schema: Option<IgnoredAny>,
    /// For readers.
    #[serde(rename = "description", default)]
    pub(super) _description: Option<IgnoredAny>,
    #[serde(default)]
    pub(super) camera: Option<Camera>,
    #[serde(default)]
    pub(super) lights: Vec<Light>,
    #[serde(default)]
    pub(super) materials: Entries<MaterialEntry>,
    #[serde(default)]
    pub(super) meshes: Vec<MeshEntry>,
    #[serde(default)]
    pub(super) instances: Vec<InstanceEntry>,
    #[serde(default)]
    pub(super) spheres: Vec<SphereEntry>,
    #[serde(default)]
    pub(super) parallelograms: Vec<ParallelogramEntry>,
    #[serde(default)]
    pub(super) settings: RenderSettings,
}

/// A mesh by file. It is placed once, or, where instances name it, by them alone.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct MeshEntry {
    /// Relative to the scene file.
    pub(super) file: PathBuf,
    /// Instances name the mesh by this; the file's stem where it is not given.
    #[serde(default)]
    pub(super) name: Option<String>,
    /// One of `materials`, for the whole mesh; else those of the file.
    #[serde(default)]
    pub(super) material: Option<String>,
    /// Applied before that of an instance.
    #[serde(default)]
    pub(super) transform: Transform,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct InstanceEntry {
    /// The name of a mesh.
    pub(super) mesh: String,
    #[serde(default)]
    pub(super) transform: Transform,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct SphereEntry {
    pub(super) center: Vec3,
    pub(super) radius: f32,
    #[serde(default)]
    pub(super) material: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct ParallelogramEntry {
    pub(super) corner: Vec3,
    pub(super) edge_u: Vec3,
    pub(super) edge_v: Vec3,
    #[serde(default)]
    pub(super) material: Option<String>,
}
