//! The builder: top-down, parallel, with the same bytes for any number of threads.

use super::sah::{best_split, bounds_of};
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::{BvhNode, MAX_BVH_DEPTH};

/// How a hierarchy is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// Primitives a leaf may hold, 1 to 255.
    pub max_leaf_primitives: u32,
    /// Cost of visiting a node, in primitive tests. A smaller one makes smaller leaves.
    pub traversal_cost: f32,
}

impl Default for BuildOptions {
    fn default() -> BuildOptions {
        BuildOptions { max_leaf_primitives: 4, traversal_cost: 1.0 }
    }
}

/// A primitive on its way into the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub(super) bounds: Bounds,
    pub(super) index: u32,
}

/// A tree: the root is node 0, children stand in pairs, leaves name ranges of the two orders.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<BvhNode>,
    pub(crate) triangle_order: Vec<u32>,
    pub(crate) sphere_order: Vec<u32>,
}

/// Subtrees with more items than this are built by threads of their own.
const PARALLEL_ITEMS: usize = 4096;

/// Builds over primitives with these padded bounds: `triangle_count` triangles, then spheres.
pub(crate) fn build_tree(bounds: &[Bounds], triangle_count: u32, options: &BuildOptions) -> Tree {
    let mut items: Vec<Item> =
        (0..).zip(bounds).map(|(index, bounds)| Item { bounds: *bounds, index }).collect();
    if items.is_empty() {
        return Tree { nodes: vec![BvhNode::EMPTY], triangle_order: vec![], sphere_order: vec![] };
    }
    // A subtree of n items has at most 2 n - 1 nodes: its root, and room for the others in one range. Ranges are known
    // before the subtrees are, so threads do not have to agree on anything.
    let mut nodes = vec![BvhNode::EMPTY; 2 * items.len() - 1];
    let builder = Builder { options, triangle_count };
    let (root, below) = nodes.split_first_mut().expect("there is a root");
    builder.build(root, below, 1, &mut items, 0, 0);
    compact(&nodes, &items, triangle_count)
}

struct Builder<'a> {
    options: &'a BuildOptions,
    triangle_count: u32,
}

impl Builder<'_> {
    /// Builds the subtree over `items`, which start at `first_item` of all, into `node` and the nodes `below`, which
    /// start at `first_below` of all.
    fn build(
        &self,
        node: &mut BvhNode,
        below: &mut [BvhNode],
        first_below: usize,
        items: &mut [Item],
        first_item: usize,
        depth: usize,
    ) {
        let (bounds, centroids) = bounds_of(items);
        (node.min, node.max) = (bounds.min, bounds.max);
        let Some(left_count) = self.partition(items, &bounds, &centroids, depth) else {
            node.first = first_item as u32;
            node.count = items.len() as u32;
            return;
        };
        node.first = first_below as u32;
        node.count = 0;
        let (left_items, right_items) = items.split_at_mut(left_count);
        let (pair, below) = below.split_at_mut(2);
        let (left, right) = pair.split_at_mut(1);
        let (left_below, right_below) = below.split_at_mut(2 * left_count - 2);
        let first_left = first_below + 2;
        let first_right = first_left + left_below.len();
        let parallel = left_items.len() + right_items.len() > PARALLEL_ITEMS;
        let mut build_left =
            || self.build(&mut left[0], left_below, first_left, left_items, first_item, depth + 1);
        let mut build_right = || {
            self.build(
                &mut right[0],
                right_below,
                first_right,
                right_items,
                first_item + left_count,
                depth + 1,
            );
        };
        if parallel {
            rayon::join(build_left, build_right);
        } else {
            build_left();
            build_right();
        }
    }

    /// Orders items so that the left child's come first and returns how many these are; `None` makes a leaf.
    fn partition(
        &self,
        items: &mut [Item],
        bounds: &Bounds,
        centroids: &Bounds,
        depth: usize,
    ) -> Option<usize> {
        let count = items.len();
        let is_triangle = |item: &Item| item.index < self.triangle_count;
        let mixed = items.iter().any(is_triangle) && !items.iter().all(is_triangle);
        if count == 1 {
            return None;
        }
        // Halving from here on reaches single items within the depth that traversals have a stack for.
        let halvings = usize::BITS - (count - 1).leading_zeros();
        let must_halve = depth + halvings as usize + 2 >= MAX_BVH_DEPTH;
        let split = if must_halve { None } else { best_split(items, centroids) };
        let small = count <= self.options.max_leaf_primitives as usize;
        if small {
            let area = bounds.half_area();
            let split_cost = split.map_or(f32::INFINITY, |s| self.options.traversal_cost * area + s.cost);
            if split_cost >= area * count as f32 {
                // A leaf holds primitives of one kind.
                return mixed.then(|| partition_by(items, is_triangle));
            }
        }
        match split {
            Some(split) => {
                Some(partition_by(items, |item| split.bins.bin(item.bounds.center(), split.axis) < split.bin))
            }
            // All centroids are one point: any halves are as good.
            None => Some(count / 2),
        }
    }
}

/// Brings the items for which `goes_left` to the front, in place and by the items alone; returns how many.
fn partition_by(items: &mut [Item], goes_left: impl Fn(&Item) -> bool) -> usize {
    let (mut left, mut right) = (0, items.len());
    while left < right {
        if goes_left(&items[left]) {
            left += 1;
        } else {
            right -= 1;
            items.swap(left, right);
        }
    }
    left
}

/// Drops unused nodes. Pairs come in the order of a depth-first walk, primitives in the order of the leaves.
fn compact(nodes: &[BvhNode], items: &[Item], triangle_count: u32) -> Tree {
    let mut tree = Tree {
        nodes: Vec::with_capacity(nodes.len()),
        triangle_order: Vec::with_capacity(items.len()),
        sphere_order: Vec::new(),
    };
    tree.nodes.push(nodes[0]);
    let mut pending = vec![0usize];
    while let Some(at) = pending.pop() {
        let node = tree.nodes[at];
        if node.is_inner() {
            let pair = tree.nodes.len();
            tree.nodes[at].first = pair as u32;
            tree.nodes.extend_from_slice(&nodes[node.first as usize..][..2]);
            pending.extend([pair + 1, pair]);
            continue;
        }
        let range = &items[node.first as usize..][..node.count as usize];
        let spheres = range[0].index >= triangle_count;
        let order = if spheres { &mut tree.sphere_order } else { &mut tree.triangle_order };
        tree.nodes[at].first = order.len() as u32;
        tree.nodes[at].count = node.count | if spheres { BvhNode::SPHERES } else { 0 };
        order.extend(range.iter().map(|item| item.index));
    }
    tree
}
