//! Bounding volume hierarchy with two children a node.

mod build;
mod sah;

pub use build::BuildOptions;
pub(crate) use build::build_tree;

use crate::{HierarchyStatistics, PackedPrimitives, SceneGeometry};
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::{BvhNode, BvhTracer, BvhView, Work};
use std::time::Instant;

/// Trees over every geometry and one over the instances, in the arrays that devices read.
#[derive(Clone, Debug)]
pub struct Bvh {
    /// Nodes of all trees.
    pub nodes: Vec<BvhNode>,
    /// For each geometry, the number of its root.
    pub roots: Vec<u32>,
    /// Root of the tree over the instances but the world.
    pub instance_root: u32,
    /// Numbers of instances, in the order of its leaves.
    pub instance_order: Vec<u32>,
    /// Primitives, in the order of the leaves.
    pub primitives: PackedPrimitives,
    /// Wall time of the build.
    pub build_seconds: f64,
}

impl Bvh {
    /// Builds over a scene, on the threads of the current rayon pool. The result does not depend on their number.
    pub fn build(scene: &SceneGeometry, options: &BuildOptions) -> Bvh {
        let start = Instant::now();
        let mut bvh = Bvh {
            nodes: Vec::new(),
            roots: Vec::new(),
            instance_root: 0,
            instance_order: Vec::new(),
            primitives: PackedPrimitives::new(scene),
            build_seconds: 0.0,
        };
        for geometry in scene.geometries {
            let root = bvh.add_geometry(geometry, options);
            bvh.roots.push(root);
        }
        bvh.add_instances(scene, options);
        bvh.build_seconds = start.elapsed().as_secs_f64();
        bvh
    }

    /// Borrowed, for traversals and devices.
    pub fn view(&self) -> BvhView<'_> {
        BvhView {
            nodes: &self.nodes,
            roots: &self.roots,
            instance_root: self.instance_root,
            instance_order: &self.instance_order,
            primitives: self.primitives.view(),
        }
    }

    /// The scalar traversal.
    pub fn tracer<C: Work>(&self, work: C) -> BvhTracer<'_, C> {
        BvhTracer { bvh: self.view(), work }
    }

    /// The hierarchy in numbers, all trees together.
    pub fn statistics(&self) -> HierarchyStatistics {
        let mut roots = self.roots.clone();
        if !self.instance_order.is_empty() {
            roots.push(self.instance_root);
        }
        HierarchyStatistics::of_bvh(self, &roots)
    }

    fn add_geometry(&mut self, geometry: &eosphor_core::geometry::Geometry, options: &BuildOptions) -> u32 {
        let mut bounds = self.primitives.triangle_bounds(geometry);
        bounds.extend(self.primitives.sphere_bounds(geometry));
        let (first_triangle, first_sphere) =
            (geometry.first_triangle as usize, geometry.first_sphere as usize);
        let triangle_count = geometry.triangle_count;
        let tree = build::build_tree(&bounds, triangle_count, options);
        let root = self.append(&tree.nodes, geometry.first_triangle, geometry.first_sphere);

        // Primitives into the order of the leaves.
        let triangles: Vec<_> = tree
            .triangle_order
            .iter()
            .map(|&i| self.primitives.triangles[first_triangle + i as usize])
            .collect();
        self.primitives.triangles[first_triangle..][..triangles.len()].copy_from_slice(&triangles);
        let spheres: Vec<_> = tree
            .sphere_order
            .iter()
            .map(|&i| {
                let at = first_sphere + (i - triangle_count) as usize;
                (self.primitives.spheres[at], self.primitives.sphere_primitives[at])
            })
            .collect();
        for (k, (sphere, primitive)) in spheres.into_iter().enumerate() {
            self.primitives.spheres[first_sphere + k] = sphere;
            self.primitives.sphere_primitives[first_sphere + k] = primitive;
        }
        root
    }

    fn add_instances(&mut self, scene: &SceneGeometry, options: &BuildOptions) {
        let bounds: Vec<Bounds> = scene.instances.iter().skip(1).map(|i| i.world_bounds).collect();
        // To the tree, instances are what triangles are to the others.
        let tree = build::build_tree(&bounds, bounds.len() as u32, options);
        self.instance_root = self.append(&tree.nodes, 0, 0);
        self.instance_order = tree.triangle_order.iter().map(|i| i + 1).collect();
    }

    /// Appends the nodes of a tree; returns the number of its root.
    fn append(&mut self, nodes: &[BvhNode], first_triangle: u32, first_sphere: u32) -> u32 {
        let base = self.nodes.len() as u32;
        self.nodes.extend(nodes.iter().map(|node| {
            let shift = if node.is_inner() {
                base
            } else if node.count & BvhNode::SPHERES != 0 {
                first_sphere
            } else {
                first_triangle
            };
            BvhNode { first: node.first + shift, ..*node }
        }));
        base
    }
}
