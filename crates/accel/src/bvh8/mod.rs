//! Bounding volume hierarchy with eight children a node, for SIMD on the CPU.

mod collapse;
mod node;
mod trace;

pub use node::{Child, EMPTY, INSTANCE, LEAF, Node8, PLACE, SPHERE, TriangleBlock};
pub use trace::Bvh8Tracer;

use crate::{BuildOptions, Bvh, SceneGeometry};
use eosphor_core::geometry::{Geometry, Instance, Sphere};
use std::time::Instant;

/// Trees over every geometry and one over the instances.
#[derive(Clone, Debug)]
pub struct Bvh8 {
    /// Nodes of all trees.
    pub nodes: Vec<Node8>,
    /// Leaves of triangles.
    pub blocks: Vec<TriangleBlock>,
    /// Spheres of all geometries, each one leaf.
    pub spheres: Vec<Sphere>,
    /// For each sphere, its number in its geometry.
    pub sphere_primitives: Vec<u32>,
    /// For each geometry, its root: a node, a leaf or [`EMPTY`].
    pub roots: Vec<Child>,
    /// Root of the tree over the instances but the world.
    pub instance_root: Child,
    /// Ranges of primitives in the scene.
    pub geometries: Vec<Geometry>,
    /// Placed geometries.
    pub instances: Vec<Instance>,
    /// The largest absolute coordinate of the instances' world boxes.
    pub instances_extent: f32,
    /// Wall time of the build.
    pub build_seconds: f64,
}

impl Bvh8 {
    /// Builds over a scene, on the threads of the current rayon pool. The result does not depend on their number.
    pub fn build(scene: &SceneGeometry, options: &BuildOptions) -> Bvh8 {
        let start = Instant::now();
        let bvh = Bvh::build(scene, options);
        let mut bvh8 = collapse::collapse(&bvh);
        let placed = scene.instances.iter().skip(1).map(|i| i.world_bounds.extent());
        bvh8.instances_extent = placed.fold(0.0, f32::max);
        bvh8.build_seconds = start.elapsed().as_secs_f64();
        bvh8
    }
}
