//! Bounding volume hierarchy with two children a node.

mod binned;
mod clip;
mod codes;
mod cuts;
mod lanes;
mod memory;
mod morton;
mod options;
mod pack;
mod policy;
mod presplit;
mod reference;
mod refit;
mod reinsertion;
mod shape;
mod spatial;
mod split;
mod statistics;
mod sweep;
mod top_down;
mod tree;

pub(crate) use codes::Key;
pub(crate) use memory::{filled, room_for};
pub use options::{BuildOptions, Builder, Quality};
pub(crate) use pack::{AHEAD, fill_in_parallel, pack, prefetch};
pub(crate) use policy::Purpose;
pub use refit::RefitError;
pub(crate) use refit::{check, check_before, union};
pub(crate) use shape::{Shape, finite_box};
pub(crate) use tree::Tree;

use crate::cost::{self, TreeCost};
use crate::{HierarchyStatistics, PackedPrimitives, SceneGeometry};
use eosphor_core::geometry::{Bounds, Geometry};
use eosphor_core::hierarchy::{BvhNode, BvhTracer, BvhView, InstanceTreeView, Work};
use eosphor_core::intersect::sphere_bounds;
use policy::Policy;
use reference::Reference;
use reinsertion::Effort;
use std::time::Instant;

/// Trees over every geometry and one over the instances, in the arrays that devices read.
#[derive(Clone, Debug)]
pub struct Bvh {
    /// Nodes of all trees.
    pub(crate) nodes: Vec<BvhNode>,
    /// For each geometry, the number of its root.
    pub(crate) roots: Vec<u32>,
    /// For each geometry, how many triangles [`Bvh::primitives`] has before those of the geometry.
    first_triangles: Vec<u32>,
    /// Root of the tree over the instances but the world. Its nodes come after those of the geometries.
    pub(crate) instance_root: u32,
    /// Numbers of instances, in the order of its leaves.
    pub(crate) instance_order: Vec<u32>,
    /// Primitives, in the order of the leaves. With spatial splits a triangle may stand there several times, and then
    /// the ranges of triangles in `geometries` are those of the scene, not of this array.
    pub(crate) primitives: PackedPrimitives,
    /// What chose the splits when it was built.
    pub builder: Builder,
    /// Wall time of the build, in seconds.
    pub build_seconds: f64,
}

impl Bvh {
    /// Builds a hierarchy over a scene, on the threads of the current rayon pool. The result does not depend on their number.
    pub fn build(scene: &SceneGeometry, options: &BuildOptions) -> Bvh {
        let start = Instant::now();
        let mut bvh = Bvh {
            nodes: Vec::new(),
            roots: Vec::new(),
            first_triangles: Vec::new(),
            instance_root: 0,
            instance_order: Vec::new(),
            primitives: PackedPrimitives::without_primitives(scene),
            builder: options.builder,
            build_seconds: 0.0,
        };
        bvh.add_from(0, scene, options);
        bvh.build_seconds = start.elapsed().as_secs_f64();
        bvh
    }

    /// Builds the trees of the geometries from number `first` on anew, and that over the instances. The result is what
    /// [`Bvh::build`] makes of the scene, if the geometries before are as they were.
    ///
    /// # Errors
    /// Where the geometries before have other ranges in the scene; nothing is changed then.
    pub fn rebuild_from(
        &mut self,
        first: usize,
        scene: &SceneGeometry,
        options: &BuildOptions,
    ) -> Result<(), RefitError> {
        check_before(&self.primitives.geometries, first, scene)?;
        let start = Instant::now();
        self.nodes.truncate(*self.roots.get(first).unwrap_or(&self.instance_root) as usize);
        if let (Some(&triangles), Some(old)) =
            (self.first_triangles.get(first), self.primitives.geometries.get(first).copied())
        {
            self.primitives.triangles.truncate(triangles as usize);
            self.primitives.truncate_spheres(old.first_sphere as usize);
        }
        self.roots.truncate(first);
        self.first_triangles.truncate(first);
        self.primitives.take_ranges(scene);
        self.add_from(first, scene, options);
        (self.builder, self.build_seconds) = (options.builder, start.elapsed().as_secs_f64());
        Ok(())
    }

    /// Appends the trees of the geometries from this number on, and then that over the instances.
    fn add_from(&mut self, first: usize, scene: &SceneGeometry, options: &BuildOptions) {
        for geometry in &scene.geometries()[first..] {
            self.add_geometry(scene, geometry, options);
        }
        let tree = instance_tree(scene, options, Purpose::Two);
        self.instance_root = self.append(tree.nodes, 0, 0);
        self.instance_order = tree.order.iter().map(|i| i + 1).collect();
    }

    /// The arrays of the hierarchy, borrowed, for devices and for tracers of eosphor-core.
    ///
    /// # Panics
    /// Where the hierarchy was built over instances alone.
    pub fn view(&self) -> BvhView<'_> {
        self.view_with_instances_of(self)
    }

    /// The tree over the instances alone, which does not need the geometries.
    pub fn instance_tree(&self) -> InstanceTreeView<'_> {
        InstanceTreeView { nodes: &self.nodes, root: self.instance_root, order: &self.instance_order }
    }

    /// The arrays of the hierarchy, borrowed, with the instances of another one, `top`, in place of its own. That one may be built
    /// over the instances alone ([`SceneGeometry::of_instances`]).
    ///
    /// # Panics
    /// Where an instance is of a geometry that this hierarchy does not have.
    pub fn view_with_instances_of<'a>(&'a self, top: &'a Bvh) -> BvhView<'a> {
        BvhView {
            nodes: &self.nodes,
            roots: &self.roots,
            instances: top.instance_tree(),
            primitives: self.primitives.view_with_instances_of(&top.primitives),
        }
    }

    /// Nodes of all trees.
    pub fn nodes(&self) -> &[BvhNode] {
        &self.nodes
    }

    /// The number of the root node of each geometry, by the geometry's number.
    pub fn roots(&self) -> &[u32] {
        &self.roots
    }

    /// The number of the root of the tree over the instances but the world.
    pub fn instance_root(&self) -> u32 {
        self.instance_root
    }

    /// Numbers of instances, in the order of the leaves of their tree.
    pub fn instance_order(&self) -> &[u32] {
        &self.instance_order
    }

    /// Primitives, in the order of the leaves. With spatial splits a triangle may stand there several times, and then the ranges
    /// of triangles in `geometries` are those of the scene, not of this array.
    pub fn primitives(&self) -> &PackedPrimitives {
        &self.primitives
    }

    /// The traversal, one ray at a time. It tells `work` what it does; [`IgnoreWork`](crate::IgnoreWork) costs nothing.
    ///
    /// # Panics
    /// Where the hierarchy was built over instances alone.
    pub fn tracer<C: Work>(&self, work: C) -> BvhTracer<'_, C> {
        self.tracer_with_instances_of(self, work)
    }

    /// The traversal of [`Bvh::tracer`], with the instances of another hierarchy, `top`, in place of the own ones. That one
    /// may be built over the instances alone ([`SceneGeometry::of_instances`]).
    ///
    /// # Panics
    /// Where an instance is of a geometry that this hierarchy does not have.
    pub fn tracer_with_instances_of<'a, C: Work>(&'a self, top: &'a Bvh, work: C) -> BvhTracer<'a, C> {
        // SAFETY: closed view: the fields are private, and builders make them so; `view_with_instances_of` checks the instances.
        unsafe { BvhTracer::new(self.view_with_instances_of(top), work) }
    }

    /// The hierarchy in numbers, all trees together.
    pub fn statistics(&self) -> HierarchyStatistics {
        let mut roots = self.roots.clone();
        if !self.instance_order.is_empty() {
            roots.push(self.instance_root);
        }
        HierarchyStatistics { sah_cost: self.sah_cost(), ..self.count_trees(&roots) }
    }

    /// The expected cost of a ray, as [`HierarchyStatistics::sah_cost`] says it, without the rest of the statistics.
    pub fn sah_cost(&self) -> f64 {
        let trees: Vec<TreeCost> =
            self.roots.iter().map(|&root| TreeCost::of_nodes(&self.nodes, root)).collect();
        let inner = cost::inner_nodes(&self.nodes, self.instance_root);
        cost::scene_cost(&trees, inner, &self.primitives.instances)
    }

    fn add_geometry(&mut self, scene: &SceneGeometry, geometry: &Geometry, options: &BuildOptions) {
        let mut tree = geometry_tree(scene, geometry, options, Purpose::Two);
        let (first_triangle, first_sphere) =
            (self.primitives.triangles.len() as u32, self.primitives.spheres.len() as u32);
        self.first_triangles.push(first_triangle);
        if geometry.sphere_count > 0 {
            self.take_spheres(scene, geometry, &mut tree);
        }
        let vertices = &scene.triangles()[geometry.first_triangle as usize..];
        pack(&mut self.primitives.triangles, vertices, &tree.order);
        let root = self.append(tree.nodes, first_triangle, first_sphere);
        self.roots.push(root);
    }

    /// Takes the spheres out of a tree's order, and lets leaves count triangles and spheres each on their own.
    fn take_spheres(&mut self, scene: &SceneGeometry, geometry: &Geometry, tree: &mut Tree) {
        let mut triangles = Vec::with_capacity(geometry.triangle_count as usize);
        let mut spheres = 0;
        for node in tree.nodes.iter_mut().filter(|n| !n.is_inner()) {
            let count = (node.count & !BvhNode::SPHERES) as usize;
            let range = &tree.order[node.first as usize..][..count];
            if node.count & BvhNode::SPHERES == 0 {
                node.first = triangles.len() as u32;
                triangles.extend_from_slice(range);
                continue;
            }
            node.first = spheres;
            spheres += count as u32;
            for &primitive in range {
                let at = geometry.first_sphere + (primitive - geometry.triangle_count);
                self.primitives.spheres.push(scene.spheres()[at as usize]);
                self.primitives.sphere_primitives.push(primitive);
            }
        }
        tree.order = triangles;
    }

    /// Appends the nodes of a tree; returns the number of its root.
    fn append(&mut self, mut nodes: Vec<BvhNode>, first_triangle: u32, first_sphere: u32) -> u32 {
        let base = self.nodes.len() as u32;
        if base + first_triangle + first_sphere > 0 {
            for node in &mut nodes {
                node.first += if node.is_inner() {
                    base
                } else if node.count & BvhNode::SPHERES != 0 {
                    first_sphere
                } else {
                    first_triangle
                };
            }
        }
        if base == 0 {
            self.nodes = nodes;
        } else {
            self.nodes.extend(nodes);
        }
        base
    }
}

/// The tree over the primitives of a geometry; spheres are numbered after the triangles.
pub(crate) fn geometry_tree(
    scene: &SceneGeometry,
    geometry: &Geometry,
    options: &BuildOptions,
    purpose: Purpose,
) -> Tree {
    let triangles =
        &scene.triangles()[geometry.first_triangle as usize..][..geometry.triangle_count as usize];
    let spheres = &scene.spheres()[geometry.first_sphere as usize..][..geometry.sphere_count as usize];
    let spheres: Vec<Bounds> = spheres.iter().map(sphere_bounds).collect();
    let mut policy = Policy::new(options, purpose, triangles.len(), spheres.len());
    let count = triangles.len() + spheres.len();
    // Cutting is for blocks of four, where the cost of a few more is small.
    let presplit = options.cut_large_triangles
        && purpose == Purpose::Eight
        && matches!(options.builder, Builder::Morton | Builder::Binned);
    let room = match options.builder {
        Builder::Spatial => spatial::room(count),
        _ if presplit => spheres.len() + presplit::room(triangles.len()),
        _ => count,
    };
    let (mut references, mut extent, largest) = reference::make_references(triangles, &spheres, room);
    if presplit {
        let ranges = largest.above(presplit::LARGE, &extent, triangles.len());
        policy.has_parts = presplit::cut_large(&mut references, &mut extent, &ranges, triangles);
    }
    if options.builder == Builder::Spatial && !references.is_empty() {
        if purpose == Purpose::Eight {
            policy = policy.with_entry(extent.bounds.half_area());
        }
        let tree = spatial::build(references, &extent, &policy, triangles).join();
        return reinsert(tree, options, purpose, &policy);
    }
    build_tree(references, &extent, (options, purpose), &policy)
}

/// The tree over the instances but the world, numbered from 0. To it, instances are what triangles are to the others.
pub(crate) fn instance_tree(scene: &SceneGeometry, options: &BuildOptions, purpose: Purpose) -> Tree {
    let bounds: Vec<Bounds> = scene.instances().iter().skip(1).map(|i| i.world_bounds).collect();
    let mut policy = Policy::new(options, purpose, bounds.len(), 0);
    if purpose == Purpose::Eight {
        policy.max_leaf = [1, 1];
    }
    // There is nothing to clip.
    let builder = if options.builder == Builder::Spatial { Builder::Binned } else { options.builder };
    let (references, extent, _) = reference::make_references(&[], &bounds, 0);
    build_tree(references, &extent, (&BuildOptions { builder, ..*options }, purpose), &policy)
}

fn build_tree(
    mut references: Vec<Reference>,
    extent: &reference::Extent,
    (options, purpose): (&BuildOptions, Purpose),
    policy: &Policy,
) -> Tree {
    if references.is_empty() {
        return Tree { nodes: vec![BvhNode::EMPTY], order: Vec::new() };
    }
    let piece = match options.builder {
        Builder::Morton => morton::build(&references, extent, policy),
        builder => {
            let mut room = filled(Reference::NONE, references.len());
            top_down::TopDown { builder, policy }.build(&mut references, &mut room, extent, 0)
        }
    };
    drop(references);
    reinsert(piece.join(), options, purpose, policy)
}

/// Puts large nodes where they cost least, if the options say so and the tree is to be collapsed: trees with two children a node
/// gain a hundredth at most.
fn reinsert(tree: Tree, options: &BuildOptions, purpose: Purpose, policy: &Policy) -> Tree {
    if !options.reinsertion || purpose != Purpose::Eight {
        return tree;
    }
    let effort = match options.builder {
        Builder::Spatial => Effort { share: 4, most: 65_536 },
        _ => Effort { share: 4, most: 16_384 },
    };
    tree.reinserted(effort, policy.max_depth)
}
