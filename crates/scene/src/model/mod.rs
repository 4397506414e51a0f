//! The scene model: what people write.

use eosphor_core::math::Vec3;

mod animation;
mod camera;
mod deformation;
mod device;
mod environment;
mod interpolation;
mod ior;
mod light;
mod material;
mod matrix;
mod mesh;
mod moves;
pub(crate) mod origin;
mod pbr;
mod quadrilateral;
mod schema_types;
mod settings;
mod shift;
mod sky;
mod texture;
mod transform;
mod validate;

pub use animation::{Animation, CameraKey, CameraMotion, Law, LightKey, LightMotion, MAX_FRAMES};
pub use camera::{Camera, Lens};
pub use deformation::Deformation;
pub(crate) use deformation::{
    Joint, Morph, MorphBlock, MorphTarget, Poses, Skeleton, SkeletonLink, Skin, SkinnedVertices,
    WeightInterpolation, WeightTrack,
};
pub use device::{DeviceKind, DeviceSettings, Structure, TreeBuilder};
pub use environment::{EnvironmentMap, EnvironmentSource};
pub use interpolation::Interpolation;
pub use ior::{INDICES_OF_REFRACTION, index_of_refraction};
pub use light::Light;
pub(crate) use light::LightParts;
pub use material::{AlphaMode, Channel, Material, MaterialKind, MaterialTextures, Mtl, TextureChannel};
pub(crate) use matrix::Matrix;
pub use mesh::{Instance, Mesh, NO_INDEX, Parallelogram, Sphere, Triangle};
pub use moves::{Move, MoveKey};
pub use pbr::Pbr;
pub(crate) use quadrilateral::Quadrilateral;
pub(crate) use schema_types::Vector;
pub use settings::{Composition, LightSelection, LightUnits, NormalMode, PixelSampling, RenderSettings};
pub use sky::Sky;
pub(crate) use texture::share_words;
pub use texture::{Image, TexelLayout, Texels, Texture, TextureContent};
pub use transform::Transform;
pub(crate) use transform::{ExactTransform, add, double, single};
pub(crate) use validate::MAX_COORDINATE;

/// A scene: geometry, what it looks like, light, a camera and how to render it.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Where coordinates are counted from, in those of the file: 0, but for scenes so far from there that single precision
    /// would lose their digits ([`Scene::settle_origin`]).
    pub origin: [f64; 3],
    /// Triangle meshes, each in its own space. A mesh is seen only where an instance places it.
    pub meshes: Vec<Mesh>,
    /// Placed meshes.
    pub instances: Vec<Instance>,
    /// Spheres, in world space.
    pub spheres: Vec<Sphere>,
    /// Parallelograms, in world space.
    pub parallelograms: Vec<Parallelogram>,
    /// Materials; meshes and spheres name them by number.
    pub materials: Vec<Material>,
    /// Pictures; textures name them by number.
    pub images: Vec<Image>,
    /// Pictures as surfaces read them; materials name them by number.
    pub textures: Vec<Texture>,
    /// Lights besides the emissive triangles.
    pub lights: Vec<Light>,
    /// What surrounds everything, if it is a picture or a sky.
    pub environment: Option<EnvironmentMap>,
    /// Where the picture is taken from; where there is none, flattening chooses a camera that shows what is there.
    pub camera: Option<Camera>,
    /// Settings of the render.
    pub settings: RenderSettings,
    /// What moves; nothing where there is none.
    pub animation: Option<Animation>,
    /// The frame of the animation that a single picture shows, from 0.
    pub frame: u32,
    /// The device and the hierarchy that the scene asks to be rendered with.
    pub device: DeviceSettings,
    /// The file that it asks to be rendered into, as it names it.
    pub output: Option<String>,
}

impl Scene {
    /// Whether a placed triangle or parallelogram shines by itself.
    pub fn has_emissive_triangles(&self) -> bool {
        let shines = |m: u32| self.materials.get(m as usize).is_some_and(|m| m.emission() != Vec3::ZERO);
        let placed_shines = |i: &Instance| match (i.material, self.meshes.get(i.mesh as usize)) {
            (_, None) => false,
            (Some(m), Some(mesh)) => !mesh.triangles.is_empty() && shines(m),
            (None, Some(mesh)) => mesh.triangles.iter().any(|t| shines(t.material)),
        };
        self.parallelograms.iter().any(|p| shines(p.material)) || self.instances.iter().any(placed_shines)
    }
}
