//! A light chosen by chance: by how much it may give to a point, as a tree over lights estimates it.
//!
//! The tree is binary, with a light in each leaf; a node bounds where its lights are, how strong they are together and into which
//! directions they shine. The way down takes one child of each node, with chances by what the bounds promise (Conty Estevez and
//! Kulla 2018, "Importance sampling of many lights with adaptive tree splitting", section 3; without the splitting). The product of
//! these chances is the light's, so the way to a known light gives its chance, too.

use super::Light;
use crate::math::{Vec3, clamp, fma, max, sqrt};
use crate::out_of_line::out_of_line;
use crate::ray::PrimitiveId;
use crate::sampling::place_within;

/// A node of the tree. Number 0 is the root.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LightNode {
    /// The mean of the places of its lights by power, world space.
    pub center: Vec3,
    /// All of them lie within this distance from there.
    pub radius: f32,
    /// The mean of their normals by power: the shorter, the more they differ. What shines into all directions has none.
    pub normal: Vec3,
    /// The mean of their squared distances from the center, by power.
    pub variance: f32,
    /// What its lights send out together along their normals; only ratios count. What shines into all directions sends a fourth of
    /// this.
    pub power: f32,
    /// Chance of the first child wherever the point lies; negative where what the children promise decides.
    pub first_chance: f32,
    /// The first child, with the second one behind it, and both behind their parent; [`LightNode::LEAF`] where the node is a light.
    pub children: u32,
    /// Of a light, its number. Else how many leaves come before those of the second child.
    pub number: u32,
}

impl LightNode {
    /// In place of children.
    pub const LEAF: u32 = u32::MAX;

    /// Promises nothing.
    pub(super) const NONE: LightNode = LightNode {
        center: Vec3::ZERO,
        radius: 0.0,
        normal: Vec3::ZERO,
        variance: 0.0,
        power: 0.0,
        first_chance: 1.0,
        children: LightNode::LEAF,
        number: 0,
    };

    /// Whether it is a light.
    #[inline(always)]
    pub fn is_leaf(&self) -> bool {
        self.children == LightNode::LEAF
    }
}

/// What lights shine on: a point and its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct LightReceiver {
    /// World space.
    pub position: Vec3,
    /// Unit normal of the side that light counts on; 0 where it counts on both.
    pub normal: Vec3,
}

/// A light that was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChosenLight {
    /// Its number among all lights.
    pub number: u32,
    /// How likely it was chosen; over 0.
    pub chance: f32,
    /// Where among the numbers that choose it the one lies that did, in [0, 1): as even there as these are, so it may choose a
    /// point of the light.
    pub rest: f32,
}

/// A tree over lights.
#[derive(Clone, Copy, Debug)]
pub struct LightTree<'a> {
    /// The nodes.
    pub nodes: &'a [LightNode],
    /// Of each light, how many leaves come before it, first children's before second ones'; [`LightNode::LEAF`] where it is not in
    /// the tree.
    pub places: &'a [u32],
}

/// The way down: where it is, and how likely it leads there. Chances are of double precision, so that a number is enough for any
/// depth.
#[derive(Clone, Copy)]
pub(super) struct Descent {
    pub(super) node: u32,
    pub(super) chance: f64,
}

impl LightTree<'_> {
    /// A light by its chance, for `u` in [0, 1), whose digits below 2^-32 count in large trees. `None` where no light reaches the
    /// receiver.
    #[inline(always)]
    pub fn choose(&self, receiver: &LightReceiver, u: f64) -> Option<ChosenLight> {
        choose_light(self, *receiver, u)
    }

    /// As [`LightTree::choose`] in each of several lanes; those that are not wanted may be left out. The first choice, between the
    /// children of the root, is made in all lanes together: with few lamps it is the only one.
    #[inline(always)]
    pub fn choose_lanes<const W: usize>(
        &self,
        is_wanted: &[bool; W],
        receiver: impl Fn(usize) -> LightReceiver,
        u: &[f64; W],
    ) -> [Option<ChosenLight>; W] {
        let mut chosen = [None; W];
        let Some(root) = self.nodes.first() else { return chosen };
        let (mut first, mut is_reached) = ([root.first_chance as f64; W], [true; W]);
        let children = (self.nodes.get(root.children as usize), self.nodes.get(root.children as usize + 1));
        if let (true, (Some(a), Some(b))) = (!root.is_leaf() & !(root.first_chance >= 0.0), children) {
            for lane in 0..W {
                let receiver = receiver(lane);
                let importances = [a.importance(&receiver), b.importance(&receiver)];
                let share;
                (share, is_reached[lane]) = share_of_first(importances);
                first[lane] = share as f64;
            }
        }
        let start = Descent { node: 0, chance: 1.0 };
        if let (Some(a), Some(b)) = children
            && a.is_leaf()
            && b.is_leaf()
            && root.children > 0
        {
            // A lamp of two triangles: all of the way down, free of branches.
            let (mut is_first, mut chance, mut rest) = ([false; W], [0.0; W], [0.0; W]);
            for lane in 0..W {
                let (to_first, low) = start.turns(first[lane], u[lane], 0.0);
                let share = start.chance * if to_first { first[lane] } else { 1.0 - first[lane] };
                is_first[lane] = to_first;
                chance[lane] = share as f32;
                rest[lane] = place_within((u[lane] - low) / share);
            }
            for lane in 0..W {
                let number = if is_first[lane] { a.number } else { b.number };
                let light = ChosenLight { number, chance: chance[lane], rest: rest[lane] };
                chosen[lane] = (is_reached[lane] & (chance[lane] > 0.0)).then_some(light);
            }
            return chosen;
        }
        // A lane alone, as on GPUs, has a function for all ways down.
        if W > 1 && !root.is_leaf() {
            return self.descend_lanes(is_wanted, receiver, u);
        }
        for lane in 0..W {
            let u = u[lane];
            chosen[lane] = if root.is_leaf() {
                self.descend(&receiver(lane), u, start, 0.0)
            } else if is_reached[lane] {
                let (is_first, low) = start.turns(first[lane], u, 0.0);
                match start.below(root, first[lane], is_first) {
                    Some(below) => self.descend(&receiver(lane), u, below, low),
                    None => None,
                }
            } else {
                None
            };
        }
        chosen
    }

    /// The way down from a node, whose lights are those with `u` from `low` on.
    #[inline(always)]
    fn descend(
        &self,
        receiver: &LightReceiver,
        u: f64,
        mut at: Descent,
        mut low: f64,
    ) -> Option<ChosenLight> {
        loop {
            let node = self.nodes.get(at.node as usize)?;
            if node.is_leaf() {
                let chance = at.chance as f32;
                let rest = place_within((u - low) / at.chance);
                return (chance > 0.0).then_some(ChosenLight { number: node.number, chance, rest });
            }
            let first = self.first_chance(node, receiver)?;
            let is_first;
            (is_first, low) = at.turns(first, u, low);
            at = at.below(node, first, is_first)?;
        }
    }

    /// The chance that [`LightTree::choose`] has of choosing a light; 0 for what is no light of the tree.
    #[inline(always)]
    pub fn chance(&self, receiver: &LightReceiver, light: u32) -> f32 {
        chance_of_light(self, *receiver, light)
    }

    /// The chance of a node's first child; `None` where neither of them reaches the receiver.
    #[inline(always)]
    fn first_chance(&self, node: &LightNode, receiver: &LightReceiver) -> Option<f64> {
        if node.first_chance >= 0.0 {
            return Some(node.first_chance as f64);
        }
        let first = self.nodes.get(node.children as usize)?.importance(receiver);
        let second = self.nodes.get(node.children as usize + 1)?.importance(receiver);
        let (share, is_reached) = share_of_first([first, second]);
        if is_reached { Some(share as f64) } else { None }
    }
}

/// The chance of the first of two children that promise this, and whether either of them promises anything.
#[inline(always)]
pub(super) fn share_of_first([first, second]: [f32; 2]) -> (f32, bool) {
    let all = first + second;
    // Where their sum is infinite they are alike.
    let share = if all < f32::INFINITY { first / all } else { 0.5 };
    let of_both = clamp(share, LEAST_CHANCE, 1.0 - LEAST_CHANCE);
    let of_one = if first > 0.0 { 1.0 } else { 0.0 };
    (if (first > 0.0) & (second > 0.0) { of_both } else { of_one }, all > 0.0)
}

out_of_line! {
    fn choose_light(tree: &LightTree<'_>, receiver: LightReceiver, u: f64) -> Option<ChosenLight> {
        tree.descend(&receiver, u, Descent { node: 0, chance: 1.0 }, 0.0)
    }
}

out_of_line! {
    fn chance_of_light(tree: &LightTree<'_>, receiver: LightReceiver, light: u32) -> f32 {
        let Some(&place) = tree.places.get(light as usize) else { return 0.0 };
        if place == LightNode::LEAF {
            return 0.0;
        }
        let mut at = Descent { node: 0, chance: 1.0 };
        loop {
            let Some(node) = tree.nodes.get(at.node as usize) else { return 0.0 };
            if node.is_leaf() {
                return at.chance as f32;
            }
            let Some(first) = tree.first_chance(node, &receiver) else { return 0.0 };
            let Some(below) = at.below(node, first, place < node.number) else { return 0.0 };
            at = below;
        }
    }
}

impl Descent {
    /// Whether the way for `u` goes to the first child, which has this chance, and where the lights there begin.
    #[inline(always)]
    pub(super) fn turns(&self, first: f64, u: f64, low: f64) -> (bool, f64) {
        let middle = low + self.chance * first;
        let is_first = (u < middle) | (first >= 1.0);
        (is_first, if is_first { low } else { middle })
    }

    /// One node further; `None` where the nodes are no tree.
    #[inline(always)]
    fn below(&self, node: &LightNode, first: f64, is_first: bool) -> Option<Descent> {
        let (child, share) = if is_first { (node.children, first) } else { (node.children + 1, 1.0 - first) };
        (node.children > self.node).then_some(Descent { node: child, chance: self.chance * share })
    }
}

impl LightNode {
    /// About what a receiver gets of the node's lights where nothing is in the way; 0 only where it gets nothing.
    ///
    /// For the mean of max(x, 0), where x has a mean m, half of m + sqrt(m^2 + v) is taken. It is right for normals that are the
    /// same, where v is 0, and with v = 1/4 for such of all directions. How much v there is for lights that are apart, and how much
    /// nearer than their mean square they are to count (1/8 of their variance), was found by measuring rooms, streets and balls of
    /// lamps; the exact numbers matter little.
    #[inline(always)]
    pub(super) fn importance(&self, receiver: &LightReceiver) -> f32 {
        let offset = self.center - receiver.position;
        let squared = max(fma(0.125, self.variance, offset.length_squared()), f32::MIN_POSITIVE);
        // Without the least spread rounding makes 0 of what is not impossible.
        let spread = fma(0.5, self.variance, LEAST_SPREAD * squared);
        let sent = -self.normal.dot(offset);
        let directions = 0.25 * (1.0 - self.normal.length_squared()) * squared;
        let sent_on_average = sent + sqrt(fma(sent, sent, max(directions, 0.0) + spread));
        let got = receiver.normal.dot(offset);
        let got_on_average = got + sqrt(fma(got, got, spread));
        let is_any_side = receiver.normal == Vec3::ZERO;
        let is_behind = (got <= -self.radius) & !is_any_side;
        let is_turned_away = self.is_leaf() & (sent <= -self.radius) & (self.normal != Vec3::ZERO);
        if is_behind | is_turned_away {
            return 0.0;
        }
        let got_on_average = if is_any_side { sqrt(squared) } else { got_on_average };
        // Over the square at a time: its square is out of range in large scenes.
        let inverse = 1.0 / squared;
        self.power * ((sent_on_average * inverse) * (got_on_average * inverse))
    }
}

/// The least chance of a child that may reach a receiver: with that, the other one's is less than 1.
pub const LEAST_CHANCE: f32 = 1.0 / 16_777_216.0;

/// The least variance of cosines.
const LEAST_SPREAD: f32 = 1.0 / 262_144.0;

/// The number of the light that a primitive is, if it is one: these come last among lights, in the order of
/// [`PrimitiveId::before`].
#[inline(always)]
pub fn light_of_primitive(lights: &[Light], id: PrimitiveId) -> Option<u32> {
    let (mut from, mut to) = (0, lights.len());
    while from < to {
        let middle = (from + to) / 2;
        let is_before = match lights.get(middle)? {
            Light::Triangle { instance, primitive, .. } | Light::Sphere { instance, primitive, .. } => {
                PrimitiveId { instance: *instance, primitive: *primitive }.before(id)
            }
            Light::Point { .. } | Light::Directional { .. } | Light::Spot { .. } => true,
        };
        (from, to) = if is_before { (middle + 1, to) } else { (from, middle) };
    }
    let is_it = lights.get(from)?.primitive() == id;
    is_it.then_some(from as u32)
}
