//! Bounding volume hierarchy with eight children a node, for SIMD on the CPU.

mod blocks;
mod collapse;
mod emit;
mod morton;
mod node;
mod refit;
mod statistics;
mod trace;
mod view;

pub use node::{Child, EMPTY, INSTANCE, LEAF, Node8, PLACE, SPHERE, TriangleBlock};
pub use trace::{Bvh8CountingTracer, Bvh8Tracer, MaskedTracer};

use crate::bvh::{Purpose, RefitError, check_before, geometry_tree, instance_tree, room_for};
use crate::{BuildOptions, Builder, SceneGeometry};
use collapse::Cut;
use emit::Contents;
use eosphor_core::geometry::{Bounds, Geometry, Instance, Sphere};
use std::time::Instant;

/// A bounding volume hierarchy with eight children a node, for SIMD on the CPU: the fastest structure of this crate. It has a tree
/// over every geometry and one over the instances.
#[derive(Clone, Debug)]
pub struct Bvh8 {
    /// Nodes of all trees.
    nodes: Vec<Node8>,
    /// Leaves of triangles.
    blocks: Vec<TriangleBlock>,
    /// Spheres of all geometries, each one leaf.
    spheres: Vec<Sphere>,
    /// For each sphere, its number in its geometry.
    sphere_primitives: Vec<u32>,
    /// For each geometry, its root: a node, a leaf or [`EMPTY`].
    roots: Vec<Child>,
    /// How many nodes, blocks and spheres there are before those of each geometry, and of the tree over the instances.
    starts: Vec<[usize; 3]>,
    /// For each geometry, how far a first vertex is from 0 (the sum of its coordinates' sizes), together with the lengths of
    /// its two edges: the largest of all triangles.
    farthest: Vec<f32>,
    /// Root of the tree over the instances but the world.
    instance_root: Child,
    /// Ranges of primitives in the scene.
    geometries: Vec<Geometry>,
    /// Placed geometries.
    instances: Vec<Instance>,
    /// For each geometry, the box around it.
    bounds: Vec<Bounds>,
    /// The box around what instances place.
    instance_bounds: Bounds,
    /// How many geometries instances name: one more than the largest number of one.
    named_geometries: usize,
    /// What chose the splits when it was built.
    pub builder: Builder,
    /// Wall time of the build, in seconds.
    pub build_seconds: f64,
}

impl Bvh8 {
    /// Builds a hierarchy over a scene, on the threads of the current rayon pool. The result does not depend on their number.
    pub fn build(scene: &SceneGeometry, options: &BuildOptions) -> Bvh8 {
        let start = Instant::now();
        let cuts: Vec<Cut> =
            scene.geometries().iter().map(|g| Bvh8::cut_geometry(scene, g, options)).collect();
        let instances = Cut::best(instance_tree(scene, options, Purpose::Eight));
        let nodes = cuts.iter().map(|c| c.wide.len()).sum::<usize>() + instances.wide.len();
        assert!(nodes < LEAF as usize, "more nodes than can be numbered");
        // The blocks of a single geometry stay where they were packed.
        let block_room = if let [only] = &cuts[..]
            && !only.blocks.is_empty()
        {
            0
        } else {
            cuts.iter().map(Cut::block_count).sum()
        };
        let mut bvh8 = Bvh8 {
            nodes: room_for(nodes),
            blocks: room_for(block_room),
            spheres: Vec::with_capacity(scene.spheres().len()),
            sphere_primitives: Vec::with_capacity(scene.spheres().len()),
            roots: Vec::with_capacity(cuts.len()),
            starts: Vec::with_capacity(cuts.len() + 1),
            farthest: Vec::with_capacity(scene.geometries().len()),
            instance_root: EMPTY,
            geometries: scene.geometries().to_vec(),
            instances: scene.instances().to_vec(),
            bounds: Vec::with_capacity(cuts.len()),
            instance_bounds: instance_bounds(scene.instances()),
            named_geometries: scene.named_geometries(),
            builder: options.builder,
            build_seconds: 0.0,
        };
        bvh8.emit(cuts, instances, scene, 0);
        bvh8.build_seconds = start.elapsed().as_secs_f64();
        bvh8
    }

    /// Builds the trees of the geometries from number `first` on anew, and that over the instances. The result is what
    /// [`Bvh8::build`] makes of the scene, if the geometries before are as they were.
    ///
    /// # Errors
    /// Where the geometries before have other ranges in the scene; nothing is changed then.
    pub fn rebuild_from(
        &mut self,
        first: usize,
        scene: &SceneGeometry,
        options: &BuildOptions,
    ) -> Result<(), RefitError> {
        check_before(&self.geometries, first, scene)?;
        let start = Instant::now();
        let tail = &scene.geometries()[first..];
        let cuts: Vec<Cut> = tail.iter().map(|g| Bvh8::cut_geometry(scene, g, options)).collect();
        let instances = Cut::best(instance_tree(scene, options, Purpose::Eight));
        let [nodes, blocks, spheres] = self.starts[first];
        let more = cuts.iter().map(|c| c.wide.len()).sum::<usize>() + instances.wide.len();
        assert!(nodes + more < LEAF as usize, "more nodes than can be numbered");
        self.nodes.truncate(nodes);
        self.blocks.truncate(blocks);
        self.spheres.truncate(spheres);
        self.sphere_primitives.truncate(spheres);
        self.roots.truncate(first);
        self.starts.truncate(first);
        self.farthest.truncate(first);
        self.bounds.truncate(first);
        self.geometries = scene.geometries().to_vec();
        self.instances = scene.instances().to_vec();
        self.instance_bounds = instance_bounds(scene.instances());
        self.named_geometries = scene.named_geometries();
        self.emit(cuts, instances, scene, first);
        (self.builder, self.build_seconds) = (options.builder, start.elapsed().as_secs_f64());
        Ok(())
    }

    /// Appends the trees of the geometries from number `first` on, and that over the instances.
    fn emit(&mut self, cuts: Vec<Cut>, instances: Cut, scene: &SceneGeometry, first: usize) {
        for (cut, geometry) in cuts.into_iter().zip(&scene.geometries()[first..]) {
            self.starts.push(self.lengths());
            self.bounds.push(cut.bounds());
            let (root, farthest) = cut.emit(scene, Contents::Primitives(geometry), self);
            self.roots.push(root);
            self.farthest.push(farthest);
        }
        self.starts.push(self.lengths());
        (self.instance_root, _) = instances.emit(scene, Contents::Instances, self);
    }

    /// How many nodes, blocks and spheres there are.
    fn lengths(&self) -> [usize; 3] {
        [self.nodes.len(), self.blocks.len(), self.spheres.len()]
    }

    /// Nodes of all trees.
    pub fn nodes(&self) -> &[Node8] {
        &self.nodes
    }

    /// Leaves of triangles, up to four in each.
    pub fn blocks(&self) -> &[TriangleBlock] {
        &self.blocks
    }

    /// Spheres of all geometries, each a leaf of its own.
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres
    }

    /// The number in its geometry of each of [`Bvh8::spheres`].
    pub fn sphere_primitives(&self) -> &[u32] {
        &self.sphere_primitives
    }

    /// The root of each geometry's tree, by the geometry's number: a node, a leaf or [`EMPTY`].
    pub fn roots(&self) -> &[Child] {
        &self.roots
    }

    /// The root of the tree over all instances but the world: a node, a leaf or [`EMPTY`].
    pub fn instance_root(&self) -> Child {
        self.instance_root
    }

    fn cut_geometry(scene: &SceneGeometry, geometry: &Geometry, options: &BuildOptions) -> Cut {
        let triangles = &scene.triangles()[geometry.first_triangle as usize..];
        let triangles = &triangles[..geometry.triangle_count as usize];
        let only_triangles = geometry.sphere_count == 0 && !triangles.is_empty();
        let as_it_comes = !options.cut_large_triangles && !options.reinsertion;
        if options.builder == Builder::Morton && only_triangles && as_it_comes {
            let (tree, blocks, farthest) = morton::build(triangles);
            return Cut::best(tree).with_blocks(blocks, farthest);
        }
        Cut::best(geometry_tree(scene, geometry, options, Purpose::Eight))
    }
}

/// The box around the world boxes of all but the world.
fn instance_bounds(instances: &[Instance]) -> Bounds {
    instances.iter().skip(1).fold(Bounds::EMPTY, |b, i| b.union(&i.world_bounds))
}
