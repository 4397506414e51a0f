//! The metallic-roughness material of glTF 2.0.

use super::schema_types::{Color, IndexOfRefraction, Share};
use eosphor_core::math::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A metallic-roughness material, as in glTF 2.0 with KHR_materials_ior, _specular, _transmission and _volume. How
/// it becomes reflected and transmitted rays is written in `crates/core/src/shading/evaluated_material.rs`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
#[schemars(
    description = "A metallic-roughness material, as in glTF 2.0 with KHR_materials_ior, _specular, _transmission and \
                   _volume.",
    extend("examples" = [{ "color": [0.9, 0.6, 0.3], "metallic": 1, "roughness": 0.35 }]),
)]
pub struct Pbr {
    /// Base colour: of the diffuse part of what is no metal, of the reflection of metal, of what is transmitted.
    #[serde(alias = "colour")]
    #[schemars(with = "Color")]
    pub color: Vec3,
    /// 1 is opaque; counts where [`super::Material::alpha`] is not `Opaque`.
    #[schemars(description = "1 is opaque; counts where `alpha` of the material is not `opaque`.")]
    #[schemars(range(min = 0, max = 1))]
    pub opacity: f32,
    /// 0 is no metal, 1 is metal.
    #[schemars(range(min = 0, max = 1))]
    pub metallic: f32,
    /// 0 is a sharp mirror, 1 reflects in all directions.
    #[schemars(range(min = 0, max = 1))]
    pub roughness: f32,
    /// Radiance that leaves the surface by itself.
    #[schemars(with = "Color")]
    pub emission: Vec3,
    /// Index of refraction.
    #[serde(deserialize_with = "super::ior::number_or_name")]
    #[schemars(with = "IndexOfRefraction")]
    pub ior: f32,
    /// Weight of the reflection of what is no metal, 0 to 1.
    #[schemars(range(min = 0, max = 1))]
    pub specular: f32,
    /// Colour of that reflection at normal incidence.
    #[serde(alias = "specular-colour")]
    #[schemars(with = "Color")]
    pub specular_color: Vec3,
    /// Share of the light that is not reflected and goes through what is no metal, 0 to 1.
    #[schemars(range(min = 0, max = 1))]
    pub transmission: f32,
    /// The surface bounds a body, which refracts and attenuates; otherwise it is thin, and light goes straight through.
    pub solid: bool,
    /// Colour of white light after it went [`Pbr::attenuation_distance`] through the body.
    #[serde(alias = "attenuation-colour")]
    #[schemars(with = "Share")]
    pub attenuation_color: Vec3,
    /// The distance of [`Pbr::attenuation_color`], in world units; where not given, the body attenuates nothing.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub attenuation_distance: Option<f32>,
}

impl Default for Pbr {
    fn default() -> Pbr {
        Pbr {
            color: Vec3::ONE,
            opacity: 1.0,
            metallic: 0.0,
            roughness: 1.0,
            emission: Vec3::ZERO,
            ior: 1.5,
            specular: 1.0,
            specular_color: Vec3::ONE,
            transmission: 0.0,
            solid: false,
            attenuation_color: Vec3::ONE,
            attenuation_distance: None,
        }
    }
}
