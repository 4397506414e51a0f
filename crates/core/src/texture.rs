//! Colour textures.

use crate::math::{Vec3, floor, fma, vec3};

/// How a colour is read between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[repr(u32)]
pub enum TextureFilter {
    /// The texel that holds the point.
    Nearest,
    /// Between the four texels whose centres surround the point.
    Bilinear,
}

/// What lies outside the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[repr(u32)]
pub enum TextureWrap {
    /// The texel at the border.
    Clamp,
    /// The texture again.
    Repeat,
}

/// Where a texture lies in the array of texels and how it is read. `u` runs right and `v` runs up: `(0, 0)` is the
/// lower left corner of the picture, as in OBJ; rows are stored top first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Texture {
    /// Number of the first texel.
    pub first_texel: u32,
    /// Texels a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Between texels.
    pub filter: TextureFilter,
    /// Outside the unit square.
    pub wrap: TextureWrap,
    /// Texel bytes are sRGB-coded; otherwise they are linear.
    pub srgb: bool,
}

/// Textures, their texels (8-bit R, G, B, A from the low byte up) and the sRGB decoding table.
#[derive(Clone, Copy, Debug)]
pub struct Textures<'a> {
    /// Headers.
    pub textures: &'a [Texture],
    /// All texels.
    pub texels: &'a [u32],
    /// Linear value of each sRGB byte.
    pub srgb_decode: &'a [f32; 256],
}
