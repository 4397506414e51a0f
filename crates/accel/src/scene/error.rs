//! What cannot be part of a scene.

use super::{LARGEST_COORDINATE, MeshId};
use std::fmt;

/// Why something cannot be part of a [`Scene`](crate::Scene). Nothing was changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneError {
    /// A corner is not a number, or larger than [`LARGEST_COORDINATE`].
    Triangle(usize),
    /// The centre or the radius is out of range; a radius must be over 0.
    Sphere(usize),
    /// A face names a vertex that is not there.
    Face(usize),
    /// The transform is not finite, cannot be inverted, or takes the mesh out of range.
    Transform,
    /// There is no such mesh.
    Mesh(MeshId),
    /// There is no such instance, or it is the world (0) and was to be moved.
    Instance(u32),
    /// The mesh has another number of triangles or spheres than were given.
    Counts,
    /// More than 2^31 - 1 primitives or instances.
    TooMany,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            SceneError::Triangle(n) => {
                write!(f, "triangle {n} has a corner that is out of range: within {LARGEST_COORDINATE:e}, please")
            }
            SceneError::Sphere(n) => {
                write!(f, "sphere {n} is out of range: a radius over 0, all within {LARGEST_COORDINATE:e}, please")
            }
            SceneError::Face(n) => write!(f, "face {n} names a vertex that is not there"),
            SceneError::Transform => f.write_str(
                "the transform cannot be used: it must be finite and invertible (no scale of 0), and keep the mesh in range",
            ),
            SceneError::Mesh(MeshId(n)) => write!(f, "there is no mesh {n} in this scene"),
            SceneError::Instance(0) => f.write_str("instance 0 is the world, which does not move"),
            SceneError::Instance(n) => write!(f, "there is no instance {n}"),
            SceneError::Counts => {
                f.write_str("a mesh can be given new shapes for its primitives, not more or fewer of them")
            }
            SceneError::TooMany => f.write_str("more than 2^31 - 1 primitives or instances"),
        }
    }
}

impl std::error::Error for SceneError {}
