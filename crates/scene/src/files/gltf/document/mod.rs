//! The JSON of a glTF file: of the objects of the specification those members that are read, by their names there.
//!
//! Members that are not here are passed over, whatever they hold. Missing members have the defaults of the
//! specification. Indices and sizes are as the file has them: they are checked where they are used. `serde_json` limits
//! the depth of what is read, and passes over the rest without recursion.

mod accessor;
mod animation;
mod buffer;
mod camera;
mod enumeration;
mod index;
mod light;
mod material;
mod mesh;
mod node;
mod skin;
mod texture;

pub use accessor::{Accessor, ComponentType, ElementType, Sparse};
pub use animation::{Animation, AnimationSampler, Channel, Interpolation, Property};
pub use buffer::{Buffer, BufferView};
pub use camera::{Camera, CameraType};
pub use index::Index;
pub use light::{Light, LightType};
pub use material::{AlphaMode, Material, MaterialExtensions, PbrMetallicRoughness, SpecularGlossiness};
pub use mesh::{Attributes, Mesh, Mode, Primitive};
pub use node::{Node, Scene};
pub use skin::Skin;
pub use texture::{Image, MagFilter, NormalTexture, Sampler, Texture, TextureInfo, TextureTransform, Wrap};

use light::Lights;
use serde::Deserialize;

/// A file of glTF 2.0: arrays of items that refer to each other by [`Index`].
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Document {
    pub asset: Asset,
    /// The scene to show.
    pub scene: Option<Index>,
    #[serde(default)]
    pub extensions_used: Vec<String>,
    #[serde(default)]
    pub extensions_required: Vec<String>,
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    #[serde(default)]
    pub animations: Vec<Animation>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
    #[serde(default)]
    pub buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub cameras: Vec<Camera>,
    #[serde(default)]
    pub images: Vec<Image>,
    #[serde(default)]
    pub materials: Vec<Material>,
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub samplers: Vec<Sampler>,
    #[serde(default)]
    pub scenes: Vec<Scene>,
    #[serde(default)]
    pub skins: Vec<Skin>,
    #[serde(default)]
    pub textures: Vec<Texture>,
    pub extensions: Option<DocumentExtensions>,
}

impl Document {
    pub fn from_slice(json: &[u8]) -> Result<Document, serde_json::Error> {
        serde_json::from_slice(json)
    }

    /// The lights of KHR_lights_punctual.
    pub fn lights(&self) -> &[Light] {
        let lights = self.extensions.as_ref().and_then(|extensions| extensions.lights.as_ref());
        lights.map_or(&[], |extension| &extension.lights)
    }
}

/// What the file says of itself.
#[derive(Debug, Deserialize)]
pub struct Asset {
    /// The version of glTF, as `2.0`.
    pub version: String,
}

/// Extensions of the whole file.
#[derive(Debug, Deserialize)]
pub struct DocumentExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    lights: Option<Lights>,
}
