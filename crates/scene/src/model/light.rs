//! Lights, as people describe them. Triangles of an emissive material are lights too and need no entry here.

use super::schema_types::{Color, Vector};
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

/// What most kinds of lights have; a new kind is described here.
pub(crate) struct LightParts<'a> {
    /// Where it is, unless it is infinitely far.
    pub(crate) position: Option<&'a mut Vec3>,
    /// The way its light goes, any length, unless it goes everywhere.
    pub(crate) direction: Option<&'a mut Vec3>,
    /// Its colour.
    pub(crate) color: &'a mut Vec3,
}

impl Light {
    /// Its parts, to be read or changed.
    pub(crate) fn parts(&mut self) -> LightParts<'_> {
        match self {
            Light::Point { position, color } => {
                LightParts { position: Some(position), direction: None, color }
            }
            Light::Directional { direction, color } => {
                LightParts { position: None, direction: Some(direction), color }
            }
            Light::Spot { position, direction, color, inner_degrees: _, outer_degrees: _ } => {
                LightParts { position: Some(position), direction: Some(direction), color }
            }
        }
    }

    /// The key of scene files that begins it.
    pub(crate) fn key(&self) -> &'static str {
        match self {
            Light::Point { .. } => "point",
            Light::Directional { .. } => "directional",
            Light::Spot { .. } => "spot",
        }
    }

    /// The numbers that no other kind has: name, value, least and largest.
    pub(crate) fn own_numbers(&self) -> Vec<(&'static str, f32, f32, f32)> {
        match *self {
            Light::Point { .. } | Light::Directional { .. } => Vec::new(),
            Light::Spot { inner_degrees, outer_degrees, .. } => vec![
                ("outer-degrees", outer_degrees, 0.0, 180.0),
                ("inner-degrees", inner_degrees, 0.0, outer_degrees),
            ],
        }
    }
}
