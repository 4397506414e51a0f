//! Materials and their extensions.

use super::enumeration::{Enumeration, Terms, listed};
use super::{NormalTexture, TextureInfo};
use serde::Deserialize;
use serde::de::IgnoredAny;

/// A material.
#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Material {
    pub name: Option<String>,
    #[serde(deserialize_with = "listed")]
    pub alpha_mode: Option<AlphaMode>,
    pub alpha_cutoff: Option<f32>,
    pub double_sided: bool,
    pub pbr_metallic_roughness: PbrMetallicRoughness,
    pub normal_texture: Option<NormalTexture>,
    /// Occlusion is not rendered; whether there is a texture of it is told.
    pub occlusion_texture: Option<IgnoredAny>,
    pub emissive_texture: Option<TextureInfo>,
    pub emissive_factor: [f32; 3],
    /// Few materials have extensions, and they are large.
    pub extensions: Option<Box<MaterialExtensions>>,
}

impl Default for Material {
    fn default() -> Material {
        Material {
            name: None,
            alpha_mode: Some(AlphaMode::Opaque),
            alpha_cutoff: None,
            double_sided: false,
            pbr_metallic_roughness: PbrMetallicRoughness::default(),
            normal_texture: None,
            occlusion_texture: None,
            emissive_texture: None,
            emissive_factor: [0.0; 3],
            extensions: None,
        }
    }
}

/// What alpha means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlphaMode {
    Opaque,
    Mask,
    Blend,
}

impl Enumeration for AlphaMode {
    const TERMS: Terms<AlphaMode> = Terms::Names(&[
        ("OPAQUE", AlphaMode::Opaque),
        ("MASK", AlphaMode::Mask),
        ("BLEND", AlphaMode::Blend),
    ]);
}

/// The metallic-roughness model.
#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct PbrMetallicRoughness {
    pub base_color_factor: [f32; 4],
    pub base_color_texture: Option<TextureInfo>,
    pub metallic_factor: f32,
    pub roughness_factor: f32,
    pub metallic_roughness_texture: Option<TextureInfo>,
}

impl Default for PbrMetallicRoughness {
    fn default() -> PbrMetallicRoughness {
        PbrMetallicRoughness {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
        }
    }
}

/// Extensions of a material.
#[derive(Debug, Deserialize)]
pub struct MaterialExtensions {
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_ior")]
    pub ior: Option<Ior>,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub specular_glossiness: Option<SpecularGlossiness>,
    #[serde(rename = "KHR_materials_specular")]
    pub specular: Option<Specular>,
    #[serde(rename = "KHR_materials_transmission")]
    pub transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_unlit")]
    pub unlit: Option<IgnoredAny>,
    #[serde(rename = "KHR_materials_volume")]
    pub volume: Option<Volume>,
}

/// KHR_materials_emissive_strength.
#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct EmissiveStrength {
    pub emissive_strength: f32,
}

impl Default for EmissiveStrength {
    fn default() -> EmissiveStrength {
        EmissiveStrength { emissive_strength: 1.0 }
    }
}

/// KHR_materials_ior.
#[derive(Debug, Deserialize)]
#[serde(default)]
pub struct Ior {
    pub ior: f32,
}

impl Default for Ior {
    fn default() -> Ior {
        Ior { ior: 1.5 }
    }
}

/// KHR_materials_pbrSpecularGlossiness. Its texture of specular colour and glossiness is not read.
#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct SpecularGlossiness {
    pub diffuse_factor: [f32; 4],
    pub diffuse_texture: Option<TextureInfo>,
    pub specular_factor: [f32; 3],
    pub glossiness_factor: f32,
}

impl Default for SpecularGlossiness {
    fn default() -> SpecularGlossiness {
        SpecularGlossiness {
            diffuse_factor: [1.0; 4],
            diffuse_texture: None,
            specular_factor: [1.0; 3],
            glossiness_factor: 1.0,
        }
    }
}

/// KHR_materials_specular. Its textures are not rendered; whether there are some is told.
#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Specular {
    pub specular_factor: f32,
    pub specular_texture: Option<IgnoredAny>,
    pub specular_color_factor: [f32; 3],
    pub specular_color_texture: Option<IgnoredAny>,
}

impl Default for Specular {
    fn default() -> Specular {
        Specular {
            specular_factor: 1.0,
            specular_texture: None,
            specular_color_factor: [1.0; 3],
            specular_color_texture: None,
        }
    }
}

/// KHR_materials_transmission.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Transmission {
    pub transmission_factor: f32,
    pub transmission_texture: Option<TextureInfo>,
}

/// KHR_materials_volume. Rays measure the thickness themselves, so its texture is not read.
#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Volume {
    pub thickness_factor: f32,
    pub attenuation_distance: f32,
    pub attenuation_color: [f32; 3],
}

impl Default for Volume {
    fn default() -> Volume {
        Volume { thickness_factor: 0.0, attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] }
    }
}
