//! Materials in JSON: one kind and, beside it, textures and what opacity does.

use super::schema::lift_kinds;
use super::texture::{ChannelTextureEntry, TextureEntry};
use crate::model::{AlphaMode, MaterialKind};
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use std::fmt;
use std::marker::PhantomData;

/// A material: one kind and, beside it, textures and what opacity does.
// Flattening would let unknown keys pass and lose the places of errors; both are looked at before (`check.rs`).
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "Material", transform = lift_kinds, extend("examples" = [
    { "matte": { "color": [1, 1, 1] }, "texture": "wood.png" },
    {
        "pbr": { "roughness": 0.6 },
        "textures": { "color": "leaf.png", "opacity": "leaf.png" },
        "alpha": { "mask": { "cutoff": 0.5 } }
    }
]))]
pub(super) struct MaterialEntry {
    #[serde(flatten)]
    pub(super) kind: MaterialKind,
    /// The same as `color` of `textures`.
    #[serde(default)]
    pub(super) texture: Option<TextureEntry>,
    /// Pictures that vary the material over the surface.
    #[serde(default)]
    pub(super) textures: TextureSlots,
    /// How rough the ground is that scatters light to all sides, by the model EON: 0 is Lambert's, 1 that of clay and dust, whose
    /// rim is about as bright as its middle where the light comes from the viewer. Over 0 it needs `"integrator": "path"` and a
    /// kind that has a ground: not `mirror`, `dielectric`, `emissive`.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1))]
    pub(super) diffuse_roughness: f32,
    /// What opacity does.
    #[serde(default)]
    pub(super) alpha: AlphaMode,
}

/// Pictures that vary a material over the surface; each multiplies what it is named after.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
#[schemars(rename = "Textures", extend("examples" = [
    { "color": "leaf.png", "normal": { "file": "bumps.png", "scale": [4, 4] }, "normal-scale": 0.5 }
]))]
pub(super) struct TextureSlots {
    /// The diffuse or base colour.
    #[serde(alias = "colour")]
    pub(super) color: Option<TextureEntry>,
    /// The opacity, from the channel `alpha` where none is given. It counts where `alpha` of the material is not
    /// `opaque`.
    pub(super) opacity: Option<ChannelTextureEntry>,
    /// The highlight's colour (`Ks`) of materials of the kind `mtl`.
    pub(super) specular: Option<TextureEntry>,
    /// The radiance that leaves the surface by itself.
    pub(super) emission: Option<TextureEntry>,
    /// `metallic` of the kind `pbr`, from the channel `blue` where none is given.
    pub(super) metallic: Option<ChannelTextureEntry>,
    /// `roughness` of the kind `pbr`, from the channel `green` where none is given.
    pub(super) roughness: Option<ChannelTextureEntry>,
    /// `transmission` of the kind `pbr`, from the channel `red` where none is given.
    pub(super) transmission: Option<ChannelTextureEntry>,
    /// Normals in tangent space: red, green and blue from 0..1 to -1..1 are x along u, y along v (up), z off the
    /// surface.
    pub(super) normal: Option<TextureEntry>,
    /// Multiplies x and y of these normals.
    #[schemars(range(min = -1_000_000, max = 1_000_000))]
    pub(super) normal_scale: f32,
}

impl Default for TextureSlots {
    fn default() -> TextureSlots {
        TextureSlots {
            color: None,
            opacity: None,
            specular: None,
            emission: None,
            metallic: None,
            roughness: None,
            transmission: None,
            normal: None,
            normal_scale: 1.0,
        }
    }
}

/// A JSON object as a list in the file's order.
pub(super) struct Entries<T>(pub(super) Vec<(String, T)>);

impl<T> Default for Entries<T> {
    fn default() -> Entries<T> {
        Entries(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Entries<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Entries<T>, D::Error> {
        struct List<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for List<T> {
            type Value = Entries<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object of names and values")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Entries<T>, A::Error> {
                let mut list: Vec<(String, T)> = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    list.push(entry);
                }
                Ok(Entries(list))
            }
        }
        deserializer.deserialize_map(List(PhantomData))
    }
}
