//! Pictures and how surfaces read them.

use eosphor_core::texture::{TextureFilter, TextureWrap};

/// A decoded picture; several textures may read one.
#[derive(Clone, Debug)]
pub struct Image {
    /// For messages.
    pub name: String,
    /// Texels a row, 1 to 65,535.
    pub width: u32,
    /// Rows, 1 to 65,535.
    pub height: u32,
    /// `width * height` of them, top row first.
    pub texels: Texels,
}

/// The texels of a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// 8 bits a channel: R, G, B, A from the low byte up.
    Rgba8(Vec<u32>),
    /// Linear R, G, B, A, finite (HDR and EXR pictures).
    Float(Vec<[f32; 4]>),
}

impl Texels {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Texels::Rgba8(texels) => texels.len(),
            Texels::Float(texels) => texels.len(),
        }
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> u64 {
        match self {
            Texels::Rgba8(texels) => texels.len() as u64 * 4,
            Texels::Float(texels) => texels.len() as u64 * 16,
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A picture as a surface reads it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Into [`super::Scene::images`].
    pub image: u32,
    /// What its numbers are.
    pub content: TextureContent,
    /// Between texels.
    pub filter: TextureFilter,
    /// Outside the unit square, along u.
    pub wrap_u: TextureWrap,
    /// Outside the unit square, along v.
    pub wrap_v: TextureWrap,
    /// Which texture coordinates of the mesh it takes: 0 for [`super::Mesh::uvs`], 1 for [`super::Mesh::uvs1`].
    pub uv_set: u32,
    /// Takes the mesh's (u, v, 1) to the picture's (u, v), row by row. v runs up.
    pub picture_from_mesh_uv: [[f32; 3]; 2],
}

impl Texture {
    /// The map that changes nothing.
    pub const IDENTITY_UV: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    /// An image of colours read by the mesh's own coordinates, bilinear and repeated.
    pub fn of_image(image: u32) -> Texture {
        Texture {
            image,
            content: TextureContent::Color,
            filter: TextureFilter::Bilinear,
            wrap_u: TextureWrap::Repeat,
            wrap_v: TextureWrap::Repeat,
            uv_set: 0,
            picture_from_mesh_uv: Texture::IDENTITY_UV,
        }
    }
}

/// What the 8-bit numbers of a picture are; floats are always linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureContent {
    /// Colours: sRGB-coded, unless [`super::RenderSettings::srgb_textures`] is off.
    Color,
    /// Roughness, normals, opacity: linear always.
    Data,
}
