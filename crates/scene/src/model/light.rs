//! Lights, as people describe them. Triangles of an emissive material are lights too and need no entry here.

use eosphor_core::math::Vec3;
use serde::{Deserialize, Serialize};

/// A light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
pub enum Light {
    /// Shines from a point in all directions.
    Point {
        /// World space.
        position: Vec3,
        /// Radiant intensity.
        #[serde(alias = "colour")]
        color: Vec3,
    },
    /// Shines from infinitely far, like the sun.
    Directional {
        /// The way the light goes; any length.
        direction: Vec3,
        /// Irradiance on a surface that faces it.
        #[serde(alias = "colour")]
        color: Vec3,
    },
    /// A point light with a cone.
    Spot {
        /// World space.
        position: Vec3,
        /// The way the light goes; any length.
        direction: Vec3,
        /// Half angle in degrees within which the light is full.
        inner_degrees: f32,
        /// Half angle in degrees outside which there is none.
        outer_degrees: f32,
        /// Radiant intensity on the axis.
        #[serde(alias = "colour")]
        color: Vec3,
    },
}
