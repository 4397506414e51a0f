//! What surface points hold of their material.

use super::MaterialTexels;
use crate::material::Material;
use crate::texture::Rgba;

/// What a material's numbers become at a point: each integrator has its form.
pub trait MaterialValues: Copy {
    /// What `material` is where its textures say this and the vertex colour is `color`.
    fn new(material: &Material, texels: &MaterialTexels, color: &Rgba) -> Self;

    /// The share of the surface that is there.
    fn opacity(&self) -> f32;
}
