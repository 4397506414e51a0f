//! Which nodes of a tree with two children a node become nodes with eight: the cut of least cost, found by dynamic
//! programming (Ylitie et al. 2017, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs", section
//! 3.1; here leaves are left as they are).

use super::{Child, EMPTY, LEAF, TriangleBlock};
use crate::bvh::{Tree, filled, room_for};
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
    /// For each node of the tree, the last first, how many leaves are below.
    leaves_below: Vec<u32>,
}

/// Costs of representing what is below a node by at most 1, 2, … 8 nodes.
type Costs = [f32; WIDTH];

impl Cut {
    /// Of least cost, where visiting a wide node costs as much as a leaf does.
    pub(super) fn best(tree: Tree, blocks: Vec<TriangleBlock>) -> Cut {
        let (costs, leaves_below) = AllCosts::new(&tree.nodes);
        Cut::by(tree, blocks, &costs, leaves_below)
    }

    /// Goes down from the root and gives each node its share of the eight places. Parents stand before their children.
    fn by(tree: Tree, blocks: Vec<TriangleBlock>, costs: &AllCosts, leaves_below: Vec<u32>) -> Cut {
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
            if places[at] == ALL {
                children.push(INSIDE);
                places[node.first as usize] = ALL;
                places[node.first as usize + 1] = ALL;
                continue;
            }
            let mut k = places[at] as usize % WIDTH;
            let own = costs.of(at);
            if k == 0 || own[k] == own[0] {
                children.push(wide.len() as Child);
                wide.push(at as u32);
                k = WIDTH - 1;
            } else {
                children.push(INSIDE);
            }
            let pair = node.first as usize;
            // Nothing costs less than leaves that all have a place here.
            if leaves_below[nodes.len() - 1 - at] as usize <= k + 1 {
                places[pair] = ALL;
                places[pair + 1] = ALL;
                continue;
            }
            let (left, right) = (costs.of(pair), costs.of(pair + 1));
            let mut best = (f32::INFINITY, 0);
            for j in 0..k {
                let cost = left[j] + right[k - 1 - j];
                if cost < best.0 {
                    best = (cost, j);
                }
            }
            places[node.first as usize] = best.1 as u8;
            places[node.first as usize + 1] = (k - 1 - best.1) as u8;
        }
        Cut { tree, children, wide, leaves, blocks, leaves_below }
    }

    /// How many leaves a node of the tree has.
    #[inline(always)]
    pub(super) fn leaves_of(&self, node: u32) -> u32 {
        self.leaves_below[self.leaves_below.len() - 1 - node as usize]
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

/// Costs of all nodes, the last node's first: they are found from the leaves up.
struct AllCosts {
    reversed: Vec<Costs>,
    nodes: usize,
}

impl AllCosts {
    #[inline(always)]
    fn of(&self, node: usize) -> &Costs {
        &self.reversed[self.nodes - 1 - node]
    }

    /// Children stand behind their parents.
    fn new(nodes: &[BvhNode]) -> (AllCosts, Vec<u32>) {
        let mut costs = AllCosts { reversed: room_for(nodes.len()), nodes: nodes.len() };
        let mut leaves_below: Vec<u32> = room_for(nodes.len());
        for node in nodes.iter().rev() {
            // Not a number where boxes are infinite: any cut will do there.
            let area = node.bounds().half_area().min(f32::MAX / 1e9);
            if !node.is_inner() {
                costs.reversed.push([area; WIDTH]);
                leaves_below.push(1);
                continue;
            }
            let pair = node.first as usize;
            let last = nodes.len() - 1 - pair;
            leaves_below.push(leaves_below[last] + leaves_below[last - 1]);
            let (left, right) = (costs.of(pair), costs.of(pair + 1));
            let mut own = [f32::INFINITY; WIDTH];
            // What a leaf costs does not fall with its places, so it gets one.
            if !nodes[pair].is_inner() {
                for k in 1..WIDTH {
                    own[k] = left[0] + right[k - 1];
                }
            } else if !nodes[pair + 1].is_inner() {
                for k in 1..WIDTH {
                    own[k] = left[k - 1] + right[0];
                }
            } else {
                for k in 1..WIDTH {
                    for j in 0..k {
                        let cost = left[j] + right[k - 1 - j];
                        own[k] = if cost < own[k] { cost } else { own[k] };
                    }
                }
            }
            own[0] = area + own[WIDTH - 1];
            for k in 1..WIDTH {
                own[k] = if own[0] < own[k] { own[0] } else { own[k] };
            }
            costs.reversed.push(own);
        }
        (costs, leaves_below)
    }
}
