//! The tree over lights by which one is chosen for a point: the same nodes with any number of threads.

mod emitter;
mod split;
mod sums;

#[cfg(test)]
mod tests;

use crate::model::LightSelection;
use emitter::Emitter;
use eosphor_core::light::{LEAST_CHANCE, Light, LightNode};
use eosphor_core::math::{Vec3, vec3};
use rayon::prelude::*;
use split::split;
use sums::Sums;

/// Larger nodes have both children built at a time.
const LIGHTS_A_TASK: usize = 4096;

/// The least power of a light, of the largest: no light is left out.
const LEAST_POWER: f64 = 1.0 / (1u64 << 63) as f64;

/// What is added to radii for rounding, of numbers of single precision.
const ROUNDING: f64 = 1.0 / (1u64 << 21) as f64;

/// Nodes and, of each light, its place among the leaves.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct LightTreeArrays {
    pub(super) nodes: Vec<LightNode>,
    pub(super) places: Vec<u32>,
}

/// What is to be in the tree, and how it is chosen.
#[derive(Clone, Copy)]
pub(super) struct Plan {
    pub(super) selection: LightSelection,
    /// Only lights with an area are in it.
    pub(super) lamps_only: bool,
}

/// Builds it. `texel_share` says what the texture of a lamp leaves of its colour on average.
pub(super) fn build(
    lights: &[Light],
    plan: &Plan,
    texel_share: impl Fn(&Light) -> f64 + Sync,
) -> LightTreeArrays {
    let (mut near, mut far) = (Vec::new(), Vec::new());
    let taken = lights.par_iter().enumerate().filter(|(_, light)| !plan.lamps_only || light.is_lamp());
    let emitters: Vec<(u32, Option<Emitter>)> = taken
        .map(|(number, light)| (number as u32, Emitter::new(number as u32, light, texel_share(light))))
        .collect();
    for (number, emitter) in emitters {
        match emitter {
            Some(emitter) => near.push(emitter),
            None => far.push(number),
        }
    }
    let most = near.iter().map(|e| e.power).fold(0.0, f64::max);
    for emitter in &mut near {
        emitter.power = (emitter.power / most).max(LEAST_POWER);
    }
    let count = near.len() + far.len();
    if count == 0 {
        return LightTreeArrays::default();
    }
    let mut root = [leaf(0)];
    let mut below = vec![leaf(0); 2 * count - 2];
    let at = Place { below: 1, leaf: 0 };
    match (far.len(), near.len()) {
        (0, _) => branch(&mut near, (&mut root[0], &mut below), at, 0, plan.selection),
        (_, 0) => alike(&far, (&mut root[0], &mut below), at),
        (alone, together) => {
            // What shines from afar has no place; all of the others are as one such light.
            let others = if plan.selection == LightSelection::Uniform { together } else { 1 };
            let (first, second) = at.children(alone);
            root[0] = fork(alone as f64 / (alone + others) as f64, at, second);
            let (first_child, second_child) = children(&mut below, alone);
            alike(&far, first_child, first);
            branch(&mut near, second_child, second, 0, plan.selection);
        }
    }
    let nodes: Vec<LightNode> = root.into_iter().chain(below).collect();
    let places = places(&nodes, lights.len());
    LightTreeArrays { nodes, places }
}

fn leaf(number: u32) -> LightNode {
    LightNode {
        center: Vec3::ZERO,
        radius: 0.0,
        normal: Vec3::ZERO,
        variance: 0.0,
        power: 0.0,
        first_chance: -1.0,
        children: LightNode::LEAF,
        number,
    }
}

/// Of each light, how many leaves come before it.
fn places(nodes: &[LightNode], lights: usize) -> Vec<u32> {
    let mut places = vec![LightNode::LEAF; lights];
    let (mut seen, mut waiting) = (0, vec![0]);
    while let Some(number) = waiting.pop() {
        let node: &LightNode = &nodes[number as usize];
        if node.is_leaf() {
            places[node.number as usize] = seen;
            seen += 1;
        } else {
            waiting.extend([node.children + 1, node.children]);
        }
    }
    places
}

/// Where a node stands: the number of the first node below it, and how many leaves come before it.
#[derive(Clone, Copy)]
struct Place {
    below: usize,
    leaf: usize,
}

impl Place {
    /// Of its children, of which the first has so many lights.
    fn children(self, lights: usize) -> (Place, Place) {
        let Place { below, leaf } = self;
        (Place { below: below + 2, leaf }, Place { below: below + 2 * lights, leaf: leaf + lights })
    }
}

/// A node and all nodes below it.
type Branch<'a> = (&'a mut LightNode, &'a mut [LightNode]);

/// The two children, among the nodes below their parent. The first has so many lights.
fn children(below: &mut [LightNode], lights: usize) -> (Branch<'_>, Branch<'_>) {
    let (pair, below) = below.split_at_mut(2);
    let (first, second) = pair.split_at_mut(1);
    let (below_first, below_second) = below.split_at_mut(2 * lights - 2);
    ((&mut first[0], below_first), (&mut second[0], below_second))
}

/// A node whose first child has this chance; where it is negative, what the children promise decides.
fn fork(first_chance: f64, at: Place, second: Place) -> LightNode {
    let first_chance = if first_chance < 0.0 {
        first_chance as f32
    } else {
        (first_chance as f32).clamp(LEAST_CHANCE, 1.0 - LEAST_CHANCE)
    };
    LightNode { first_chance, children: at.below as u32, ..leaf(second.leaf as u32) }
}

/// Lights that have the same chance each.
fn alike(lights: &[u32], (node, below): Branch<'_>, at: Place) {
    if let [number] = lights {
        *node = leaf(*number);
        return;
    }
    let half = lights.len() / 2;
    let (first, second) = at.children(half);
    *node = fork(half as f64 / lights.len() as f64, at, second);
    let (first_child, second_child) = children(below, half);
    alike(&lights[..half], first_child, first);
    alike(&lights[half..], second_child, second);
}

/// Lights that have a place.
fn branch(
    lights: &mut [Emitter],
    (node, below): Branch<'_>,
    at: Place,
    depth: u32,
    selection: LightSelection,
) {
    let bounds = bounds(lights);
    if let [light] = lights {
        *node = LightNode { number: light.number, ..bounds };
        return;
    }
    let all = lights.len();
    let count = split(lights, depth);
    let (first_lights, second_lights) = lights.split_at_mut(count);
    let chance = match selection {
        LightSelection::All | LightSelection::Tree => -1.0,
        LightSelection::Uniform => count as f64 / all as f64,
        LightSelection::Power => {
            let power = |lights: &[Emitter]| lights.iter().map(|light| light.power).sum::<f64>();
            power(first_lights) / (power(first_lights) + power(second_lights))
        }
    };
    let (first, second) = at.children(count);
    let LightNode { first_chance, children: first_node, number, .. } = fork(chance, at, second);
    *node = LightNode { first_chance, children: first_node, number, ..bounds };
    let (first_child, second_child) = children(below, count);
    let build_first = || branch(first_lights, first_child, first, depth + 1, selection);
    let build_second = || branch(second_lights, second_child, second, depth + 1, selection);
    if all > LIGHTS_A_TASK {
        rayon::join(build_first, build_second);
    } else {
        build_first();
        build_second();
    }
}

/// What a node of these lights says of them, without its children.
fn bounds(lights: &[Emitter]) -> LightNode {
    let origin = lights[0].place;
    let sums = Sums::of(lights, origin);
    let mean = sums.center();
    let center = [0, 1, 2].map(|axis| (mean[axis] + origin[axis]) as f32);
    let farthest = lights.iter().map(|light| light.reach(center.map(f64::from))).fold(0.0, f64::max);
    let largest = center.iter().fold(0f64, |most, x| most.max(f64::from(x.abs())));
    // Of whoever asks, too.
    let radius = farthest * (1.0 + ROUNDING) + largest * ROUNDING;
    let [x, y, z] = center;
    let [a, b, c] = sums.normal();
    LightNode {
        center: vec3(x, y, z),
        radius: radius as f32,
        normal: vec3(a as f32, b as f32, c as f32),
        variance: sums.variance() as f32,
        power: sums.power as f32,
        ..leaf(0)
    }
}
