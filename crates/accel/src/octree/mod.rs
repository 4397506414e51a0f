//! Octree, with PG1's settings as defaults.

mod build;
mod overlap;

pub use build::{OctreeOptions, Overlap};

use crate::bvh::{RefitError, check_before};
use crate::cells::{self, InstanceTree, LeafCounts};
use crate::cost::{self, TreeCost};
use crate::{HierarchyStatistics, PackedPrimitives, SceneGeometry};
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::{
    InstanceTreeView, OctreeNode, OctreeParametricTracer, OctreeRoot, OctreeTracer, OctreeView, Work,
};
use eosphor_core::material::NONE;
use std::time::Instant;

/// An octree over every geometry and a tree over the instances, in the arrays that devices read.
#[derive(Clone, Debug)]
pub struct Octree {
    /// Nodes of all trees.
    nodes: Vec<OctreeNode>,
    /// The tree of each geometry, by the geometry's number.
    roots: Vec<OctreeRoot>,
    /// For each geometry, how many nodes and references there are before its own.
    starts: Vec<[usize; 2]>,
    /// What leaves hold: numbers of triangles, or of spheres with [`eosphor_core::hierarchy::SPHERE_REFERENCE`].
    references: Vec<u32>,
    /// Primitives; triangles in the order in which leaves name them first.
    primitives: PackedPrimitives,
    /// Wall time of the build, in seconds.
    pub build_seconds: f64,
    instances: InstanceTree,
}

impl Octree {
    /// Builds a hierarchy over a scene, on the threads of the current rayon pool. The result does not depend on their number.
    pub fn build(scene: &SceneGeometry, options: &OctreeOptions) -> Octree {
        let start = Instant::now();
        let mut tree = Octree {
            nodes: Vec::new(),
            roots: Vec::new(),
            starts: Vec::new(),
            references: Vec::new(),
            primitives: PackedPrimitives::new(scene),
            build_seconds: 0.0,
            instances: InstanceTree::build(scene),
        };
        tree.add_from(0, scene, options);
        tree.build_seconds = start.elapsed().as_secs_f64();
        tree
    }

    /// Builds the trees of the geometries from number `first` on anew, and the tree over the instances. The result is what
    /// [`Octree::build`] makes of the scene, if the geometries before are as they were.
    ///
    /// # Errors
    /// Where the geometries before have other ranges in the scene; nothing is changed then.
    pub fn rebuild_from(
        &mut self,
        first: usize,
        scene: &SceneGeometry,
        options: &OctreeOptions,
    ) -> Result<(), RefitError> {
        check_before(&self.primitives.geometries, first, scene)?;
        let start = Instant::now();
        if let Some(&[nodes, references]) = self.starts.get(first) {
            self.nodes.truncate(nodes);
            self.references.truncate(references);
        }
        self.roots.truncate(first);
        self.starts.truncate(first);
        self.primitives.repack_from(first, scene);
        self.instances = InstanceTree::build(scene);
        self.add_from(first, scene, options);
        self.build_seconds = start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Appends the trees of the geometries from this number on, whose primitives are packed.
    fn add_from(&mut self, first: usize, scene: &SceneGeometry, options: &OctreeOptions) {
        let before = self.references.len();
        for geometry in &scene.geometries()[first..] {
            self.starts.push([self.nodes.len(), self.references.len()]);
            let items = cells::items(&self.primitives, geometry);
            if items.is_empty() {
                self.roots.push(OctreeRoot { bounds: Bounds::EMPTY, node: NONE });
                continue;
            }
            let root = build::Builder::new(&self.primitives, geometry, items, options)
                .build(&mut self.nodes, &mut self.references);
            self.roots.push(root);
        }
        cells::order_by_first_use(&mut self.primitives, &mut self.references[before..], first);
    }

    /// The arrays of the hierarchy, borrowed, for devices and for tracers of eosphor-core.
    ///
    /// # Panics
    /// Where the hierarchy was built over instances alone.
    pub fn view(&self) -> OctreeView<'_> {
        self.view_with_instances_of(self)
    }

    /// The tree over the instances alone, which does not need the geometries.
    pub fn instance_tree(&self) -> InstanceTreeView<'_> {
        self.instances.view()
    }

    /// The arrays of the hierarchy, borrowed, with the instances of another one, `top`, in place of its own. That one may be built
    /// over the instances alone ([`SceneGeometry::of_instances`]).
    ///
    /// # Panics
    /// Where an instance is of a geometry that this hierarchy does not have.
    pub fn view_with_instances_of<'a>(&'a self, top: &'a Octree) -> OctreeView<'a> {
        OctreeView {
            nodes: &self.nodes,
            roots: &self.roots,
            references: &self.references,
            instances: top.instance_tree(),
            primitives: self.primitives.view_with_instances_of(&top.primitives),
        }
    }

    /// The traversal that visits every octant that a ray meets, one ray at a time. It tells `work` what it does;
    /// [`IgnoreWork`](crate::IgnoreWork) costs nothing.
    ///
    /// # Panics
    /// Where the hierarchy was built over instances alone ([`SceneGeometry::of_instances`]).
    pub fn tracer<C: Work>(&self, work: C) -> OctreeTracer<'_, C> {
        self.tracer_with_instances_of(self, work)
    }

    /// The traversal that visits octants from front to back (Revelles et al. 2000), one ray at a time. It tells `work` what it
    /// does; [`IgnoreWork`](crate::IgnoreWork) costs nothing.
    ///
    /// # Panics
    /// Where the hierarchy was built over instances alone ([`SceneGeometry::of_instances`]).
    pub fn parametric_tracer<C: Work>(&self, work: C) -> OctreeParametricTracer<'_, C> {
        self.parametric_tracer_with_instances_of(self, work)
    }

    /// The traversal of [`Octree::tracer`], with the instances of another hierarchy, `top`, in place of the own ones. That one
    /// may be built over the instances alone ([`SceneGeometry::of_instances`]).
    ///
    /// # Panics
    /// Where an instance is of a geometry that this hierarchy does not have.
    pub fn tracer_with_instances_of<'a, C: Work>(&'a self, top: &'a Octree, work: C) -> OctreeTracer<'a, C> {
        // SAFETY: closed view: the fields are private, and builders make them so; `view_with_instances_of` checks the instances.
        unsafe { OctreeTracer::new(self.view_with_instances_of(top), work) }
    }

    /// The traversal of [`Octree::parametric_tracer`], with the instances of another hierarchy, `top`, in place of the own ones.
    /// That one may be built over the instances alone ([`SceneGeometry::of_instances`]).
    ///
    /// # Panics
    /// Where an instance is of a geometry that this hierarchy does not have.
    pub fn parametric_tracer_with_instances_of<'a, C: Work>(
        &'a self,
        top: &'a Octree,
        work: C,
    ) -> OctreeParametricTracer<'a, C> {
        // SAFETY: closed view: the fields are private, and builders make them so; `view_with_instances_of` checks the instances.
        unsafe { OctreeParametricTracer::new(self.view_with_instances_of(top), work) }
    }

    /// Nodes of all trees.
    pub fn nodes(&self) -> &[OctreeNode] {
        &self.nodes
    }

    /// The tree of each geometry, by the geometry's number.
    pub fn roots(&self) -> &[OctreeRoot] {
        &self.roots
    }

    /// What leaves hold, one after the other: numbers of triangles in the array of primitives, or of spheres with
    /// [`eosphor_core::hierarchy::SPHERE_REFERENCE`].
    pub fn references(&self) -> &[u32] {
        &self.references
    }

    /// Primitives, in the order of the leaves.
    pub fn primitives(&self) -> &PackedPrimitives {
        &self.primitives
    }

    /// The trees of all geometries in numbers; that over the instances counts in the bytes alone. Octants that hold
    /// nothing have no node and are not counted.
    pub fn statistics(&self) -> HierarchyStatistics {
        let p = &self.primitives;
        let mut s = HierarchyStatistics {
            structure: "octree",
            builder: "halving",
            primitives: (p.triangles.len() + p.spheres.len()) as u64,
            bytes: (size_of_val(&self.nodes[..])
                + size_of_val(&self.references[..])
                + self.instances.bytes()
                + cells::primitive_bytes(p)) as u64,
            build_seconds: self.build_seconds,
            ..HierarchyStatistics::default()
        };
        let mut leaves = LeafCounts::default();
        let mut trees = vec![TreeCost::NOTHING; self.roots.len()];
        for (root, tree) in self.roots.iter().zip(&mut trees).filter(|(root, _)| root.node != NONE) {
            tree.bounds = root.bounds;
            let mut pending = vec![(root.node, 0u32)];
            while let Some((at, depth)) = pending.pop() {
                let node = &self.nodes[at as usize];
                // Half the size is a quarter of the surface.
                let share = 0.25f64.powi(depth as i32);
                if node.is_inner() {
                    s.nodes += 1;
                    tree.cost += share;
                    let children = (node.octants_or_count & 0xFF).count_ones();
                    pending.extend((node.first..node.first + children).map(|child| (child, depth + 1)));
                } else {
                    tree.cost += share * f64::from(node.octants_or_count);
                    leaves.add(&mut s, depth, node.octants_or_count);
                }
            }
        }
        leaves.finish(&mut s);
        s.sah_cost = cost::scene_cost(&trees, self.instances.inner_nodes(), &p.instances);
        s
    }
}
