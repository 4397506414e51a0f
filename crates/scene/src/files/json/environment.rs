//! The environment in JSON: a file name, alone or with how the picture is turned and how bright it is.

use crate::model::{EnvironmentMap, Vector};
use eosphor_core::math::{Vec3, vec3};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A file name, or a file and how it surrounds the scene. The picture is equirectangular: with +y up its middle lies towards +x,
/// and +z right of that, as in Blender and three.js.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "Environment", extend("examples" = [
    "sky.hdr",
    { "file": "sky.hdr", "strength": 2, "rotation-degrees": 90, "seen": false }
]))]
pub(super) enum EnvironmentEntry {
    File(PathBuf),
    Fields(EnvironmentFields),
}

/// An environment by file.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(inline)]
pub(super) struct EnvironmentFields {
    /// HDR, EXR or another picture, beside the scene file.
    #[schemars(extend("examples" = ["sky.hdr"]))]
    file: PathBuf,
    /// The radiance is the picture's colour times this.
    #[serde(default = "one")]
    #[schemars(range(min = 0, max = 1_000_000))]
    strength: f32,
    /// Turns the picture counter-clockwise, seen from above.
    #[serde(default)]
    rotation_degrees: f32,
    /// Where the picture's upper border is.
    #[serde(default = "up")]
    #[schemars(with = "Vector")]
    up: Vec3,
    /// Whether cameras see it; where not, they see the background.
    #[serde(default = "yes")]
    seen: bool,
}

fn one() -> f32 {
    1.0
}

fn up() -> Vec3 {
    vec3(0.0, 1.0, 0.0)
}

fn yes() -> bool {
    true
}

impl EnvironmentEntry {
    pub(super) fn file(&self) -> &Path {
        match self {
            EnvironmentEntry::File(file) => file,
            EnvironmentEntry::Fields(fields) => &fields.file,
        }
    }

    /// The environment that shows this image.
    pub(super) fn of_image(&self, image: u32) -> EnvironmentMap {
        match self {
            EnvironmentEntry::File(_) => EnvironmentMap::of_image(image),
            EnvironmentEntry::Fields(fields) => EnvironmentMap {
                image,
                strength: fields.strength,
                rotation_degrees: fields.rotation_degrees,
                up: fields.up,
                is_seen: fields.seen,
            },
        }
    }
}
