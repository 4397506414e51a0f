//! The first levels of a tree of lights, for points that choose many lights each.
//!
//! All ways through these levels are followed once for a point: which of the numbers in [0, 1) lead where, and how likely that is.
//! The way for a number then starts where bisection says, with the bits of the way from the root.

use super::tree::{ChosenLight, LightNode, LightReceiver, LightTree, share_of_first};
use super::tree_lanes::{DescentLanes, NodeLanes};

/// Nodes of the first five levels, and one that is not used.
const INNER: usize = 32;
/// Nodes of the sixth level, where ways go on.
const EXITS: usize = 32;

/// The first levels of a tree. Children of node `k` are nodes `2 k + 1` and `2 k + 2`; a light that comes earlier than the last
/// level is its own first child, which is always taken.
pub struct TreeTop {
    first: NodeLanes<INNER>,
    second: NodeLanes<INNER>,
    /// [`LightNode::first_chance`].
    first_chance: [f32; INNER],
    /// Nodes of the tree.
    exits: [u32; EXITS],
}

/// What numbers lead to for one receiver.
#[derive(Clone, Copy, Debug)]
pub struct TopWays {
    /// Where the numbers of each exit begin, in ascending order; with the next ones where none lead there.
    low: [f64; EXITS],
    /// How likely each exit is; 0 where nothing reaches the receiver from there.
    chance: [f64; EXITS],
}

impl TreeTop {
    /// Of a tree.
    #[inline]
    pub fn new(tree: &LightTree) -> TreeTop {
        let (mut first, mut second) = ([LightNode::NONE; INNER], [LightNode::NONE; INNER]);
        let mut first_chance = [1.0; INNER];
        let mut numbers = [0; INNER + EXITS];
        for k in 0..INNER - 1 {
            let number = numbers[k];
            if let Some((parent, [a, b])) = with_children(tree, number) {
                (first[k], second[k]) = (*a, *b);
                first_chance[k] = parent.first_chance;
                (numbers[2 * k + 1], numbers[2 * k + 2]) = (parent.children, parent.children + 1);
            } else {
                (numbers[2 * k + 1], numbers[2 * k + 2]) = (number, number);
            }
        }
        let mut exits = [0; EXITS];
        exits.copy_from_slice(&numbers[INNER - 1..][..EXITS]);
        TreeTop { first: NodeLanes::new(&first), second: NodeLanes::new(&second), first_chance, exits }
    }

    /// All ways through these levels.
    #[inline(always)]
    pub fn ways(&self, receiver: &LightReceiver) -> TopWays {
        let (mut share, mut is_reached) = ([0.0; INNER], [false; INNER]);
        for k in 0..INNER {
            let promised = [self.first.importance(k, receiver), self.second.importance(k, receiver)];
            (share[k], is_reached[k]) = share_of_first(promised);
        }
        let mut low = [0.0; INNER + EXITS];
        let mut chance = [1.0; INNER + EXITS];
        let mut is_possible = [true; INNER + EXITS];
        for k in 0..INNER - 1 {
            let is_fixed = self.first_chance[k] >= 0.0;
            let of_first = (if is_fixed { self.first_chance[k] } else { share[k] }) as f64;
            let here = if is_fixed | is_reached[k] { chance[k] } else { 0.0 };
            let (a, b) = (2 * k + 1, 2 * k + 2);
            (low[a], low[b]) = (low[k], low[k] + here * of_first);
            (chance[a], chance[b]) = (here * of_first, here * (1.0 - of_first));
            is_possible[a] = is_possible[k] & (of_first > 0.0);
            is_possible[b] = is_possible[k] & (of_first < 1.0);
        }
        let mut ways = TopWays { low: [0.0; EXITS], chance: [0.0; EXITS] };
        let mut next = f64::INFINITY;
        for exit in (0..EXITS).rev() {
            let k = INNER - 1 + exit;
            next = if is_possible[k] { low[k] } else { next };
            (ways.low[exit], ways.chance[exit]) = (next, chance[k]);
        }
        ways
    }
}

impl TopWays {
    /// Ways that lead nowhere.
    pub const NONE: TopWays = TopWays { low: [0.0; EXITS], chance: [0.0; EXITS] };

    /// The exit for a number.
    #[inline(always)]
    fn exit(&self, u: f64) -> usize {
        let mut exit = 0;
        let mut step = EXITS / 2;
        while step > 0 {
            exit += if self.low[exit + step] <= u { step } else { 0 };
            step /= 2;
        }
        exit
    }
}

impl LightTree<'_> {
    /// As [`LightTree::choose_lanes`], with the ways of each lane through the tree's first levels.
    #[inline(always)]
    pub fn choose_lanes_from<const W: usize>(
        &self,
        top: &TreeTop,
        ways: &[TopWays; W],
        is_wanted: &[bool; W],
        receiver: impl Fn(usize) -> LightReceiver,
        u: &[f64; W],
    ) -> [Option<ChosenLight>; W] {
        let mut from = DescentLanes { node: [0; W], chance: [0.0; W], low: [0.0; W] };
        let mut is_reached = [false; W];
        for lane in 0..W {
            let exit = ways[lane].exit(u[lane]) % EXITS;
            from.node[lane] = top.exits[exit];
            from.low[lane] = ways[lane].low[exit];
            from.chance[lane] = ways[lane].chance[exit];
            is_reached[lane] = is_wanted[lane] & (from.chance[lane] > 0.0);
        }
        self.descend_lanes_from(&is_reached, receiver, u, from)
    }
}

/// An inner node of the tree and its children, which come after it.
#[inline(always)]
fn with_children<'a>(tree: &LightTree<'a>, number: u32) -> Option<(&'a LightNode, &'a [LightNode; 2])> {
    let node = tree.nodes.get(number as usize)?;
    let children = tree.nodes.get(node.children as usize..)?.first_chunk()?;
    (node.children > number && !node.is_leaf()).then_some((node, children))
}
