//! Meshes and their primitives.

use super::Index;
use super::enumeration::{Enumeration, Terms, listed};
use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

/// A mesh is a list of primitives.
#[derive(Debug, Deserialize)]
pub struct Mesh {
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
    /// How much of each morph target is added, where a node does not say.
    pub weights: Option<Vec<f32>>,
}

impl Mesh {
    /// How many morph targets it has.
    pub fn target_count(&self) -> usize {
        self.primitives.iter().filter_map(|p| p.targets.as_ref()).map(Vec::len).max().unwrap_or(0)
    }
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
#[derive(Debug, Default)]
pub struct Attributes {
    pub position: Option<Index>,
    pub normal: Option<Index>,
    pub tex_coord_0: Option<Index>,
    pub tex_coord_1: Option<Index>,
    pub color_0: Option<Index>,
    /// JOINTS_n by n.
    pub joints: BTreeMap<u32, Index>,
    /// WEIGHTS_n by n.
    pub weights: BTreeMap<u32, Index>,
}

impl<'de> Deserialize<'de> for Attributes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Attributes, D::Error> {
        struct ByName;
        impl<'de> Visitor<'de> for ByName {
            type Value = Attributes;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("struct Attributes")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Attributes, A::Error> {
                let mut all = Attributes::default();
                while let Some(name) = map.next_key::<Cow<'de, str>>()? {
                    let set = |prefix: &str| name.strip_prefix(prefix)?.parse::<u32>().ok();
                    match &*name {
                        "POSITION" => all.position = map.next_value()?,
                        "NORMAL" => all.normal = map.next_value()?,
                        "TEXCOORD_0" => all.tex_coord_0 = map.next_value()?,
                        "TEXCOORD_1" => all.tex_coord_1 = map.next_value()?,
                        "COLOR_0" => all.color_0 = map.next_value()?,
                        _ => {
                            let sets = match (set("JOINTS_"), set("WEIGHTS_")) {
                                (Some(n), _) => Some((n, &mut all.joints)),
                                (_, Some(n)) => Some((n, &mut all.weights)),
                                _ => None,
                            };
                            match sets {
                                Some((n, sets)) => {
                                    sets.extend(map.next_value::<Option<Index>>()?.map(|i| (n, i)))
                                }
                                None => drop(map.next_value::<IgnoredAny>()?),
                            }
                        }
                    }
                }
                Ok(all)
            }
        }
        deserializer.deserialize_map(ByName)
    }
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
