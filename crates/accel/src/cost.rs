//! What a ray is expected to cost in a whole scene: the surface area heuristic (Goldsmith and Salmon 1987, MacDonald and Booth
//! 1990) over trees that hold trees.
//!
//! Of the rays that meet a box, as many meet a box within it as its share of the surface says. A visit to an inner node costs
//! 1, and so does a test of a primitive. An instance is a leaf of the tree over the instances; it costs what its mesh's own
//! tree does, for the rays that meet its placed box.

use eosphor_core::geometry::{Bounds, Instance};
use eosphor_core::hierarchy::BvhNode;

/// What a ray is expected to cost in the tree of one geometry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeCost {
    /// Empty where the tree holds nothing.
    pub(crate) bounds: Bounds,
    /// Of a ray that meets the box.
    pub(crate) cost: f64,
}

impl TreeCost {
    /// Without anything.
    pub(crate) const NOTHING: TreeCost = TreeCost { bounds: Bounds::EMPTY, cost: 0.0 };

    /// Of a tree whose nodes cost so much, each times half the surface of its box.
    pub(crate) fn new(bounds: Bounds, weighted: f64) -> TreeCost {
        TreeCost { bounds, cost: over(weighted, half_area(&bounds)) }
    }

    /// Of a tree of nodes with two children.
    pub(crate) fn of_nodes(nodes: &[BvhNode], root: u32) -> TreeCost {
        let node = &nodes[root as usize];
        if !node.is_inner() && node.count & !BvhNode::SPHERES == 0 {
            return TreeCost::NOTHING;
        }
        let cost = |node: &BvhNode| match node.is_inner() {
            true => 1.0,
            false => f64::from(node.count & !BvhNode::SPHERES),
        };
        TreeCost::new(node.bounds(), weighted(nodes, root, cost))
    }
}

/// Expected cost of a ray that meets the box around everything. `trees` are those of the geometries, the world's own first, and
/// `inner` is [`inner_nodes`] of the tree over the instances. 0 where the box has no surface.
pub(crate) fn scene_cost(trees: &[TreeCost], inner: f64, instances: &[Instance]) -> f64 {
    let world = trees.first().copied().unwrap_or(TreeCost::NOTHING);
    let placed = instances.get(1..).unwrap_or_default();
    if placed.is_empty() {
        return world.cost;
    }
    let of_instance = |instance: &Instance| {
        let cost = trees.get(instance.geometry as usize).map_or(0.0, |tree| tree.cost);
        half_area(&instance.world_bounds) * cost
    };
    let sum = half_area(&world.bounds) * world.cost + inner + placed.iter().map(of_instance).sum::<f64>();
    over(sum, half_area(&around(world.bounds, instances)))
}

/// The box around the world's own geometry and all that instances place.
pub(crate) fn around(world: Bounds, instances: &[Instance]) -> Bounds {
    instances.iter().skip(1).fold(world, |bounds, instance| bounds.union(&instance.world_bounds))
}

/// Half the surfaces of the inner nodes of a tree, added up.
pub(crate) fn inner_nodes(nodes: &[BvhNode], root: u32) -> f64 {
    weighted(nodes, root, |node| if node.is_inner() { 1.0 } else { 0.0 })
}

/// What the nodes of a tree cost, each times half its surface.
fn weighted(nodes: &[BvhNode], root: u32, cost: impl Fn(&BvhNode) -> f64) -> f64 {
    let (mut sum, mut pending) = (0.0, vec![root]);
    while let Some(at) = pending.pop() {
        let node = &nodes[at as usize];
        sum += half_area(&node.bounds()) * cost(node);
        if node.is_inner() {
            pending.extend([node.first, node.first + 1]);
        }
    }
    sum
}

/// Half the surface of a box, in double precision and finite whatever the box; 0 for the empty one.
pub(crate) fn half_area(bounds: &Bounds) -> f64 {
    let side =
        |axis: usize| f64::from(bounds.max[axis].min(f32::MAX)) - f64::from(bounds.min[axis].max(f32::MIN));
    let [x, y, z] = [0, 1, 2].map(side).map(|side| side.max(0.0));
    x * y + y * z + z * x
}

/// A quotient; 0 where there is nothing to divide by.
fn over(sum: f64, area: f64) -> f64 {
    if area > 0.0 { sum / area } else { 0.0 }
}
