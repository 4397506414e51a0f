//! Colour textures, decoded.

use eosphor_core::texture::{TextureFilter, TextureWrap};

/// An 8-bit colour picture.
#[derive(Clone, Debug)]
pub struct Texture {
    /// For messages.
    pub name: String,
    /// Texels a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// R, G, B, A from the low byte up; top row first; `width * height` of them.
    pub texels: Vec<u32>,
    /// Between texels.
    pub filter: TextureFilter,
    /// Outside the unit square.
    pub wrap: TextureWrap,
}
