//! Meshes and their primitives.

use super::Index;
use super::enumeration::{Enumeration, Terms, listed};
use serde::Deserialize;
use serde::de::IgnoredAny;

/// A mesh is a list of primitives.
#[derive(Debug, Deserialize)]
pub struct Mesh {
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
    /// How much of each morph target is added, where a node does not say.
    pub weights: Option<Vec<f32>>,
}

/// A part of a mesh in one material.
#[derive(Debug, Deserialize)]
pub struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<Index>,
    pub material: Option<Index>,
    #[serde(default = "Mode::triangles", deserialize_with = "listed")]
    pub mode: Option<Mode>,
    pub targets: Option<Vec<MorphTarget>>,
    pub extensions: Option<PrimitiveExtensions>,
}

/// The accessors of the vertices, by what they hold.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "SCREAMING_SNAKE_CASE")]
pub struct Attributes {
    pub position: Option<Index>,
    pub normal: Option<Index>,
    #[serde(rename = "TEXCOORD_0")]
    pub tex_coord_0: Option<Index>,
    #[serde(rename = "TEXCOORD_1")]
    pub tex_coord_1: Option<Index>,
    pub color_0: Option<Index>,
}

/// The accessors of what a morph target adds to the vertices.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "SCREAMING_SNAKE_CASE")]
pub struct MorphTarget {
    pub position: Option<Index>,
    pub normal: Option<Index>,
}

/// Extensions of a primitive.
#[derive(Debug, Deserialize)]
pub struct PrimitiveExtensions {
    /// It is not read, but told from data that are missing.
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<IgnoredAny>,
}

/// How vertices are joined to points, lines or triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mode {
    Points,
    Lines,
    LineLoop,
    LineStrip,
    Triangles,
    TriangleStrip,
    TriangleFan,
}

impl Mode {
    fn triangles() -> Option<Mode> {
        Some(Mode::Triangles)
    }
}

impl Enumeration for Mode {
    const TERMS: Terms<Mode> = Terms::Codes(&[
        (0, Mode::Points),
        (1, Mode::Lines),
        (2, Mode::LineLoop),
        (3, Mode::LineStrip),
        (4, Mode::Triangles),
        (5, Mode::TriangleStrip),
        (6, Mode::TriangleFan),
    ]);
}
