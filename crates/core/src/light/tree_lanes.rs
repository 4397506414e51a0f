//! The way down a tree of lights for several points at a time.
//!
//! What lanes read of nodes does not depend on each other, so it comes from memory together; what they compute stands in short
//! loops over arrays, free of branches, which become SIMD code.

use super::tree::{ChosenLight, Descent, LightNode, LightReceiver, LightTree, share_of_first};
use crate::math::{Vec3Lanes, vec3};
use crate::sampling::place_within;

/// Nodes that lanes look at: what stands together in memory is copied at once.
struct NodeRows<const W: usize> {
    /// Center and radius.
    place: [[f32; 4]; W],
    /// Normal and variance.
    normal: [[f32; 4]; W],
    power: [f32; W],
    children: [u32; W],
}

impl<const W: usize> NodeRows<W> {
    /// Nodes that promise nothing.
    const NONE: NodeRows<W> =
        NodeRows { place: [[0.0; 4]; W], normal: [[0.0; 4]; W], power: [0.0; W], children: [0; W] };

    #[inline(always)]
    fn set(&mut self, lane: usize, node: &LightNode) {
        self.place[lane] = [node.center.x, node.center.y, node.center.z, node.radius];
        self.normal[lane] = [node.normal.x, node.normal.y, node.normal.z, node.variance];
        self.power[lane] = node.power;
        self.children[lane] = node.children;
    }

    #[inline(always)]
    fn lanes(&self) -> NodeLanes<W> {
        NodeLanes {
            place: across(&self.place),
            normal: across(&self.normal),
            power: self.power,
            children: self.children,
        }
    }
}

/// Columns of rows.
#[inline(always)]
fn across<const W: usize>(rows: &[[f32; 4]; W]) -> [[f32; W]; 4] {
    let mut columns = [[0.0; W]; 4];
    for lane in 0..W {
        let [x, y, z, w] = rows[lane];
        columns[0][lane] = x;
        columns[1][lane] = y;
        columns[2][lane] = z;
        columns[3][lane] = w;
    }
    columns
}

/// The same nodes, each number of all of them together.
#[derive(Clone, Copy)]
pub(super) struct NodeLanes<const W: usize> {
    place: [[f32; W]; 4],
    normal: [[f32; W]; 4],
    power: [f32; W],
    children: [u32; W],
}

impl<const W: usize> NodeLanes<W> {
    /// Of nodes.
    #[inline(always)]
    pub(super) fn new(nodes: &[LightNode; W]) -> NodeLanes<W> {
        let mut rows = NodeRows::NONE;
        for lane in 0..W {
            rows.set(lane, &nodes[lane]);
        }
        rows.lanes()
    }

    /// What a node promises a receiver.
    #[inline(always)]
    pub(super) fn importance(&self, lane: usize, receiver: &LightReceiver) -> f32 {
        let ([cx, cy, cz, radius], [nx, ny, nz, variance]) = (&self.place, &self.normal);
        let node = LightNode {
            center: vec3(cx[lane], cy[lane], cz[lane]),
            radius: radius[lane],
            normal: vec3(nx[lane], ny[lane], nz[lane]),
            variance: variance[lane],
            power: self.power[lane],
            first_chance: -1.0,
            children: self.children[lane],
            number: 0,
        };
        node.importance(receiver)
    }
}

/// Where lanes are in a tree; of each, see [`Descent`] and [`LightTree::choose`].
#[derive(Clone, Copy)]
pub(super) struct DescentLanes<const W: usize> {
    pub(super) node: [u32; W],
    pub(super) chance: [f64; W],
    /// The least number whose way leads there.
    pub(super) low: [f64; W],
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
        let root = DescentLanes { node: [0; W], chance: [1.0; W], low: [0.0; W] };
        self.descend_lanes_from(is_wanted, receiver, u, root)
    }

    /// The same from where lanes are.
    #[inline(always)]
    pub(super) fn descend_lanes_from<const W: usize>(
        &self,
        is_wanted: &[bool; W],
        receiver: impl Fn(usize) -> LightReceiver,
        u: &[f64; W],
        from: DescentLanes<W>,
    ) -> [Option<ChosenLight>; W] {
        let mut chosen = [None; W];
        let (mut positions, mut normals) = (Vec3Lanes::<W>::ZERO, Vec3Lanes::<W>::ZERO);
        for lane in 0..W {
            let LightReceiver { position, normal } = receiver(lane);
            positions.set(lane, position);
            normals.set(lane, normal);
        }
        let DescentLanes { mut node, mut chance, mut low } = from;
        // Lanes on their way, and those that have come to a light.
        let (mut is_under_way, mut is_there) = (*is_wanted, [false; W]);
        let (mut children, mut first_chance, mut number) = ([0u32; W], [0.0f32; W], [0u32; W]);
        let (mut first, mut second) = (NodeRows::<W>::NONE, NodeRows::<W>::NONE);
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
                let pair = self.nodes.get(parent.children as usize..).and_then(|nodes| nodes.first_chunk());
                // Where the nodes are a tree, children come after their parent.
                if let Some([a, b]) = pair
                    && parent.children > node[lane]
                {
                    first.set(lane, a);
                    second.set(lane, b);
                    (first_chance[lane], children[lane]) = (parent.first_chance, parent.children);
                    (is_under_way[lane], is_any) = (true, true);
                }
            }
            if !is_any {
                break;
            }
            let (firsts, seconds) = (first.lanes(), second.lanes());
            let (mut share, mut is_reached) = ([0.0f32; W], [false; W]);
            for lane in 0..W {
                let receiver = LightReceiver { position: positions.get(lane), normal: normals.get(lane) };
                let promised = [firsts.importance(lane, &receiver), seconds.importance(lane, &receiver)];
                (share[lane], is_reached[lane]) = share_of_first(promised);
            }
            for lane in 0..W {
                let is_fixed = first_chance[lane] >= 0.0;
                let of_first = (if is_fixed { first_chance[lane] } else { share[lane] }) as f64;
                let goes_on = is_under_way[lane] & (is_fixed | is_reached[lane]);
                let at = Descent { node: node[lane], chance: chance[lane] };
                let (is_first, from) = at.turns(of_first, u[lane], low[lane]);
                let of_child = if is_first { of_first } else { 1.0 - of_first };
                low[lane] = if goes_on { from } else { low[lane] };
                chance[lane] = if goes_on { chance[lane] * of_child } else { chance[lane] };
                node[lane] = if goes_on { children[lane] + u32::from(!is_first) } else { node[lane] };
                is_under_way[lane] = goes_on;
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
