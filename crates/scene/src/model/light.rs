//! Lights, as people describe them. Triangles of an emissive material are lights too and need no entry here.

use super::stand_ins::{Color, Vector};
use eosphor_core::math::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
#[schemars(extend("examples" = [
    { "point": { "position": [0, 3, 0], "color": [60, 60, 60] } },
    { "directional": { "direction": [-1, -2, -1], "color": [2.8, 2.8, 2.5] } },
]))]
pub enum Light {
    /// Shines from a point in all directions.
    Point {
        /// World space.
        #[schemars(with = "Vector")]
        position: Vec3,
        /// Radiant intensity (W/sr); without `light-falloff` the irradiance of surfaces that face it, at any distance.
        #[serde(alias = "colour")]
        #[schemars(with = "Color")]
        color: Vec3,
    },
    /// Shines from infinitely far, like the sun.
    Directional {
        /// The way the light goes; any length.
        #[schemars(with = "Vector")]
        direction: Vec3,
        /// Irradiance of a surface that faces it (W/m²).
        #[serde(alias = "colour")]
        #[schemars(with = "Color")]
        color: Vec3,
    },
    /// A point light with a cone.
    Spot {
        /// World space.
        #[schemars(with = "Vector")]
        position: Vec3,
        /// The way the light goes; any length.
        #[schemars(with = "Vector")]
        direction: Vec3,
        /// Half angle in degrees within which the light is full.
        #[schemars(range(min = 0, max = 180))]
        inner_degrees: f32,
        /// Half angle in degrees outside which there is none.
        #[schemars(extend("exclusiveMinimum" = 0), range(max = 180))]
        outer_degrees: f32,
        /// As of a point light, on the axis.
        #[serde(alias = "colour")]
        #[schemars(with = "Color")]
        color: Vec3,
    },
}
