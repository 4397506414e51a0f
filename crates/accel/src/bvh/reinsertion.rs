//! Nodes that stand where they cost much are taken out and put where they cost least (Bittner et al. 2013, "Fast
//! insertion-based optimization of bounding volume hierarchies"; the search as in Meister and Bittner 2018,
//! "Parallel reinsertion for bounding volume hierarchy optimization").
//!
//! What is built from the root down is decided before anything below is known. A long beam that was put on one side of a plane
//! makes all boxes on its way down larger than they have to be; here it finds a place beside others of its kind.

use super::memory::{filled, room_for};
use super::tree::Tree;
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::BvhNode;

/// How many nodes are moved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// One of so many nodes is looked at, the largest ones.
    pub(super) share: usize,
    /// And no more than so many: one thread does it.
    pub(super) most: usize,
}

/// All of the largest nodes are looked at so many times at most.
const ROUNDS: usize = 4;

/// So many nodes are looked at, largest first, before it is asked again whether that pays.
const GROUP: usize = 512;

/// It pays while at least one of so many has moved in this round. (Of scanned surfaces one of 100 does, of rooms one of 5.)
const PAYING: usize = 32;

/// A search looks at so many places. It begins near the node; without a bound, boxes that all overlap would
/// make it look everywhere.
const MOST_PLACES: usize = 1024;

/// A tree whose nodes are being moved.
struct Reinsertion {
    nodes: Vec<BvhNode>,
    /// For each pair of children, by the half of the first one's number, their parent.
    parents: Vec<u32>,
    /// Nodes that were put elsewhere, and the places whose content was beside them before.
    moved: Vec<(u32, u32)>,
    /// Places that a search has still to look at, and what is gained before the node is put there.
    pending: Vec<(f32, u32)>,
}

impl Tree {
    /// Takes out large nodes and puts each where the tree's boxes become smallest. Leaves lie no deeper than
    /// `max_depth` if they did not before.
    pub(super) fn reinserted(self, effort: Effort, max_depth: usize) -> Tree {
        let area = self.nodes[0].bounds().half_area();
        if self.nodes.len() < 8 || !(area > 0.0 && area < f32::MAX) {
            return self;
        }
        let Tree { nodes, order } = self;
        let mut reinsertion = Reinsertion::of(nodes);
        for _ in 0..ROUNDS {
            let largest = reinsertion.largest(effort);
            let (mut looked_at, moved_before) = (0, reinsertion.moved.len());
            let pays = largest.chunks(GROUP).all(|group| {
                reinsertion.move_nodes(group);
                looked_at += group.len();
                (reinsertion.moved.len() - moved_before) * PAYING >= looked_at
            });
            if !pays {
                break;
            }
        }
        if reinsertion.moved.is_empty() {
            return Tree { nodes: reinsertion.nodes, order };
        }
        let nodes = reinsertion.in_order(max_depth).unwrap_or_else(|| {
            reinsertion.undo();
            reinsertion.in_order(usize::MAX).expect("a tree")
        });
        Tree { nodes, order }
    }
}

impl Reinsertion {
    fn of(nodes: Vec<BvhNode>) -> Reinsertion {
        let mut parents = filled(0, nodes.len() / 2 + 1);
        for (at, node) in nodes.iter().enumerate().filter(|(_, n)| n.is_inner()) {
            parents[node.first as usize / 2] = at as u32;
        }
        Reinsertion { nodes, parents, moved: Vec::new(), pending: Vec::new() }
    }

    /// The largest nodes but the root, largest first.
    fn largest(&self, effort: Effort) -> Vec<u32> {
        // Areas are not below 0, so their bits are in the same order.
        let key = |(at, node): (usize, &BvhNode)| (!node.bounds().half_area().to_bits(), at as u32);
        let mut keys: Vec<(u32, u32)> = self.nodes.iter().enumerate().skip(1).map(key).collect();
        let count = (keys.len() / effort.share).clamp(1, effort.most).min(keys.len() - 1);
        keys.select_nth_unstable(count);
        keys.truncate(count);
        keys.sort_unstable();
        keys.into_iter().map(|(_, at)| at).collect()
    }

    /// Puts each of these nodes where it costs least.
    fn move_nodes(&mut self, group: &[u32]) {
        for &node in group {
            if let Some(beside) = self.best_place(node) {
                self.moved.push((node, self.parent(node)));
                self.put(node, beside);
            }
        }
    }

    fn parent(&self, node: u32) -> u32 {
        self.parents[(node as usize - 1) / 2]
    }

    fn sibling(node: u32) -> u32 {
        ((node - 1) ^ 1) + 1
    }

    fn bounds(&self, node: u32) -> Bounds {
        self.nodes[node as usize].bounds()
    }

    /// The node that another one is best put beside, if the areas of all boxes become smaller together.
    fn best_place(&mut self, node: u32) -> Option<u32> {
        let bounds = self.bounds(node);
        let least = bounds.half_area();
        let parent = self.parent(node);
        let (mut best, mut best_gain) = (0, 0.0f32);
        let mut places = MOST_PLACES;
        self.pending.clear();
        // Without the node its parent is gone, and boxes above may shrink to what is left.
        let mut gained = self.bounds(parent).half_area();
        let mut left = self.bounds(Self::sibling(node));
        let (mut from, mut pivot) = (Self::sibling(node), parent);
        loop {
            self.pending.push((gained, from));
            while let Some((gained, at)) = self.pending.pop() {
                if gained - least <= best_gain {
                    continue;
                }
                if places == 0 {
                    break;
                }
                places -= 1;
                let other = &self.nodes[at as usize];
                let gain = gained - other.bounds().union(&bounds).half_area();
                if gain > best_gain {
                    (best, best_gain) = (at, gain);
                }
                if other.is_inner() {
                    let below = gain + other.bounds().half_area();
                    if below - least > best_gain {
                        self.pending.extend([(below, other.first), (below, other.first + 1)]);
                    }
                }
            }
            if pivot == 0 || places == 0 {
                break;
            }
            if pivot != parent {
                left = left.union(&self.bounds(from));
                gained += self.bounds(pivot).half_area() - left.half_area();
            }
            from = Self::sibling(pivot);
            pivot = self.parent(pivot);
        }
        let stays = best == 0 || best == Self::sibling(node) || best == parent;
        (!stays).then_some(best)
    }

    /// Puts a node beside another one, of which it is no ancestor and which is not its parent or sibling.
    fn put(&mut self, node: u32, beside: u32) {
        let (parent, sibling) = (self.parent(node), Self::sibling(node));
        let pair = self.nodes[parent as usize].first;
        self.put_content(parent, self.nodes[sibling as usize]);
        self.put_content(sibling, self.nodes[beside as usize]);
        self.nodes[beside as usize].first = pair;
        self.nodes[beside as usize].count = 0;
        self.parents[pair as usize / 2] = beside;
        self.fit(parent);
        self.fit(beside);
    }

    fn put_content(&mut self, at: u32, content: BvhNode) {
        self.nodes[at as usize] = content;
        if content.is_inner() {
            self.parents[content.first as usize / 2] = at;
        }
    }

    /// Boxes from here to the root.
    fn fit(&mut self, mut at: u32) {
        loop {
            let node = self.nodes[at as usize];
            if node.is_inner() {
                let Bounds { min, max } = self.bounds(node.first).union(&self.bounds(node.first + 1));
                self.nodes[at as usize] = BvhNode { min, max, ..node };
            }
            if at == 0 {
                return;
            }
            at = self.parent(at);
        }
    }

    /// Puts all nodes back.
    fn undo(&mut self) {
        while let Some((node, beside)) = self.moved.pop() {
            self.put(node, beside);
        }
    }

    /// The nodes with each one's children behind it, depth first; `None` where leaves lie deeper than `max_depth`.
    fn in_order(&self, max_depth: usize) -> Option<Vec<BvhNode>> {
        let mut ordered = room_for(self.nodes.len());
        ordered.push(self.nodes[0]);
        // Nodes of `ordered` whose children are still to come, and the depth of the children.
        let mut pending = vec![(0, 1)];
        while let Some((at, depth)) = pending.pop() {
            let node: BvhNode = ordered[at];
            if !node.is_inner() {
                continue;
            }
            if depth > max_depth {
                return None;
            }
            let pair = ordered.len();
            ordered.extend_from_slice(&self.nodes[node.first as usize..][..2]);
            ordered[at].first = pair as u32;
            pending.extend([(pair + 1, depth + 1), (pair, depth + 1)]);
        }
        Some(ordered)
    }
}

#[cfg(test)]
mod tests {
    use super::{Effort, Reinsertion, Tree};
    use crate::bvh::{BuildOptions, Builder, Purpose, geometry_tree};
    use crate::{Scene, Vec3, vec3};
    use eosphor_core::geometry::Bounds;
    use eosphor_core::hierarchy::BvhNode;
    use proptest::prelude::*;

    const ALL: Effort = Effort { share: 1, most: usize::MAX };

    fn tree_over(triangles: &[[Vec3; 3]]) -> Tree {
        let scene = Scene::new(triangles, &[]).unwrap();
        let geometry = scene.geometry();
        let options = BuildOptions { reinsertion: false, ..BuildOptions::of(Builder::Median) };
        geometry_tree(&geometry, &geometry.geometries()[0], &options, Purpose::Eight)
    }

    fn area(tree: &Tree) -> f64 {
        tree.nodes.iter().map(|node| f64::from(node.bounds().half_area())).sum()
    }

    /// Leaves by their first place, and how deep the deepest is. Every box is that around its children, which stand behind it.
    fn leaves(nodes: &[BvhNode]) -> (Vec<(u32, u32)>, usize) {
        let mut depths = vec![0; nodes.len()];
        let mut found = Vec::new();
        for (at, node) in nodes.iter().enumerate() {
            if !node.is_inner() {
                found.push((node.first, node.count));
                continue;
            }
            let pair = node.first as usize;
            assert!(pair > at && pair % 2 == 1);
            let around = nodes[pair].bounds().union(&nodes[pair + 1].bounds());
            assert_eq!((around.min, around.max), (node.min, node.max));
            let below = depths[at] + 1;
            depths[pair..pair + 2].fill(below);
        }
        found.sort_unstable();
        (found, depths.into_iter().max().unwrap())
    }

    fn needle(at: Vec3, along: Vec3) -> [Vec3; 3] {
        [at, at + along, at + vec3(0.01, 0.01, 0.01)]
    }

    #[test]
    fn a_beam_leaves_the_crumbs() {
        // Two heaps far apart, and twenty beams over both, whose middles lie in the heaps.
        let crumbs = (0..200).map(|i| {
            let (x, k) = ((i % 2) as f32 * 100.0, i as f32);
            needle(vec3(x + k % 7.0, k % 11.0, k % 13.0), vec3(0.1, 0.0, 0.0))
        });
        let beams = (0..20).map(|i| needle(vec3(-95.0, 0.5 * i as f32, 0.0), vec3(200.0, 0.0, 0.0)));
        let before = tree_over(&crumbs.chain(beams).collect::<Vec<_>>());
        let (had, cost) = (leaves(&before.nodes), area(&before));
        let after = before.reinserted(ALL, 64);
        assert_eq!(leaves(&after.nodes).0, had.0);
        assert!(area(&after) < 0.7 * cost, "{} {cost}", area(&after));
    }

    #[test]
    fn trees_that_would_become_too_deep_stay() {
        let triangles: Vec<_> =
            (0..64).map(|i| needle(Vec3::ZERO, vec3(1.0, 2.0, 3.0) * 1.2f32.powi(i % 32))).collect();
        let before = tree_over(&triangles);
        let free = before.clone().reinserted(ALL, 64);
        assert_ne!(format!("{:?}", free.nodes), format!("{:?}", before.nodes));
        let bound = before.clone().reinserted(ALL, leaves(&free.nodes).1 - 1);
        assert_eq!(format!("{:?}", bound.nodes), format!("{:?}", before.nodes));
    }

    proptest! {
        #[test]
        fn no_leaf_is_lost_and_boxes_become_smaller(
            corners in prop::collection::vec((0.0f32..9.0, 0.0f32..9.0, 0.0f32..9.0, 0.0f32..1.0), 20..400)
        ) {
            let triangles: Vec<_> =
                corners.iter().map(|&(x, y, z, s)| needle(vec3(x, y, z), vec3(z, x, y) * s.powi(4))).collect();
            let before = tree_over(&triangles);
            let (had, cost) = (leaves(&before.nodes), area(&before));
            let mut undone = Reinsertion::of(before.nodes.clone());
            undone.move_nodes(&undone.largest(ALL));
            undone.undo();
            prop_assert_eq!(format!("{:?}", undone.nodes), format!("{:?}", before.nodes));
            let after = before.reinserted(ALL, 64);
            prop_assert_eq!(leaves(&after.nodes).0, had.0);
            prop_assert!(area(&after) <= cost * (1.0 + 1e-6));
            let whole: Bounds = after.nodes[0].bounds();
            prop_assert!(whole.half_area() > 0.0);
        }
    }
}
