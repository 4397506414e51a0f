//! Scenes and the trees of nodes that they show.

use super::Index;
use serde::Deserialize;

/// A scene shows nodes and all that is below them.
#[derive(Debug, Deserialize)]
pub struct Scene {
    /// The roots of the trees.
    #[serde(default)]
    pub nodes: Vec<Index>,
}

/// A node places what it has and its children.
#[derive(Debug, Default, Deserialize)]
pub struct Node {
    pub name: Option<String>,
    pub children: Option<Vec<Index>>,
    /// Column after column; a node has either a matrix or the three parts below.
    pub matrix: Option<[f32; 16]>,
    pub translation: Option<[f32; 3]>,
    /// A quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    pub scale: Option<[f32; 3]>,
    pub mesh: Option<Index>,
    pub camera: Option<Index>,
    pub skin: Option<Index>,
    /// How much of each morph target of the mesh is added.
    pub weights: Option<Vec<f32>>,
    pub extensions: Option<NodeExtensions>,
}

impl Node {
    /// The number of its light of KHR_lights_punctual.
    pub fn light(&self) -> Option<Index> {
        Some(self.extensions.as_ref()?.light.as_ref()?.light)
    }

    /// Where EXT_mesh_gpu_instancing places its mesh.
    pub fn instancing(&self) -> Option<&Instancing> {
        self.extensions.as_ref()?.instancing.as_ref()
    }
}

/// Extensions of a node.
#[derive(Debug, Deserialize)]
pub struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    light: Option<NodeLight>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    instancing: Option<Instancing>,
}

#[derive(Debug, Deserialize)]
struct NodeLight {
    light: Index,
}

/// EXT_mesh_gpu_instancing: the mesh of the node is placed many times.
#[derive(Debug, Deserialize)]
pub struct Instancing {
    pub attributes: Option<InstanceAttributes>,
}

/// The accessors of the placements.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "SCREAMING_SNAKE_CASE")]
pub struct InstanceAttributes {
    pub translation: Option<Index>,
    pub rotation: Option<Index>,
    pub scale: Option<Index>,
}
