//! A bounding volume hierarchy as GPUs read it.

use crate::Bvh;
use eosphor_core::device::{BvhPair, FarTracer, Link, PAIR_SLACK, PairTracer, PairView, Root, WarpMode};
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::BvhNode;
use eosphor_core::intersect::{EXTENT_SLACK, sphere_bounds};
use eosphor_core::math::{Vec3, vec3};

/// The trees of a [`Bvh`], with the boxes of two children in one node. Primitives stay where they are.
#[derive(Clone, Debug)]
pub struct BvhPairs {
    pub(crate) pairs: Vec<BvhPair>,
    /// For each geometry, its tree.
    pub(crate) roots: Vec<Root<Link>>,
    /// The tree over the instances but the world, with boxes for the same rays as the world's tree.
    pub(crate) instance_root: Link,
    /// Numbers in links are below these.
    pub(crate) counts: Counts,
}

/// How many things of each kind a hierarchy has that links lead to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Counts {
    triangles: usize,
    spheres: usize,
    geometries: usize,
    instances: usize,
}

impl Counts {
    fn of(bvh: &Bvh) -> Counts {
        let p = &bvh.primitives;
        Counts {
            triangles: p.triangles.len(),
            spheres: p.spheres.len(),
            geometries: p.geometries.len(),
            instances: p.instances.len(),
        }
    }

    /// Whether links to so many things lead somewhere in a hierarchy.
    ///
    /// # Panics
    /// Where they do not.
    pub(crate) fn check(&self, bvh: &Bvh) {
        assert_eq!(*self, Counts::of(bvh), "nodes for GPUs go with the hierarchy that they were made from");
    }
}

impl BvhPairs {
    /// Makes the pairs of a hierarchy; `None` where it has more primitives or instances than links of 32 bits can name.
    pub fn new(bvh: &Bvh) -> Option<BvhPairs> {
        let primitives = &bvh.primitives;
        let numbers = primitives.spheres.len().max(primitives.instances.len());
        if primitives.triangles.len() > Link::TRIANGLES_END as usize || numbers > Link::NUMBERS_END as usize {
            return None;
        }
        let placed = &primitives.instances[1.min(primitives.instances.len())..];
        let mut pairs = Vec::with_capacity(bvh.nodes.len() / 2 + 1);
        let mut tree =
            |root: u32, kind, pad| Tree { bvh, kind, pad, first: 0, pairs: &mut pairs }.convert(root);
        let mut world = Vec::new();
        let roots: Vec<Root<Link>> = (0..)
            .zip(primitives.geometries.iter().zip(&bvh.roots))
            .map(|(number, (geometry, &root))| {
                let mut boxes = primitives.triangle_bounds(geometry);
                boxes.extend(primitives.sphere_bounds(geometry));
                if number == 0 {
                    boxes.extend(placed.iter().map(|i| i.world_bounds));
                }
                let (reach, pad) = reach_and_pad(&boxes);
                if number == 0 {
                    world.push(pad);
                }
                Root { first: tree(root, Kind::Primitives, pad), reach }
            })
            .collect();
        let instance_root = if placed.is_empty() {
            Link::NOTHING
        } else {
            tree(bvh.instance_root, Kind::Instances, world.first().copied().unwrap_or(0.0))
        };
        Some(BvhPairs { pairs, roots, instance_root, counts: Counts::of(bvh) })
    }

    /// The tree over the instances of a hierarchy that was built over these alone, for an array in which it begins at number
    /// `first` and which has other trees beside it, for rays from within this reach. There are fewer pairs than instances.
    pub fn over_instances(top: &Bvh, reach: f32, first: u32) -> (Vec<BvhPair>, Link) {
        let placed = &top.primitives.instances[1.min(top.primitives.instances.len())..];
        if placed.is_empty() {
            return (Vec::new(), Link::NOTHING);
        }
        let extent = placed.iter().fold(0.0f32, |extent, i| extent.max(i.world_bounds.extent()));
        let mut pairs = Vec::with_capacity(placed.len());
        let tree =
            Tree { bvh: top, kind: Kind::Instances, pad: pad(reach, extent), first, pairs: &mut pairs };
        let root = tree.convert(top.instance_root);
        (pairs, root)
    }

    /// Adds pairs that lead nowhere, for trees over instances that come later.
    pub fn make_room(&mut self, pairs: usize) {
        let (link0, link1) = (Link::NOTHING, Link::NOTHING);
        let (center0, half0, center1, half1) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
        let nowhere = BvhPair { center0, link0, half0, unused: [0; 2], center1, half1, link1 };
        self.pairs.resize(self.pairs.len() + pairs, nowhere);
    }

    /// Pairs of all trees.
    pub fn pairs(&self) -> &[BvhPair] {
        &self.pairs
    }

    /// For each geometry, its tree.
    pub fn roots(&self) -> &[Root<Link>] {
        &self.roots
    }

    /// The arrays of the trees, borrowed, with those of the hierarchy that they were made from.
    ///
    /// # Panics
    /// Where `bvh` is another one, or was built over instances alone.
    pub fn view<'a>(&'a self, bvh: &'a Bvh) -> PairView<'a> {
        self.counts.check(bvh);
        PairView {
            pairs: &self.pairs,
            roots: &self.roots,
            instance_root: self.instance_root,
            warp_mode: WarpMode::AUTO,
            primitives: bvh.primitives.view(),
        }
    }

    /// The traversal of GPUs through the world alone, whatever is placed in it.
    pub fn world_tracer<'a>(&'a self, bvh: &'a Bvh, warp_mode: WarpMode) -> PairTracer<'a, false> {
        // SAFETY: closed view: the fields are private, and builders make them so; `view` checks that they belong together.
        unsafe { PairTracer::new(PairView { warp_mode, ..self.view(bvh) }) }
    }

    /// The traversal of GPUs with the threads of a warp in step.
    pub fn tracer_in_step<'a>(&'a self, bvh: &'a Bvh) -> PairTracer<'a, true, true> {
        // SAFETY: closed view: the fields are private, and builders make them so; `view` checks that they belong together.
        unsafe { PairTracer::new(self.view(bvh)) }
    }

    /// The traversal of GPUs for rays that start far away.
    pub fn far_tracer<'a>(&'a self, bvh: &'a Bvh) -> FarTracer<'a, true> {
        // SAFETY: closed view: the fields are private, and builders make them so; `view` checks that they belong together.
        unsafe { FarTracer::new(self.view(bvh)) }
    }

    /// The traversal of GPUs, one ray at a time. On a CPU it is for tests: [`crate::Bvh8`] is faster.
    pub fn tracer<'a>(&'a self, bvh: &'a Bvh) -> PairTracer<'a, true> {
        // SAFETY: closed view: the fields are private, and builders make them so; `view` checks that they belong together.
        unsafe { PairTracer::new(self.view(bvh)) }
    }
}

/// Boxes are large enough for rays that start within so many times what a tenth of them lie within: boxes are no larger for
/// it than by 2^-14 of their distance from 0. Rays from beyond take a walk that costs several times as much; four times this
/// would cost all others up to 4 %.
const REACH: f32 = 64.0;

/// But no more than this many sizes of all boxes from where they are: cameras stand farther away than that seldom.
const SIZES: f32 = 64.0;

/// So many boxes are looked at, at most.
const SAMPLES: usize = 4096;

/// For rays from how far along each axis a tree with these boxes is made, and what its boxes are padded by for that.
fn reach_and_pad(boxes: &[Bounds]) -> (f32, f64) {
    let step = boxes.len().div_ceil(SAMPLES).max(1);
    let mut distances: Vec<f32> =
        boxes.iter().step_by(step).map(Bounds::extent).filter(|x| *x > 0.0).collect();
    distances.sort_by(f32::total_cmp);
    let all = boxes.iter().fold(Bounds::EMPTY, |all, b| all.union(b));
    let extent = all.extent();
    let near = distances.get(distances.len() / 10).copied().unwrap_or(extent);
    let size = (all.max - all.min).max_component().max(0.0);
    let reach = (REACH * near).min(SIZES * size + extent);
    (reach, pad(reach, extent))
}

/// Besides what follows from their own coordinates.
fn pad(reach: f32, extent: f32) -> f64 {
    f64::from(PAIR_SLACK) * f64::from(reach) + f64::from(EXTENT_SLACK) * f64::from(extent)
}

/// What the leaves of a tree name.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Primitives,
    Instances,
}

/// One tree that is converted.
struct Tree<'a> {
    bvh: &'a Bvh,
    kind: Kind,
    /// What boxes are padded by.
    pad: f64,
    /// The number that the first of the pairs has.
    first: u32,
    pairs: &'a mut Vec<BvhPair>,
}

/// A child that is still to be converted, and where its link belongs: the pair, and which of its children.
struct Waiting {
    node: u32,
    pair: usize,
    second: bool,
}

impl Tree<'_> {
    /// Depth first, so that a pair and its first child's are neighbours.
    fn convert(mut self, root: u32) -> Link {
        let mut waiting = Vec::new();
        let link = self.take(root, &mut waiting);
        while let Some(Waiting { node, pair, second }) = waiting.pop() {
            let link = self.take(node, &mut waiting);
            let pair = &mut self.pairs[pair];
            *(if second { &mut pair.link1 } else { &mut pair.link0 }) = link;
        }
        link
    }

    /// The link to a node. An inner one's children wait.
    fn take(&mut self, number: u32, waiting: &mut Vec<Waiting>) -> Link {
        let node = self.bvh.nodes[number as usize];
        if !node.is_inner() {
            return self.leaf(&node);
        }
        let boxes = [0, 1].map(|k| self.bvh.nodes[(node.first + k) as usize].bounds());
        let pair = self.push(boxes, [Link::NOTHING; 2]);
        waiting.push(Waiting { node: node.first + 1, pair, second: true });
        waiting.push(Waiting { node: node.first, pair, second: false });
        Link::pair(self.first + pair as u32)
    }

    fn leaf(&mut self, leaf: &BvhNode) -> Link {
        let (first, count) = (leaf.first, leaf.count & !BvhNode::SPHERES);
        if count == 0 {
            return Link::NOTHING;
        }
        let (most, link): (u32, fn(u32, u32) -> Link) = match self.kind {
            Kind::Primitives if leaf.count & BvhNode::SPHERES == 0 => (Link::MOST_TRIANGLES, Link::triangles),
            Kind::Primitives => (1, |first, _| Link::sphere(first)),
            Kind::Instances => (1, |first, _| Link::instance(first)),
        };
        self.halves(leaf, first, count, most, link).1
    }

    /// A leaf's primitives by halves, until there are at most so many together.
    fn halves(
        &mut self,
        leaf: &BvhNode,
        first: u32,
        count: u32,
        most: u32,
        link: fn(u32, u32) -> Link,
    ) -> (Bounds, Link) {
        if count <= most {
            return match self.kind {
                Kind::Instances => {
                    let number = self.bvh.instance_order[first as usize];
                    let bounds = self.bvh.primitives.instances[number as usize].world_bounds;
                    (bounds, link(number, 1))
                }
                // Those of triangles may have been cut.
                Kind::Primitives if most > 1 => (leaf.bounds(), link(first, count)),
                Kind::Primitives => {
                    let sphere = &self.bvh.primitives.spheres[first as usize];
                    (sphere_bounds(sphere), link(first, 1))
                }
            };
        }
        // The pair comes before what it leads to.
        let nowhere = Bounds { min: Vec3::ZERO, max: Vec3::ZERO };
        let pair = self.push([nowhere; 2], [Link::NOTHING; 2]);
        let half = count / 2;
        let (bounds0, link0) = self.halves(leaf, first, half, most, link);
        let (bounds1, link1) = self.halves(leaf, first + half, count - half, most, link);
        self.pairs[pair] = self.pair([bounds0, bounds1], [link0, link1]);
        (bounds0.union(&bounds1), Link::pair(self.first + pair as u32))
    }

    fn push(&mut self, boxes: [Bounds; 2], links: [Link; 2]) -> usize {
        self.pairs.push(self.pair(boxes, links));
        self.pairs.len() - 1
    }

    fn pair(&self, boxes: [Bounds; 2], [link0, link1]: [Link; 2]) -> BvhPair {
        let [(center0, half0), (center1, half1)] = boxes.map(|bounds| centered(&bounds, self.pad));
        BvhPair { center0, link0, half0, unused: [0; 2], center1, half1, link1 }
    }
}

/// Middle and half the size of a box that holds this one, a margin around it, and what the test of such boxes rounds.
fn centered(bounds: &Bounds, margin: f64) -> (Vec3, Vec3) {
    let axis = |low: f32, high: f32| {
        let (low, high) = (f64::from(low), f64::from(high));
        let margin = margin + f64::from(PAIR_SLACK) * low.abs().max(high.abs());
        let center = (0.5 * (low + high)) as f32;
        let half = (high - f64::from(center)).max(f64::from(center) - low) + margin;
        let rounded = half as f32;
        (center, if f64::from(rounded) < half { rounded.next_up() } else { rounded })
    };
    let (x, y, z) = (
        axis(bounds.min.x, bounds.max.x),
        axis(bounds.min.y, bounds.max.y),
        axis(bounds.min.z, bounds.max.z),
    );
    (vec3(x.0, y.0, z.0), vec3(x.1, y.1, z.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_centred_box_holds_the_box() {
        for (low, high) in
            [(0.1f32, 0.3), (-1e-30, 1e10), (5.0, 5.0), (-7.3, -7.2999997), (0.0, f32::MIN_POSITIVE)]
        {
            let bounds = Bounds { min: Vec3::splat(low), max: Vec3::splat(high) };
            let (low, high) = (f64::from(low), f64::from(high));
            let margin = 1e-6 * low.abs().max(high.abs());
            let (center, half) = centered(&bounds, margin);
            let (c, h) = (f64::from(center.x), f64::from(half.x));
            assert!(c - h <= low - 0.999 * margin && high + 0.999 * margin <= c + h, "{low} {high}");
        }
    }
}
