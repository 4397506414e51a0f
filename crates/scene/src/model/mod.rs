//! The scene model: what people write.

use eosphor_core::math::Vec3;

mod camera;
mod ior;
mod light;
mod material;
mod mesh;
mod settings;
mod texture;
mod transform;
mod validate;

pub use camera::{Camera, Lens};
pub use ior::{INDICES_OF_REFRACTION, index_of_refraction};
pub use light::Light;
pub use material::{Material, MaterialKind, Mtl};
pub use mesh::{Instance, Mesh, NO_INDEX, Parallelogram, Sphere, Triangle};
pub use settings::{Composition, NormalMode, PixelSampling, RenderSettings, Transfer};
pub use texture::Texture;
pub use transform::Transform;
pub(crate) use validate::MAX_COORDINATE;

/// A scene: geometry, what it looks like, light, a camera and how to render it.
#[derive(Clone, Debug, Default)]
pub struct Scene {
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
    /// Colour textures; materials name them by number.
    pub textures: Vec<Texture>,
    /// Lights besides the emissive triangles.
    pub lights: Vec<Light>,
    /// Where the picture is taken from; `None` frames the whole scene.
    pub camera: Option<Camera>,
    /// How to render it.
    pub settings: RenderSettings,
}

impl Scene {
    /// Whether a placed triangle or parallelogram shines by itself.
    pub fn has_emissive_triangles(&self) -> bool {
        let shines = |m: u32| self.materials.get(m as usize).is_some_and(|m| m.emission() != Vec3::ZERO);
        let in_mesh = |i: &Instance| self.meshes.get(i.mesh as usize);
        self.parallelograms.iter().any(|p| shines(p.material))
            || self
                .instances
                .iter()
                .filter_map(in_mesh)
                .any(|m| m.triangles.iter().any(|t| shines(t.material)))
    }
}
