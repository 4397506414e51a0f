//! KHR_lights_punctual.

use super::enumeration::{Enumeration, Terms, listed};
use serde::Deserialize;
use std::f32::consts::FRAC_PI_4;

/// The extension of the document: all lights.
#[derive(Debug, Deserialize)]
pub(super) struct Lights {
    pub(super) lights: Vec<Light>,
}

/// A light; its node places it. Its `range`, which is no physics, is not read.
#[derive(Debug, Deserialize)]
pub struct Light {
    pub name: Option<String>,
    #[serde(rename = "type", deserialize_with = "listed")]
    pub light_type: Option<LightType>,
    #[serde(default = "white")]
    pub color: [f32; 3],
    /// In candela for point and spot lights, in lux for directional ones.
    #[serde(default = "one")]
    pub intensity: f32,
    pub spot: Option<Spot>,
}

/// The cone of a spot light: half angles, in radians.
#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Spot {
    pub inner_cone_angle: f32,
    pub outer_cone_angle: f32,
}

impl Default for Spot {
    fn default() -> Spot {
        Spot { inner_cone_angle: 0.0, outer_cone_angle: FRAC_PI_4 }
    }
}

/// The type of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightType {
    Directional,
    Point,
    Spot,
}

impl Enumeration for LightType {
    const TERMS: Terms<LightType> = Terms::Names(&[
        ("directional", LightType::Directional),
        ("point", LightType::Point),
        ("spot", LightType::Spot),
    ]);
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

fn one() -> f32 {
    1.0
}
