//! Geometry.

use super::{Deformation, Move, Transform};
use eosphor_core::math::Vec3;
use std::sync::Arc;

/// An index that says "none": a corner without normal or texture coordinate.
pub const NO_INDEX: u32 = u32::MAX;

/// A triangle mesh in its own space. Positions, normals and texture coordinates have indices of their own, as in OBJ.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name for messages.
    pub name: String,
    /// Positions of the vertices, in the mesh's own space.
    pub positions: Vec<Vec3>,
    /// Normals of the file, any length; empty when the file has none.
    pub normals: Vec<Vec3>,
    /// Texture coordinates (u right, v up); empty when the file has none.
    pub uvs: Vec<[f32; 2]>,
    /// A second set of texture coordinates, one for each position; empty where there is none.
    pub uvs1: Vec<[f32; 2]>,
    /// Linear colours (R, G, B and opacity) that multiply the material's, one for each position; empty where there are
    /// none.
    pub colors: Vec<[f32; 4]>,
    /// Triangles, in the file's order. Counter-clockwise seen from the front.
    pub triangles: Vec<Triangle>,
    /// What moves the vertices. Positions and normals are those of the first frame then.
    pub deformation: Option<Arc<Deformation>>,
}

/// Three corners and a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Indices of the three corners into [`Mesh::positions`].
    pub positions: [u32; 3],
    /// Indices of the corners into [`Mesh::normals`], or [`NO_INDEX`].
    pub normals: [u32; 3],
    /// Indices of the corners into [`Mesh::uvs`], or [`NO_INDEX`].
    pub uvs: [u32; 3],
    /// Index into [`super::Scene::materials`].
    pub material: u32,
}

/// A mesh placed in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// Index into [`super::Scene::meshes`].
    pub mesh: u32,
    /// Into [`super::Scene::materials`]; `None`: each triangle's own.
    pub material: Option<u32>,
    /// From the mesh to the world. If the instance moves, this is applied before the motions.
    pub world_from_object: Transform,
    /// Motions of the instance, applied one after the other, after the transform.
    pub moves: Vec<Arc<Move>>,
}

impl Instance {
    /// A mesh with its own materials.
    pub fn new(mesh: u32, world_from_object: Transform) -> Instance {
        Instance { mesh, material: None, world_from_object, moves: Vec::new() }
    }
}

/// A sphere in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub center: Vec3,
    /// Radius, over 0.
    pub radius: f32,
    /// Index into [`super::Scene::materials`].
    pub material: u32,
}

/// A parallelogram in world space: the corner, and the corner plus either edge, and plus both. Its front is where the
/// edges run counter-clockwise. Texture coordinates are (0, 0) at the corner and grow to 1 along the edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parallelogram {
    /// One corner.
    pub corner: Vec3,
    /// From the corner along u.
    pub edge_u: Vec3,
    /// From the corner along v.
    pub edge_v: Vec3,
    /// Index into [`super::Scene::materials`].
    pub material: u32,
}
