//! New shapes for the same primitives.

use super::emit::orders;
use super::{Bvh8, Child, EMPTY, INSTANCE, LEAF, PLACE, SPHERE, TriangleBlock, instance_bounds};
use crate::SceneGeometry;
use crate::bvh::{RefitError, check, union};
use eosphor_core::geometry::{Bounds, Geometry};
use eosphor_core::intersect::{PackedTriangle, sphere_bounds};
use eosphor_core::math::{Vec3, vec3};

impl Bvh8 {
    /// Takes new vertices, spheres and transforms for the primitives and instances that the hierarchy was built over: boxes are
    /// made anew from the leaves up, so hits are those of a hierarchy that was built over the new scene. The farther things have
    /// moved apart, the slower it gets; then build again.
    ///
    /// # Errors
    /// Where the scene has other numbers of primitives or instances than the one that was built over; nothing is
    /// changed then.
    pub fn refit(&mut self, scene: &SceneGeometry) -> Result<(), RefitError> {
        check(&self.geometries, &self.instances, scene)?;
        self.geometries.copy_from_slice(scene.geometries());
        self.instances.copy_from_slice(scene.instances());
        self.instance_bounds = instance_bounds(scene.instances());
        for (number, geometry) in scene.geometries().iter().enumerate() {
            let mut farthest = 0.0;
            self.bounds[number] = self.refit_tree(self.roots[number], Some(geometry), scene, &mut farthest);
            self.farthest[number] = farthest;
        }
        self.refit_tree(self.instance_root, None, scene, &mut 0.0);
        Ok(())
    }

    /// Parents are numbered before their children, so nodes are done in the opposite order. Returns the box around all.
    /// `farthest` grows by what is farthest in its blocks.
    fn refit_tree(
        &mut self,
        root: Child,
        geometry: Option<&Geometry>,
        scene: &SceneGeometry,
        farthest: &mut f32,
    ) -> Bounds {
        if root == EMPTY {
            return Bounds { min: Vec3::ZERO, max: Vec3::ZERO };
        }
        if root & LEAF != 0 {
            return self.refit_leaf(root, geometry, scene, farthest);
        }
        let (mut nodes, mut next) = (vec![root], 0);
        while next < nodes.len() {
            let children = self.nodes[nodes[next] as usize].children;
            nodes.extend(children.into_iter().filter(|c| c & LEAF == 0));
            next += 1;
        }
        for at in nodes.into_iter().rev() {
            for k in 0..8 {
                let child = self.nodes[at as usize].children[k];
                if child == EMPTY {
                    continue;
                }
                let b = if child & LEAF == 0 {
                    self.node_bounds(child)
                } else {
                    self.refit_leaf(child, geometry, scene, farthest)
                };
                let planes = &mut self.nodes[at as usize].planes;
                for axis in 0..3 {
                    planes[2 * axis][k] = b.min[axis];
                    planes[2 * axis + 1][k] = b.max[axis];
                }
            }
            let node = &mut self.nodes[at as usize];
            node.orders = orders(node);
        }
        self.node_bounds(root)
    }

    fn node_bounds(&self, at: Child) -> Bounds {
        let node = &self.nodes[at as usize];
        let p = &node.planes;
        // Boxes of empty children are inside out and add nothing.
        union(
            (0..8).map(|k| Bounds {
                min: vec3(p[0][k], p[2][k], p[4][k]),
                max: vec3(p[1][k], p[3][k], p[5][k]),
            }),
        )
    }

    fn refit_leaf(
        &mut self,
        leaf: Child,
        geometry: Option<&Geometry>,
        scene: &SceneGeometry,
        farthest: &mut f32,
    ) -> Bounds {
        let place = (leaf & PLACE) as usize;
        if leaf & INSTANCE != 0 {
            return scene.instances()[place].world_bounds;
        }
        let geometry = geometry.expect("instances have no primitives beside them");
        if leaf & SPHERE != 0 {
            let number = geometry.first_sphere + self.sphere_primitives[place] - geometry.triangle_count;
            self.spheres[place] = scene.spheres()[number as usize];
            return sphere_bounds(&self.spheres[place]);
        }
        let vertices = &scene.triangles()[geometry.first_triangle as usize..];
        let numbers = self.blocks[place].primitive;
        let block = &mut self.blocks[place];
        *block = TriangleBlock::EMPTY;
        union(numbers.into_iter().enumerate().filter(|(_, n)| *n != u32::MAX).map(|(lane, number)| {
            let triangle = PackedTriangle::new(vertices[number as usize], number);
            block.set(lane, &triangle);
            *farthest = farthest.max(super::blocks::farthest(&triangle));
            triangle.bounds()
        }))
    }
}
