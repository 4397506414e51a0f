//! Better trees by moving subtrees to where they cost less (Bittner et al. 2013, "Fast insertion-based optimization of
//! bounding volume hierarchies"; many at a time after Meister and Bittner 2018, "Parallel reinsertion for bounding
//! volume hierarchy optimization").

use super::filled;
use super::lanes::{Box4, Lanes};
use super::tree::Tree;
use eosphor_core::hierarchy::{BvhNode, MAX_BVH_DEPTH};
use rayon::prelude::*;

/// Box and the rest of a node: first child, or first and count of a leaf. 32 bytes: two SSE loads.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Item {
    low: [f32; 3],
    first: u32,
    high: [f32; 3],
    count: u32,
}

impl Item {
    fn new(n: &BvhNode) -> Item {
        let (l, h) = (n.min, n.max);
        Item { low: [l.x, l.y, l.z], first: n.first, high: [h.x, h.y, h.z], count: n.count }
    }

    #[inline(always)]
    fn box4(&self) -> Box4 {
        let pick = |v: &[f32; 3]| Lanes::new(v[0], v[1], v[2], 0.0);
        Box4 { low: pick(&self.low), high: pick(&self.high) }
    }

    #[inline(always)]
    fn set_box(&mut self, b: Box4) {
        let (l, h) = (b.low.array(), b.high.array());
        (self.low, self.high) = ([l[0], l[1], l[2]], [h[0], h[1], h[2]]);
    }

    #[inline(always)]
    fn is_inner(&self) -> bool {
        self.count == 0
    }
}

/// A node, where to put it, and what that saves.
#[derive(Clone, Copy)]
struct Move {
    node: u32,
    to: u32,
    gain: f32,
}

struct Reinsertion {
    items: Vec<Item>,
    parents: Vec<u32>,
}

fn env(n: &str, d: f32) -> f32 { std::env::var(n).map_or(d, |x| x.parse().unwrap()) }

/// Moves subtrees.
pub(super) fn optimize(tree: Tree) -> Tree {
    let rounds = env("RI_ROUNDS", 3.0) as usize;
    let share = env("RI_SHARE", 0.05) as f64;
    let n = tree.nodes.len();
    if n < 8 { return tree; }
    let mut work = Reinsertion { items: tree.nodes.iter().map(Item::new).collect(), parents: filled(0, n) };
    for (at, node) in tree.nodes.iter().enumerate().filter(|(_, n)| n.is_inner()) {
        work.parents[node.first as usize] = at as u32;
        work.parents[node.first as usize + 1] = at as u32;
    }
    let mut order: Vec<(u32, u32)> = Vec::new();
    let mut touched = filled(0u32, n);
    for round in 1..=rounds as u32 {
        // Areas are not negative, so their bits are in order.
        order.clear();
        order.extend((1..n as u32).map(|at| (work.items[at as usize].box4().half_area().to_bits(), at)));
        let count = ((n as f64 * share) as usize).clamp(1, n - 1);
        if count < order.len() {
            order.select_nth_unstable_by(count - 1, |a, b| b.cmp(a));
            order.truncate(count);
        }
        order.sort_unstable_by(|a, b| b.cmp(a));
        let mut moves: Vec<Move> =
            order.par_chunks(64).flat_map_iter(|c| { let mut stack = Vec::with_capacity(128); c.iter().filter_map(|o| work.search(o.1, &mut stack)).collect::<Vec<_>>() }).collect();
        moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.node.cmp(&b.node)));
        let (mut done, mut all) = (0, moves.len());
        for m in &moves {
            let (node, to) = (m.node, m.to);
            let parent = work.parents[node as usize];
            let places = [to, node, sibling(node), parent, work.parents[to as usize], work.parents[parent as usize]];
            if places.iter().any(|&p| touched[p as usize] == round) {
                continue;
            }
            for p in places { touched[p as usize] = round; }
            // It must not have come to lie below the node.
            let mut up = to;
            let mut below = false;
            while up != 0 { if up == node { below = true; break; } up = work.parents[up as usize]; }
            if below || to == parent || to == sibling(node) { continue; }
            work.apply(node, to);
            done += 1;
        }
        if std::env::var("RI_LOG").is_ok() { eprintln!("round {round}: {} candidates, {all} moves, {done} done", order.len()); }
    }
    work.finish(tree)
}

#[inline(always)]
fn sibling(node: u32) -> u32 {
    // Pairs begin at odd numbers: the root is 0.
    ((node - 1) ^ 1) + 1
}

impl Reinsertion {
    #[inline(always)]
    fn area(&self, at: u32) -> f32 {
        self.items[at as usize].box4().half_area()
    }

    fn search(&self, node: u32, stack: &mut Vec<(f32, u32)>) -> Option<Move> {
        let b = self.items[node as usize].box4();
        let own = b.half_area();
        let pivot = self.parents[node as usize];
        let mut parent = pivot;
        if parent == 0 { return None; }
        let mut other = sibling(node);
        let mut around = self.items[other as usize].box4();
        let mut gain = self.area(parent);
        let mut best = Move { node, to: 0, gain: 0.0 };
        let mut budget = 0;
        loop {
            stack.push((gain, other));
            while let Some((gain, at)) = stack.pop() {
                if gain - own <= best.gain { continue; }
                budget += 1;
                let item = &self.items[at as usize];
                let ib = item.box4();
                let left = gain - ib.union(b).half_area();
                if left > best.gain { best = Move { node, to: at, gain: left }; }
                if item.is_inner() {
                    let g = left + ib.half_area();
                    stack.push((g, item.first));
                    stack.push((g, item.first + 1));
                }
            }
            if parent == 0 { break; }
            if parent != pivot {
                around = around.union(self.items[other as usize].box4());
                gain += self.area(parent) - around.half_area();
            }
            other = sibling(parent);
            parent = self.parents[parent as usize];
        }
        let _ = budget;
        (best.to != 0 && best.to != sibling(node) && best.to != pivot).then_some(best)
    }

    fn apply(&mut self, node: u32, to: u32) {
        let (other, parent) = (sibling(node), self.parents[node as usize]);
        let (sibling_item, target) = (self.items[other as usize], self.items[to as usize]);
        let pair = node.min(other);
        // The sibling takes its parent's place, the target the sibling's, and its own becomes their parent.
        self.items[to as usize].first = pair;
        self.items[to as usize].count = 0;
        self.items[other as usize] = target;
        self.items[parent as usize] = sibling_item;
        if target.is_inner() {
            self.parents[target.first as usize] = other;
            self.parents[target.first as usize + 1] = other;
        }
        if sibling_item.is_inner() {
            self.parents[sibling_item.first as usize] = parent;
            self.parents[sibling_item.first as usize + 1] = parent;
        }
        self.parents[other as usize] = to;
        self.parents[node as usize] = to;
        self.refit(to);
        self.refit(self.parents[parent as usize]);
    }

    fn refit(&mut self, mut at: u32) {
        loop {
            let item = &self.items[at as usize];
            if item.is_inner() {
                let f = item.first as usize;
                let b = self.items[f].box4().union(self.items[f + 1].box4());
                self.items[at as usize].set_box(b);
            }
            if at == 0 { return; }
            at = self.parents[at as usize];
        }
    }

    /// Parents before children and leaves from left to right again.
    fn finish(self, tree: Tree) -> Tree {
        let mut nodes = Vec::with_capacity(self.items.len());
        let mut order = Vec::with_capacity(tree.order.len());
        nodes.push(BvhNode::EMPTY);
        let mut pending = vec![(0u32, 0usize, 1usize)];
        while let Some((from, to, depth)) = pending.pop() {
            if depth > MAX_BVH_DEPTH - 2 { return tree; }
            let item = &self.items[from as usize];
            let [x, y, z] = item.low;
            let [u, v, w] = item.high;
            use eosphor_core::math::vec3;
            let mut node = BvhNode { min: vec3(x, y, z), max: vec3(u, v, w), first: 0, count: item.count };
            if item.is_inner() {
                node.first = nodes.len() as u32;
                pending.push((item.first + 1, nodes.len() + 1, depth + 1));
                pending.push((item.first, nodes.len(), depth + 1));
                nodes.extend([BvhNode::EMPTY; 2]);
            } else {
                node.first = order.len() as u32;
                let count = (item.count & !BvhNode::SPHERES) as usize;
                order.extend_from_slice(&tree.order[item.first as usize..][..count]);
            }
            nodes[to] = node;
        }
        Tree { nodes, order }
    }
}
