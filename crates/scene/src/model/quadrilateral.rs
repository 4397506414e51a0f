//! Surfaces of four corners.

use super::{Instance, Mesh, NO_INDEX, Parallelogram, Scene, Transform, Triangle};
use eosphor_core::math::Vec3;

/// Corners one after the other around a surface, and its material. Texture coordinates are (0, 0) at the first corner,
/// (0, 1) at the second, (1, 1) at the third and (1, 0) at the fourth; seen from the front they run clockwise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quadrilateral {
    pub(crate) corners: [Vec3; 4],
    /// Into [`Scene::materials`].
    pub(crate) material: u32,
}

impl Quadrilateral {
    /// Puts it into a scene: a parallelogram where it is one, else a mesh.
    pub(crate) fn add_to(&self, scene: &mut Scene) {
        let [a, b, c, d] = self.corners;
        let (edge_u, edge_v) = (d - a, b - a);
        match b + edge_u == c {
            true => {
                let parallelogram = Parallelogram { corner: a, edge_u, edge_v, material: self.material };
                scene.parallelograms.push(parallelogram);
            }
            false => self.add_mesh(scene, Transform::default()),
        }
    }

    /// Puts it into a scene as a mesh of two triangles.
    pub(crate) fn add_mesh(&self, scene: &mut Scene, world_from_object: Transform) {
        let triangle = |corners: [u32; 3]| Triangle {
            positions: corners,
            normals: [NO_INDEX; 3],
            uvs: corners,
            material: self.material,
        };
        scene.meshes.push(Mesh {
            name: "quadrilateral".into(),
            positions: self.corners.to_vec(),
            uvs: vec![[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]],
            triangles: vec![triangle([0, 3, 2]), triangle([0, 2, 1])],
            ..Mesh::default()
        });
        scene.instances.push(Instance::new(scene.meshes.len() as u32 - 1, world_from_object));
    }
}
