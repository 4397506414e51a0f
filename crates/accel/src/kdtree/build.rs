//! The builder: top-down, parallel, with the same bytes for any number of threads.

use super::sah::{Split, best_split, cut};
use crate::cells::{Item, bounds_of, can_be_cut};
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::{KdNode, MAX_KD_DEPTH};

/// How a kd-tree is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdTreeOptions {
    /// Cost of visiting a node, in primitive tests. A smaller one makes smaller leaves.
    pub traversal_cost: f32,
    /// By which part a split becomes cheaper that cuts off empty space, 0 to 1.
    pub empty_bonus: f32,
    /// How many splits in a row may seem not to pay.
    pub patience: u32,
    /// Deepest leaf; 0 for 8 + 1.3 log2 of the number of primitives. Never over [`MAX_KD_DEPTH`] less 2.
    pub max_depth: u32,
    /// References may be this many times the primitives.
    pub max_duplication: f32,
}

impl Default for KdTreeOptions {
    fn default() -> KdTreeOptions {
        KdTreeOptions {
            traversal_cost: 1.5,
            empty_bonus: 0.2,
            patience: 1,
            max_depth: 0,
            max_duplication: 16.0,
        }
    }
}

/// Subtrees with more items than this are built by threads of their own.
const PARALLEL_ITEMS: usize = 2048;

enum Subtree {
    Leaf(Vec<Item>),
    Inner { axis: usize, plane: f32, children: Box<[Subtree; 2]> },
}

/// What is left to a subtree.
#[derive(Clone, Copy)]
struct Allowance {
    levels: u32,
    patience: u32,
    references: f64,
}

/// Builds over the items, of which there is at least one, and appends to the arrays.
pub(super) fn build_tree(
    items: Vec<Item>,
    options: &KdTreeOptions,
    nodes: &mut Vec<KdNode>,
    references: &mut Vec<u32>,
) {
    let bounds = bounds_of(&items);
    let count = items.len() as f64;
    let levels = match options.max_depth {
        0 => (8.0 + 1.3 * count.log2()) as u32,
        depth => depth,
    };
    let allowance = Allowance {
        levels: levels.min(MAX_KD_DEPTH as u32 - 2),
        patience: options.patience,
        references: count * options.max_duplication.max(1.0) as f64 + 1024.0,
    };
    let tree =
        if can_be_cut(&bounds) { build(items, &bounds, allowance, options) } else { Subtree::Leaf(items) };
    flatten(tree, nodes, references);
}

fn build(items: Vec<Item>, bounds: &Bounds, mut left: Allowance, options: &KdTreeOptions) -> Subtree {
    let count = items.len();
    if count <= 1 || left.levels == 0 {
        return Subtree::Leaf(items);
    }
    let Some(split) = best_split(&items, bounds, options) else { return Subtree::Leaf(items) };
    if split.cost >= count as f32 {
        // Wald and Havran 2006 stop here; a split that pays may still follow (Hunt 2006).
        if left.patience == 0 || (split.cost > 4.0 * count as f32 && count < 16) {
            return Subtree::Leaf(items);
        }
        left.patience -= 1;
    }
    let (lower, upper) = part(&items, &split);
    let sum = (lower.len() + upper.len()) as f64;
    if sum > left.references || (lower.len() == count && upper.len() == count) {
        return Subtree::Leaf(items);
    }
    drop(items);
    let (lower_bounds, upper_bounds) = cut(bounds, split.axis, split.plane);
    let share = |items: &[Item]| Allowance {
        levels: left.levels - 1,
        references: left.references * items.len() as f64 / sum,
        ..left
    };
    let (for_lower, for_upper) = (share(&lower), share(&upper));
    let build_lower = || build(lower, &lower_bounds, for_lower, options);
    let build_upper = || build(upper, &upper_bounds, for_upper, options);
    let (lower, upper) = if count > PARALLEL_ITEMS {
        rayon::join(build_lower, build_upper)
    } else {
        (build_lower(), build_upper())
    };
    Subtree::Inner { axis: split.axis, plane: split.plane, children: Box::new([lower, upper]) }
}

/// Items of the lower and of the upper child. What only touches the plane is on its own side, which is enough: see
/// `cell_ray.rs` in eosphor-core. What lies in the plane counts as below.
fn part(items: &[Item], split: &Split) -> (Vec<Item>, Vec<Item>) {
    let is_upper = |item: &&Item| item.bounds.max[split.axis] > split.plane;
    let is_lower = |item: &&Item| item.bounds.min[split.axis] < split.plane || !is_upper(item);
    let lower = || items.iter().filter(is_lower).copied().collect();
    let upper = || items.iter().filter(is_upper).copied().collect();
    if items.len() > 16 * PARALLEL_ITEMS { rayon::join(lower, upper) } else { (lower(), upper()) }
}

/// Depth first, the lower child right after its parent.
fn flatten(tree: Subtree, nodes: &mut Vec<KdNode>, references: &mut Vec<u32>) {
    // An upper child, and the parent that is to learn its number.
    let mut pending: Vec<(Subtree, Option<usize>)> = vec![(tree, None)];
    while let Some((mut tree, mut parent)) = pending.pop() {
        loop {
            if let Some(parent) = parent.take() {
                let KdNode { plane_or_first, kind } = nodes[parent];
                nodes[parent] = KdNode { plane_or_first, kind: kind | (nodes.len() as u32) << 2 };
            }
            match tree {
                Subtree::Leaf(items) => {
                    nodes.push(KdNode::leaf(references.len() as u32, items.len() as u32));
                    references.extend(items.iter().map(|item| item.reference));
                    break;
                }
                Subtree::Inner { axis, plane, children } => {
                    let [lower, upper] = *children;
                    pending.push((upper, Some(nodes.len())));
                    nodes.push(KdNode::inner(axis, plane, 0));
                    tree = lower;
                }
            }
        }
    }
}
