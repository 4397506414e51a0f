//! Trees while they are built: in pieces, so that threads do not have to agree on anything.

use super::lanes::Box4;
use super::memory::filled;
use super::reference::Reference;
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::BvhNode;
use rayon::prelude::*;

/// A tree: the root is node 0, children stand in pairs behind their parent, leaves name ranges of `order`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    /// Leaves of spheres have [`BvhNode::SPHERES`] set in their count.
    pub(crate) nodes: Vec<BvhNode>,
    /// Numbers of primitives, in the order of the leaves. Empty where each leaf names a place of its own: its block.
    pub(crate) order: Vec<u32>,
}

/// Trees of more references than this are built in pieces of at most so many, each by one thread.
pub(super) const PIECE_ITEMS: usize = 8192;

/// A subtree on its way into the whole.
pub(crate) enum Piece {
    /// Built by one thread; its numbers count from its own start.
    Whole(Tree),
    /// Box and children.
    Split(Bounds, Box<[Piece; 2]>),
}

impl Tree {
    /// A tree of one node still to be filled in, which will have about so many leaves.
    pub(super) fn with_leaves(leaves: usize) -> Tree {
        let mut nodes = Vec::with_capacity(2 * leaves);
        nodes.push(BvhNode::EMPTY);
        Tree { nodes, order: Vec::new() }
    }

    /// Every inner node has two children.
    #[inline(always)]
    pub(crate) fn leaf_count(&self) -> usize {
        self.nodes.len() / 2 + 1
    }

    /// How many places the leaves name.
    fn places(&self) -> usize {
        if self.order.is_empty() { self.leaf_count() } else { self.order.len() }
    }

    /// A tree of one node still to be filled in.
    pub(super) fn with_root(items: usize) -> Tree {
        let mut nodes = Vec::with_capacity(items + 1);
        nodes.push(BvhNode::EMPTY);
        Tree { nodes, order: Vec::with_capacity(items) }
    }

    /// Makes a node a leaf.
    #[inline(always)]
    pub(super) fn set_leaf(&mut self, at: usize, bounds: Box4, references: &[Reference], spheres: bool) {
        let Bounds { min, max } = bounds.bounds();
        let kind = if spheres { BvhNode::SPHERES } else { 0 };
        let first = self.order.len() as u32;
        self.nodes[at] = BvhNode { min, first, max, count: references.len() as u32 | kind };
        self.order.extend(references.iter().map(Reference::index));
    }

    #[inline(always)]
    pub(super) fn set_bounds(&mut self, at: usize, bounds: Box4) {
        let node = &mut self.nodes[at];
        Bounds { min: node.min, max: node.max } = bounds.bounds();
    }

    /// Makes a node an inner one; returns the place of the first of its two children, still to be filled in.
    #[inline(always)]
    pub(super) fn set_inner(&mut self, at: usize, bounds: Box4) -> usize {
        let pair = self.nodes.len();
        let Bounds { min, max } = bounds.bounds();
        self.nodes[at] = BvhNode { min, first: pair as u32, max, count: 0 };
        self.nodes.extend([BvhNode::EMPTY; 2]);
        pair
    }
}

impl Piece {
    /// Joins the pieces: a depth-first walk over them, each piece's nodes together.
    pub(crate) fn join(self) -> Tree {
        let piece = match self {
            Piece::Whole(tree) => return tree,
            piece => piece,
        };
        let mut plan = Plan { top: vec![(0, BvhNode::EMPTY)], parts: Vec::new(), nodes: 1, places: 0 };
        plan.add(piece, 0);
        let in_order = plan.parts.iter().map(|part| part.tree.order.len()).sum();
        let mut tree = Tree { nodes: filled(BvhNode::EMPTY, plan.nodes), order: filled(0, in_order) };
        for (at, node) in &plan.top {
            tree.nodes[*at] = *node;
        }
        let mut work = Vec::with_capacity(plan.parts.len());
        let (mut nodes, mut order) = (&mut tree.nodes[..], &mut tree.order[..]);
        let mut done = 0;
        for part in plan.parts {
            // Between the parts lie pairs of the top.
            let (_, rest) = nodes.split_at_mut(part.first_node - done);
            let (own_nodes, rest) = rest.split_at_mut(part.tree.nodes.len() - 1);
            done = part.first_node + own_nodes.len();
            nodes = rest;
            let (own_order, rest) = order.split_at_mut(part.tree.order.len());
            order = rest;
            work.push((part, own_nodes, own_order));
        }
        let roots: Vec<(usize, BvhNode)> = work
            .into_par_iter()
            .map(|(part, nodes, order)| {
                order.copy_from_slice(&part.tree.order);
                for (to, from) in nodes.iter_mut().zip(&part.tree.nodes[1..]) {
                    *to = part.moved(from);
                }
                (part.root, part.moved(&part.tree.nodes[0]))
            })
            .collect();
        for (at, node) in roots {
            tree.nodes[at] = node;
        }
        tree
    }
}

/// Where pieces go.
struct Plan {
    /// Inner nodes above the parts, and their places.
    top: Vec<(usize, BvhNode)>,
    parts: Vec<Part>,
    nodes: usize,
    places: usize,
}

struct Part {
    tree: Tree,
    /// Place of its root.
    root: usize,
    /// Place of its second node.
    first_node: usize,
    /// The first place that its leaves name.
    first_place: usize,
}

impl Part {
    #[inline(always)]
    fn moved(&self, node: &BvhNode) -> BvhNode {
        let shift = if node.is_inner() { self.first_node as u32 - 1 } else { self.first_place as u32 };
        BvhNode { first: node.first + shift, ..*node }
    }
}

impl Plan {
    /// Recursion is as deep as the tree, which is bounded.
    fn add(&mut self, piece: Piece, at: usize) {
        match piece {
            Piece::Whole(tree) => {
                let part = Part { root: at, first_node: self.nodes, first_place: self.places, tree };
                self.nodes += part.tree.nodes.len() - 1;
                self.places += part.tree.places();
                self.parts.push(part);
            }
            Piece::Split(Bounds { min, max }, children) => {
                let pair = self.nodes;
                self.nodes += 2;
                self.top.push((at, BvhNode { min, first: pair as u32, max, count: 0 }));
                let [left, right] = *children;
                self.add(left, pair);
                self.add(right, pair + 1);
            }
        }
    }
}
