//! Which nodes of a tree with two children a node become nodes with eight: the cut of least cost, found by dynamic
//! programming (Ylitie et al. 2017, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs", section
//! 3.1; here leaves are left as they are).

use super::{Child, EMPTY, LEAF, TriangleBlock};
use crate::bvh::{Tree, filled, room_for};
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::BvhNode;

/// Children of a wide node.
const WIDTH: usize = 8;

/// Of nodes that vanish between a wide node and its children.
const INSIDE: Child = EMPTY - 1;

/// Of places: as many as there are leaves below.
const ALL: u8 = WIDTH as u8;

/// A tree, and what becomes of its nodes.
pub(super) struct Cut {
    pub(super) tree: Tree,
    /// For each node of the tree, what it is as a child, counted from 0 in this tree; [`INSIDE`] if it vanishes.
    pub(super) children: Vec<Child>,
    /// For each wide node, the node of the tree that it stands for.
    pub(super) wide: Vec<u32>,
    /// The tree's leaves.
    pub(super) leaves: Vec<u32>,
    /// Blocks of triangles that are packed already; then the leaves name them.
    pub(super) blocks: Vec<TriangleBlock>,
    /// And what is farthest in them.
    pub(super) farthest: f32,
    /// For each inner node of the tree, by [`slot`], how many leaves are below.
    leaves_below: Vec<u32>,
}

/// Costs of representing what is below a node by at most 1, 2, … 8 nodes.
type Costs = [f32; WIDTH];

impl Cut {
    /// The box around everything.
    pub(super) fn bounds(&self) -> Bounds {
        self.tree.nodes[0].bounds()
    }

    /// Of least cost, where visiting a wide node costs as much as a leaf does.
    pub(super) fn best(tree: Tree) -> Cut {
        let costs = AllCosts::new(&tree.nodes);
        Cut::by(tree, costs)
    }

    /// Whose leaves name blocks that are packed already, and what is farthest in them.
    pub(super) fn with_blocks(self, blocks: Vec<TriangleBlock>, farthest: f32) -> Cut {
        Cut { blocks, farthest, ..self }
    }

    /// Goes down from the root and gives each node its share of the eight places. Parents stand before their children.
    fn by(tree: Tree, costs: AllCosts) -> Cut {
        let nodes = &tree.nodes;
        // How many places a node has, less one.
        let mut places = filled(0u8, nodes.len());
        let mut children = room_for(nodes.len());
        // Half of the nodes and one more are leaves.
        let (mut wide, mut leaves) = (room_for(nodes.len() / 4), room_for(nodes.len() / 2 + 1));
        for (at, node) in nodes.iter().enumerate() {
            if !node.is_inner() {
                children.push(LEAF | leaves.len() as Child);
                leaves.push(at as u32);
                continue;
            }
            let pair = node.first as usize;
            if places[at] == ALL {
                children.push(INSIDE);
                places[pair..pair + 2].fill(ALL);
                continue;
            }
            let mut k = places[at] as usize % WIDTH;
            let own = costs.of(node);
            if k == 0 || own[k] == own[0] {
                children.push(wide.len() as Child);
                wide.push(at as u32);
                k = WIDTH - 1;
            } else {
                children.push(INSIDE);
            }
            // Nothing costs less than leaves that all have a place here.
            let shares = if costs.leaves_below(node) as usize <= k + 1 {
                [ALL; 2]
            } else {
                let left = costs.best_share(&nodes[pair], &nodes[pair + 1], k);
                [left as u8, (k - 1 - left) as u8]
            };
            places[pair..pair + 2].copy_from_slice(&shares);
        }
        let leaves_below = costs.leaves_below;
        Cut { tree, children, wide, leaves, blocks: Vec::new(), farthest: 0.0, leaves_below }
    }

    /// How many leaves a node of the tree has.
    #[inline(always)]
    pub(super) fn leaves_of(&self, node: &BvhNode) -> u32 {
        if node.is_inner() { self.leaves_below[slot(node)] } else { 1 }
    }

    /// The children of a wide node: nodes of the tree, from left to right, and how many.
    #[inline(always)]
    pub(super) fn children_of(&self, wide: u32) -> ([u32; WIDTH], usize) {
        let nodes = &self.tree.nodes;
        let (mut found, mut count) = ([0; WIDTH], 0);
        let first = nodes[wide as usize].first;
        let mut pending = [0; 2 * WIDTH];
        pending[..2].copy_from_slice(&[first + 1, first]);
        let mut left = 2;
        // Both outcomes are written and one is kept: which it is no processor could foresee.
        while left > 0 {
            left -= 1;
            let at = pending[left % (2 * WIDTH)];
            let inside = self.children[at as usize] == INSIDE;
            let first = nodes[at as usize].first;
            pending[left % (2 * WIDTH)] = first.wrapping_add(1);
            pending[(left + 1) % (2 * WIDTH)] = first;
            left += 2 * usize::from(inside);
            found[count % WIDTH] = at;
            count += usize::from(!inside);
        }
        (found, count)
    }
}

/// Where an inner node's numbers are: pairs of children are numbered from 1, without gaps.
#[inline(always)]
fn slot(node: &BvhNode) -> usize {
    node.first as usize / 2
}

/// What a leaf costs, whatever its places.
#[inline(always)]
fn area(node: &BvhNode) -> f32 {
    // Not a number where boxes are infinite: any cut will do there.
    node.bounds().half_area().min(f32::MAX / 1e9)
}

/// Of all inner nodes, by [`slot`].
struct AllCosts {
    costs: Vec<Costs>,
    leaves_below: Vec<u32>,
}

impl AllCosts {
    #[inline(always)]
    fn of(&self, node: &BvhNode) -> &Costs {
        &self.costs[slot(node)]
    }

    #[inline(always)]
    fn leaves_below(&self, node: &BvhNode) -> u32 {
        self.leaves_below[slot(node)]
    }

    /// From the leaves up: children stand behind their parents.
    fn new(nodes: &[BvhNode]) -> AllCosts {
        let inner = nodes.len() / 2;
        let mut all = AllCosts { costs: filled([0.0; WIDTH], inner), leaves_below: filled(0, inner) };
        for node in nodes.iter().rev().filter(|n| n.is_inner()) {
            let (left, right) = (&nodes[node.first as usize], &nodes[node.first as usize + 1]);
            let mut own = [f32::INFINITY; WIDTH];
            let leaves = match (left.is_inner(), right.is_inner()) {
                (false, false) => {
                    own = [area(left) + area(right); WIDTH];
                    2
                }
                // A leaf gets one place.
                (false, true) => own_beside(area(left), all.of(right), &mut own) + all.leaves_below(right),
                (true, false) => own_beside(area(right), all.of(left), &mut own) + all.leaves_below(left),
                (true, true) => {
                    let (a, b) = (all.of(left), all.of(right));
                    for k in 1..WIDTH {
                        for j in 0..k {
                            let cost = a[j] + b[k - 1 - j];
                            own[k] = if cost < own[k] { cost } else { own[k] };
                        }
                    }
                    all.leaves_below(left) + all.leaves_below(right)
                }
            };
            own[0] = area(node) + own[WIDTH - 1];
            for k in 1..WIDTH {
                own[k] = if own[0] < own[k] { own[0] } else { own[k] };
            }
            all.costs[slot(node)] = own;
            all.leaves_below[slot(node)] = leaves;
        }
        all
    }

    /// How many of k places the left of two children gets, less one.
    #[inline(always)]
    fn best_share(&self, left: &BvhNode, right: &BvhNode, k: usize) -> usize {
        if !left.is_inner() {
            return 0;
        }
        if !right.is_inner() {
            return k - 1;
        }
        let (left, right) = (self.of(left), self.of(right));
        let mut best = (f32::INFINITY, 0);
        for j in 0..k {
            let cost = left[j] + right[k - 1 - j];
            if cost < best.0 {
                best = (cost, j);
            }
        }
        best.1
    }
}

/// Costs of a node that has a leaf and another child; returns 1, the leaf.
#[inline(always)]
fn own_beside(leaf: f32, other: &Costs, own: &mut Costs) -> u32 {
    for k in 1..WIDTH {
        own[k] = leaf + other[k - 1];
    }
    1
}
