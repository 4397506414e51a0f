//! From two children a node to eight: the largest children are opened until there are eight.

use super::{Bvh8, Child, EMPTY, INSTANCE, LEAF, Node8, SPHERE, TriangleBlock};
use crate::Bvh;
use eosphor_core::hierarchy::BvhNode;

pub(super) fn collapse(bvh: &Bvh) -> Bvh8 {
    let mut out = Bvh8 {
        nodes: Vec::new(),
        blocks: Vec::new(),
        spheres: bvh.primitives.spheres.clone(),
        sphere_primitives: bvh.primitives.sphere_primitives.clone(),
        roots: Vec::new(),
        instance_root: EMPTY,
        geometries: bvh.primitives.geometries.clone(),
        instances: bvh.primitives.instances.clone(),
        instances_extent: 0.0,
        build_seconds: 0.0,
    };
    for &root in &bvh.roots {
        let child = emit(bvh, root, false, &mut out);
        out.roots.push(child);
    }
    if !bvh.instance_order.is_empty() {
        out.instance_root = emit(bvh, bvh.instance_root, true, &mut out);
    }
    out
}

/// Primitives of small leaves one by one, so that a leaf is one block, one sphere or one instance.
enum Open {
    Node(u32),
    Leaf(Child, eosphor_core::geometry::Bounds),
}

fn emit(bvh: &Bvh, at: u32, instances: bool, out: &mut Bvh8) -> Child {
    let node = &bvh.nodes[at as usize];
    if !node.is_inner() {
        let mut leaves = leaves_of(bvh, node, instances, out);
        return match leaves.len() {
            0 => EMPTY,
            1 => leaves.pop().expect("one").0,
            _ => emit_node(bvh, leaves.into_iter().map(|(c, b)| Open::Leaf(c, b)).collect(), instances, out),
        };
    }
    let mut open = vec![Open::Node(node.first), Open::Node(node.first + 1)];
    loop {
        if open.len() == 8 {
            break;
        }
        let largest = open
            .iter()
            .enumerate()
            .filter_map(|(k, o)| match o {
                Open::Node(n) if bvh.nodes[*n as usize].is_inner() => Some((k, *n)),
                _ => None,
            })
            .max_by(|a, b| {
                let area = |n: u32| bvh.nodes[n as usize].bounds().half_area();
                area(a.1).total_cmp(&area(b.1))
            });
        let Some((k, n)) = largest else { break };
        let first = bvh.nodes[n as usize].first;
        open[k] = Open::Node(first);
        open.push(Open::Node(first + 1));
    }
    emit_node(bvh, open, instances, out)
}

fn leaves_of(
    bvh: &Bvh,
    node: &BvhNode,
    instances: bool,
    out: &mut Bvh8,
) -> Vec<(Child, eosphor_core::geometry::Bounds)> {
    let count = node.count & !BvhNode::SPHERES;
    let range = node.first..node.first + count;
    if instances {
        range
            .map(|k| {
                let number = bvh.instance_order[k as usize];
                (LEAF | INSTANCE | number, bvh.primitives.instances[number as usize].world_bounds)
            })
            .collect()
    } else if node.count & BvhNode::SPHERES != 0 {
        range.map(|k| (LEAF | SPHERE | k, node.bounds())).collect()
    } else {
        let triangles = &bvh.primitives.triangles[node.first as usize..][..count as usize];
        triangles
            .chunks(4)
            .map(|chunk| {
                let mut block = TriangleBlock::EMPTY;
                for (lane, triangle) in chunk.iter().enumerate() {
                    block.set(lane, triangle);
                }
                out.blocks.push(block);
                (LEAF | (out.blocks.len() as u32 - 1), node.bounds())
            })
            .collect()
    }
}

fn emit_node(bvh: &Bvh, mut open: Vec<Open>, instances: bool, out: &mut Bvh8) -> Child {
    assert!(open.len() <= 8, "TODO large leaves");
    let at = out.nodes.len();
    out.nodes.push(Node8::EMPTY);
    let mut node = Node8::EMPTY;
    for (k, o) in open.drain(..).enumerate() {
        let (child, b) = match o {
            Open::Leaf(child, bounds) => (child, bounds),
            Open::Node(n) => (emit(bvh, n, instances, out), bvh.nodes[n as usize].bounds()),
        };
        node.children[k] = child;
        if child != EMPTY {
            for axis in 0..3 {
                node.planes[2 * axis][k] = b.min[axis];
                node.planes[2 * axis + 1][k] = b.max[axis];
            }
        }
    }
    for octant in 0..8 {
        let mut order: Vec<(f32, u32)> = (0..8u32)
            .map(|k| {
                if node.children[k as usize] == EMPTY {
                    return (f32::INFINITY, k);
                }
                let key = (0..3).map(|axis| {
                    let middle = node.planes[2 * axis][k as usize] + node.planes[2 * axis + 1][k as usize];
                    if octant >> axis & 1 == 1 { -middle } else { middle }
                });
                (key.sum(), k)
            })
            .collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        node.orders[octant] = order.iter().enumerate().fold(0, |bits, (k, e)| bits | e.1 << (3 * k));
    }
    out.nodes[at] = node;
    at as Child
}
