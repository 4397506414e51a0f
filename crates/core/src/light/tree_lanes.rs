//! The way down a tree of lights for several points at a time.
//!
//! What lanes read of nodes does not depend on each other, so it comes from memory together; what they compute stands in short
//! loops over arrays, free of branches, which become SIMD code.

use super::tree::{ChosenLight, Descent, LightNode, LightReceiver, LightTree, share_of_first};
use crate::math::Vec3Lanes;
use crate::sampling::place_within;

/// Nodes that lanes look at.
struct NodeLanes<const W: usize> {
    center: Vec3Lanes<W>,
    normal: Vec3Lanes<W>,
    radius: [f32; W],
    variance: [f32; W],
    power: [f32; W],
    children: [u32; W],
}

impl<const W: usize> NodeLanes<W> {
    #[inline(always)]
    fn new() -> NodeLanes<W> {
        let zero = Vec3Lanes::ZERO;
        NodeLanes {
            center: zero,
            normal: zero,
            radius: [0.0; W],
            variance: [0.0; W],
            power: [0.0; W],
            children: [0; W],
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, node: &LightNode) {
        self.center.set(lane, node.center);
        self.normal.set(lane, node.normal);
        self.radius[lane] = node.radius;
        self.variance[lane] = node.variance;
        self.power[lane] = node.power;
        self.children[lane] = node.children;
    }

    /// What a node promises a receiver.
    #[inline(always)]
    fn importance(&self, lane: usize, receiver: &LightReceiver) -> f32 {
        let node = LightNode {
            center: self.center.get(lane),
            radius: self.radius[lane],
            normal: self.normal.get(lane),
            variance: self.variance[lane],
            power: self.power[lane],
            first_chance: -1.0,
            children: self.children[lane],
            number: 0,
        };
        node.importance(receiver)
    }
}

impl LightTree<'_> {
    /// As [`LightTree::choose`] in each of several lanes that are wanted.
    #[inline(always)]
    pub(super) fn descend_lanes<const W: usize>(
        &self,
        is_wanted: &[bool; W],
        receiver: impl Fn(usize) -> LightReceiver,
        u: &[f64; W],
    ) -> [Option<ChosenLight>; W] {
        let mut chosen = [None; W];
        let (mut positions, mut normals) = (Vec3Lanes::<W>::ZERO, Vec3Lanes::<W>::ZERO);
        for lane in 0..W {
            let LightReceiver { position, normal } = receiver(lane);
            positions.set(lane, position);
            normals.set(lane, normal);
        }
        let (mut node, mut number) = ([0u32; W], [0u32; W]);
        let (mut chance, mut low) = ([1.0f64; W], [0.0f64; W]);
        // Lanes on their way, and those that have come to a light.
        let (mut is_under_way, mut is_there) = (*is_wanted, [false; W]);
        let (mut first, mut second) = (NodeLanes::<W>::new(), NodeLanes::<W>::new());
        let (mut fixed, mut children) = ([-1.0f32; W], [0u32; W]);
        loop {
            let mut is_any = false;
            for lane in 0..W {
                if !is_under_way[lane] {
                    continue;
                }
                is_under_way[lane] = false;
                let Some(parent) = self.nodes.get(node[lane] as usize) else { continue };
                if parent.is_leaf() {
                    (is_there[lane], number[lane]) = (true, parent.number);
                    continue;
                }
                // Where the nodes are a tree, children come after their parent.
                if parent.children <= node[lane] {
                    continue;
                }
                let pair =
                    (self.nodes.get(parent.children as usize), self.nodes.get(parent.children as usize + 1));
                let (Some(a), Some(b)) = pair else { continue };
                first.set(lane, a);
                second.set(lane, b);
                (fixed[lane], children[lane]) = (parent.first_chance, parent.children);
                (is_under_way[lane], is_any) = (true, true);
            }
            if !is_any {
                break;
            }
            let (mut share, mut is_reached) = ([0.0f64; W], [false; W]);
            for lane in 0..W {
                let receiver = LightReceiver { position: positions.get(lane), normal: normals.get(lane) };
                let importances = [first.importance(lane, &receiver), second.importance(lane, &receiver)];
                (share[lane], is_reached[lane]) = share_of_first(importances);
            }
            for lane in 0..W {
                let is_fixed = fixed[lane] >= 0.0;
                let of_first = if is_fixed { fixed[lane] as f64 } else { share[lane] };
                let goes_on = is_under_way[lane] & (is_fixed | is_reached[lane]);
                let at = Descent { node: node[lane], chance: chance[lane] };
                let (is_first, from) = at.turns(of_first, u[lane], low[lane]);
                let of_child = if is_first { of_first } else { 1.0 - of_first };
                is_under_way[lane] = goes_on;
                low[lane] = if goes_on { from } else { low[lane] };
                chance[lane] = if goes_on { chance[lane] * of_child } else { chance[lane] };
                node[lane] = if goes_on { children[lane] + u32::from(!is_first) } else { node[lane] };
            }
        }
        let mut rest = [0.0; W];
        for lane in 0..W {
            rest[lane] = place_within((u[lane] - low[lane]) / chance[lane]);
        }
        for lane in 0..W {
            let light = ChosenLight { number: number[lane], chance: chance[lane] as f32, rest: rest[lane] };
            chosen[lane] = (is_there[lane] & (light.chance > 0.0)).then_some(light);
        }
        chosen
    }
}
