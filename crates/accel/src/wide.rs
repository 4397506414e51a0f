//! A bounding volume hierarchy with eight children a node and boxes of 8 bits a plane, as GPUs read it.

use crate::pairs::Counts;
use crate::{Bvh, BvhPairs};
use eosphor_core::device::{BvhPair, Link, PAIR_SLACK, Root, Target, WideNode, WideTracer, WideView};
use eosphor_core::math::{Vec3, vec3};

/// Children of a node.
const WIDTH: usize = 8;

/// The largest number that a plane can have.
const LAST_PLANE: f64 = 255.0;

/// No box is so large: the one of trees that are a leaf, where the box of that is not known.
const BEYOND: f64 = (1u64 << 60) as f64;

/// The trees of [`BvhPairs`] with eight children a node and boxes of 8 bits a plane, as GPUs read them. Primitives stay where they
/// are.
#[derive(Clone, Debug)]
pub struct BvhWide {
    nodes: Vec<WideNode>,
    /// For each geometry, the number of its root.
    roots: Vec<Root<u32>>,
    /// The root of the tree over the instances but the world.
    instance_root: u32,
    /// Numbers in nodes are below these.
    counts: Counts,
}

impl BvhWide {
    /// Makes the wide trees of pairs; `None` where there are more nodes than can be numbered.
    pub fn new(pairs: &BvhPairs) -> Option<BvhWide> {
        let mut nodes = Vec::with_capacity(pairs.pairs.len() / 4 + pairs.roots.len() + 1);
        let mut tree = |root| convert(&pairs.pairs, root, 0, &mut nodes);
        let roots =
            pairs.roots.iter().map(|root| Root { first: tree(root.first), reach: root.reach }).collect();
        let instance_root = tree(pairs.instance_root);
        (nodes.len() <= WideNode::MOST).then_some(BvhWide {
            nodes,
            roots,
            instance_root,
            counts: pairs.counts,
        })
    }

    /// These trees with `nodes` empty nodes more, room for trees over instances that are built later; `None` where the nodes
    /// would be more than [`WideNode::MOST`].
    pub fn with_room(mut self, nodes: usize) -> Option<BvhWide> {
        self.nodes.resize(self.nodes.len() + nodes, EMPTY);
        (self.nodes.len() <= WideNode::MOST).then_some(self)
    }

    /// The tree over the instances of a hierarchy that was built over these alone, for an array in which it begins at number
    /// `first`, and its root. It is made of the pairs and the root of [`BvhPairs::over_instances`] with `first` 0. There are no
    /// more nodes than instances.
    pub fn over_instances(pairs: &[BvhPair], root: Link, first: u32) -> (Vec<WideNode>, u32) {
        let mut nodes = Vec::new();
        let root = convert(pairs, root, first, &mut nodes);
        (nodes, root)
    }

    /// Nodes of all trees.
    pub fn nodes(&self) -> &[WideNode] {
        &self.nodes
    }

    /// For each geometry, the number of its root.
    pub fn roots(&self) -> &[Root<u32>] {
        &self.roots
    }

    /// The arrays of the trees, borrowed, with those of the hierarchy that the pairs were made from.
    ///
    /// # Panics
    /// Where `bvh` is another one, or was built over instances alone.
    pub fn view<'a>(&'a self, bvh: &'a Bvh) -> WideView<'a> {
        self.counts.check(bvh);
        let &BvhWide { ref nodes, ref roots, instance_root, .. } = self;
        WideView { nodes, roots, instance_root, primitives: bvh.primitives.view() }
    }

    /// The traversal of GPUs, one ray at a time. On a CPU it is for tests: [`crate::Bvh8`] is faster.
    pub fn tracer<'a>(&'a self, bvh: &'a Bvh) -> WideTracer<'a, true> {
        // SAFETY: closed view: the fields are private, and builders make them so; `view` checks that they belong together.
        unsafe { WideTracer::new(self.view(bvh)) }
    }
}

/// A child and the least and the greatest corner of its box.
#[derive(Clone, Copy)]
struct Child {
    link: Link,
    low: [f64; 3],
    high: [f64; 3],
}

impl Child {
    fn new(center: Vec3, half: Vec3, link: Link) -> Child {
        let corner = |sign: f64| {
            let at = |c: f32, h: f32| f64::from(c) + sign * f64::from(h);
            [at(center.x, half.x), at(center.y, half.y), at(center.z, half.z)]
        };
        Child { link, low: corner(-1.0), high: corner(1.0) }
    }

    fn both(pair: &BvhPair) -> [Child; 2] {
        [Child::new(pair.center0, pair.half0, pair.link0), Child::new(pair.center1, pair.half1, pair.link1)]
    }

    fn half_area(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.high[axis] - self.low[axis]);
        x * y + y * z + z * x
    }
}

/// A tree; returns the number of its root, where the first of the nodes has the number `first`. The nodes below a node stand
/// together.
fn convert(pairs: &[BvhPair], root: Link, first: u32, nodes: &mut Vec<WideNode>) -> u32 {
    let number = nodes.len();
    let children = match root.target() {
        Target::Node(pair) => collapsed(pairs, pair),
        _ => vec![Child { link: root, low: [-BEYOND; 3], high: [BEYOND * 0.98; 3] }],
    };
    nodes.push(EMPTY);
    let mut waiting = vec![(number, children)];
    while let Some((number, children)) = waiting.pop() {
        let places = places(&children);
        let mut node = packed(&children, &places);
        for (child, &place) in children.iter().zip(&places) {
            if let Target::Node(pair) = child.link.target() {
                node.links[place] = Link::pair(first + nodes.len() as u32);
                waiting.push((nodes.len(), collapsed(pairs, pair)));
                nodes.push(EMPTY);
            }
        }
        nodes[number] = node;
    }
    first + number as u32
}

/// Up to eight nodes below a pair: the largest one is opened as long as there is room.
fn collapsed(pairs: &[BvhPair], pair: u32) -> Vec<Child> {
    let mut children = Child::both(&pairs[pair as usize]).to_vec();
    while children.len() < WIDTH {
        let open = children.iter().enumerate().filter_map(|(at, child)| match child.link.target() {
            Target::Node(pair) => Some((at, pair, child.half_area())),
            _ => None,
        });
        let Some((at, pair, _)) = open.max_by(|a, b| a.2.total_cmp(&b.2)) else { break };
        let [first, second] = Child::both(&pairs[pair as usize]);
        children[at] = first;
        children.push(second);
    }
    children.retain(|child| child.link != Link::NOTHING);
    children
}

/// Where each child stands: the one that lies most in the direction of a corner first.
fn places(children: &[Child]) -> Vec<usize> {
    let middle = |child: &Child| [0, 1, 2].map(|axis| 0.5 * (child.low[axis] + child.high[axis]));
    let middles: Vec<[f64; 3]> = children.iter().map(middle).collect();
    let count = children.len().max(1) as f64;
    let center = [0, 1, 2].map(|axis| middles.iter().map(|m| m[axis]).sum::<f64>() / count);
    let mut wishes: Vec<(f64, usize, usize)> = Vec::with_capacity(children.len() * WIDTH);
    for (child, middle) in middles.iter().enumerate() {
        for place in 0..WIDTH {
            let along = |axis: usize| (middle[axis] - center[axis]) * [-1.0, 1.0][place >> axis & 1];
            wishes.push((along(0) + along(1) + along(2), child, place));
        }
    }
    wishes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut places = vec![WIDTH; children.len()];
    let mut taken = [false; WIDTH];
    for (_, child, place) in wishes {
        if places[child] == WIDTH && !taken[place] {
            (places[child], taken[place]) = (place, true);
        }
    }
    places
}

/// Without children.
const EMPTY: WideNode =
    WideNode { origin: Vec3::ZERO, exponents: 0x010101, planes: [[[0; 2]; 2]; 3], links: [Link::NOTHING; 8] };

/// The boxes on a grid of 256 planes along each axis, each no smaller than it is.
fn packed(children: &[Child], places: &[usize]) -> WideNode {
    let mut node = EMPTY;
    let (mut origin, mut exponents) = ([0f32; 3], 0);
    for axis in 0..3 {
        let least = children.iter().map(|child| child.low[axis]).fold(f64::INFINITY, f64::min);
        let greatest = children.iter().map(|child| child.high[axis]).fold(f64::NEG_INFINITY, f64::max);
        // Rays measure from the corner of the grid: its rounding is that of all children.
        let margin = f64::from(PAIR_SLACK) * least.abs().max(greatest.abs());
        let (least, greatest) = (least - margin, greatest + margin);
        // Rounded down.
        let nearest = least as f32;
        origin[axis] = if f64::from(nearest) > least { nearest.next_down() } else { nearest };
        let start = f64::from(origin[axis]);
        // As in floats: 2^(exponent - 127).
        let step = |exponent: u32| f64::from(f32::from_bits(exponent << 23));
        let exponent = (1..254).find(|&e| start + LAST_PLANE * step(e) >= greatest).unwrap_or(254);
        exponents |= exponent << (8 * axis);
        for (child, &place) in children.iter().zip(places) {
            let plane = |at: f64| (at - start) / step(exponent);
            let (first, last) =
                (plane(child.low[axis] - margin).floor(), plane(child.high[axis] + margin).ceil());
            for (side, number) in [first, last].into_iter().enumerate() {
                let byte = number.clamp(0.0, LAST_PLANE) as u32;
                node.planes[axis][side][place / 4] |= byte << (8 * (place % 4));
            }
        }
    }
    for (child, &place) in children.iter().zip(places) {
        node.links[place] = child.link;
        exponents |= 1 << (24 + place);
    }
    node.origin = vec3(origin[0], origin[1], origin[2]);
    node.exponents = exponents;
    node
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn corner() -> impl Strategy<Value = [f64; 3]> {
        let coordinate = prop_oneof![-1e12f32..1e12, -1.0f32..1.0, Just(0.0), -1e-30f32..1e-30];
        [coordinate.clone(), coordinate.clone(), coordinate].prop_map(|corner| corner.map(f64::from))
    }

    proptest! {
        /// Every child has a place of its own, and the box that it is found by holds its own.
        #[test]
        fn packed_boxes_hold_the_boxes(corners in proptest::collection::vec((corner(), corner()), 1..=8)) {
            let child = |(number, (a, b)): (usize, &([f64; 3], [f64; 3]))| Child {
                link: Link::triangles(number as u32, 1),
                low: [0, 1, 2].map(|axis| a[axis].min(b[axis])),
                high: [0, 1, 2].map(|axis| a[axis].max(b[axis])),
            };
            let children: Vec<Child> = corners.iter().enumerate().map(child).collect();
            let places = places(&children);
            let node = packed(&children, &places);
            prop_assert_eq!((node.exponents >> 24).count_ones() as usize, children.len());
            let origin = [node.origin.x, node.origin.y, node.origin.z].map(f64::from);
            for (child, &place) in children.iter().zip(&places) {
                prop_assert_eq!(node.links[place], child.link);
                for axis in 0..3 {
                    let step = f64::from(f32::from_bits((node.exponents >> (8 * axis) & 255) << 23));
                    let plane = |side: usize| {
                        let byte = node.planes[axis][side][place / 4] >> (8 * (place % 4)) & 255;
                        origin[axis] + f64::from(byte) * step
                    };
                    prop_assert!(plane(0) <= child.low[axis] && child.high[axis] <= plane(1));
                }
            }
        }
    }

    #[test]
    fn children_stand_where_rays_meet_them_first() {
        let child = |x: f64, y: f64, z: f64| Child {
            link: Link::triangles(0, 1),
            low: [x, y, z],
            high: [x + 1.0, y + 1.0, z + 1.0],
        };
        let corners: Vec<Child> =
            (0..8).rev().map(|k| child((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64)).collect();
        assert_eq!(places(&corners), [7, 6, 5, 4, 3, 2, 1, 0]);
    }
}
