//! A whole scene, borrowed: what shading reads.

use crate::camera::Camera;
use crate::geometry::{Geometry, Instance, Sphere, TriangleExtra, TriangleShading};
use crate::light::Light;
use crate::material::Material;
use crate::math::Vec3;
use crate::settings::Settings;
use crate::texture::Textures;

/// Borrowed arrays of a scene, in the scene's own order (hierarchies have their own copies in theirs).
///
/// The numbers in these arrays must hold together, as those of eosphor-scene's `SceneData` do (`SceneData::check`): shading
/// panics where one leads nowhere.
#[derive(Clone, Copy, Debug)]
pub struct SceneView<'a> {
    /// Vertices of all triangles.
    pub triangles: &'a [[Vec3; 3]],
    /// All spheres.
    pub spheres: &'a [Sphere],
    /// Ranges of the above.
    pub geometries: &'a [Geometry],
    /// Placed geometries; number 0 is the world.
    pub instances: &'a [Instance],
    /// For each triangle.
    pub triangle_shading: &'a [TriangleShading],
    /// Of the triangles that have one.
    pub triangle_extras: &'a [TriangleExtra],
    /// For each sphere, the number of its material.
    pub sphere_materials: &'a [u32],
    /// Materials.
    pub materials: &'a [Material],
    /// Textures.
    pub textures: Textures<'a>,
    /// Lights.
    pub lights: &'a [Light],
    /// The camera.
    pub camera: &'a Camera,
    /// Settings.
    pub settings: &'a Settings,
}

/// An item of a scene's array.
///
/// # Panics
/// Where there is none of this number. (Not on GPUs, whose arrays have no length of their own.)
#[inline(always)]
pub(crate) fn item<T>(items: &[T], index: u32) -> &T {
    &items[index as usize]
}
