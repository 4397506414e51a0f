//! Textures: images, samplers, and how materials use them.

use super::Index;
use super::enumeration::{Enumeration, Terms, listed};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;

/// A picture: a file, a data URI or a view of a buffer.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Image {
    pub name: Option<String>,
    pub uri: Option<String>,
    pub buffer_view: Option<Index>,
}

/// An image and how it is sampled.
#[derive(Debug, Deserialize)]
pub struct Texture {
    pub name: Option<String>,
    pub sampler: Option<Index>,
    /// The image. A texture whose picture is of another format may have one by an extension only.
    pub source: Option<Index>,
    /// Extensions by name: none is read, and those that stand for the image are named in a warning.
    pub extensions: Option<BTreeMap<String, IgnoredAny>>,
}

/// How an image is sampled. Filters for minification are not read: there are no mipmaps.
#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Sampler {
    #[serde(deserialize_with = "listed")]
    pub mag_filter: Option<MagFilter>,
    #[serde(deserialize_with = "listed")]
    pub wrap_s: Option<Wrap>,
    #[serde(deserialize_with = "listed")]
    pub wrap_t: Option<Wrap>,
}

impl Default for Sampler {
    fn default() -> Sampler {
        Sampler { mag_filter: None, wrap_s: Some(Wrap::Repeat), wrap_t: Some(Wrap::Repeat) }
    }
}

/// The filter for texels larger than pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MagFilter {
    Nearest,
    Linear,
}

impl Enumeration for MagFilter {
    const TERMS: Terms<MagFilter> = Terms::Codes(&[(9728, MagFilter::Nearest), (9729, MagFilter::Linear)]);
}

/// What is seen beyond the edges of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    ClampToEdge,
    MirroredRepeat,
    Repeat,
}

impl Enumeration for Wrap {
    const TERMS: Terms<Wrap> =
        Terms::Codes(&[(33_071, Wrap::ClampToEdge), (33_648, Wrap::MirroredRepeat), (10_497, Wrap::Repeat)]);
}

/// A texture as a material uses it.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureInfo {
    pub index: Index,
    /// The set of texture coordinates.
    #[serde(default)]
    pub tex_coord: u32,
    pub extensions: Option<TextureInfoExtensions>,
}

/// A texture of normals as a material uses it.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct NormalTexture {
    pub index: Index,
    /// The set of texture coordinates.
    #[serde(default)]
    pub tex_coord: u32,
    /// Multiplies x and y of the normals.
    #[serde(default = "one")]
    pub scale: f32,
    pub extensions: Option<TextureInfoExtensions>,
}

/// Extensions of a texture as a material uses it.
#[derive(Debug, Deserialize)]
pub struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub transform: Option<TextureTransform>,
}

/// KHR_texture_transform: texture coordinates are scaled, then turned, then moved.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct TextureTransform {
    pub offset: [f32; 2],
    /// In radians.
    pub rotation: f32,
    pub scale: [f32; 2],
    /// The set of texture coordinates, where it is another.
    pub tex_coord: Option<u32>,
}

impl Default for TextureTransform {
    fn default() -> TextureTransform {
        TextureTransform { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

fn one() -> f32 {
    1.0
}
