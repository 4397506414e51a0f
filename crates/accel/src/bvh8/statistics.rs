//! The 8-wide hierarchy in numbers.

use super::node::held;
use super::{Bvh8, Child, EMPTY, LEAF};
use crate::HierarchyStatistics;
use crate::cost::{self, TreeCost, half_area};
use eosphor_core::geometry::Bounds;
use eosphor_core::math::vec3;

impl Bvh8 {
    /// The hierarchy in numbers, all trees together. Depths count wide nodes; a leaf holds one block of up to four triangles, one
    /// sphere or one instance.
    pub fn statistics(&self) -> HierarchyStatistics {
        let mut s = HierarchyStatistics {
            structure: "bvh8",
            builder: self.builder.name(),
            bytes: (size_of_val(&self.nodes[..])
                + size_of_val(&self.blocks[..])
                + size_of_val(&self.spheres[..])
                + size_of_val(&self.sphere_primitives[..])) as u64,
            build_seconds: self.build_seconds,
            ..HierarchyStatistics::default()
        };
        let mut depth_sum = 0u64;
        let roots = self.roots.iter().chain([&self.instance_root]);
        let mut trees = vec![TreeCost::NOTHING; self.roots.len()];
        let mut inner = 0.0;
        for (number, &root) in roots.enumerate().filter(|(_, root)| **root != EMPTY) {
            let bounds = match self.bounds.get(number) {
                Some(bounds) if root & LEAF != 0 => *bounds,
                _ if root & LEAF != 0 => self.instance_bounds,
                _ => self.around_children(root),
            };
            // What inner nodes cost, and leaves.
            let mut weighted = [0.0; 2];
            // Children, their depths and the areas of their boxes.
            let mut pending: Vec<(Child, u32, f64)> = vec![(root, 0, half_area(&bounds))];
            while let Some((child, depth, area)) = pending.pop() {
                s.nodes += 1;
                if child & LEAF == 0 {
                    weighted[0] += area;
                    let node = &self.nodes[child as usize];
                    let children = (0..8).filter(|&k| node.children[k] != EMPTY);
                    pending.extend(children.map(|k| (node.children[k], depth + 1, self.area(child, k))));
                    continue;
                }
                let held = held(&self.blocks, child);
                s.leaves += 1;
                s.primitives += held as u64;
                weighted[1] += area * f64::from(held);
                depth_sum += depth as u64;
                s.max_leaf_depth = s.max_leaf_depth.max(depth);
                s.max_leaf_primitives = s.max_leaf_primitives.max(held);
            }
            match trees.get_mut(number) {
                Some(tree) => *tree = TreeCost::new(bounds, weighted[0] + weighted[1]),
                // To the tree over the instances leaves are trees of their own.
                None => inner = weighted[0],
            }
        }
        s.sah_cost = cost::scene_cost(&trees, inner, &self.instances);
        s.mean_leaf_depth = depth_sum as f64 / s.leaves.max(1) as f64;
        s.mean_leaf_primitives = s.primitives as f64 / s.leaves.max(1) as f64;
        s
    }

    /// Half the surface of a child's box.
    fn area(&self, node: Child, child: usize) -> f64 {
        let planes = &self.nodes[node as usize].planes;
        half_area(&bounds(|plane| planes[plane][child]))
    }

    /// The box around all children.
    fn around_children(&self, node: Child) -> Bounds {
        let planes = &self.nodes[node as usize].planes;
        bounds(|plane| {
            let values = planes[plane].iter().copied();
            if plane % 2 == 0 {
                values.fold(f32::INFINITY, f32::min)
            } else {
                values.fold(f32::NEG_INFINITY, f32::max)
            }
        })
    }
}

/// The box between planes: the lower and the upper one of x, then of y and z.
fn bounds(plane: impl Fn(usize) -> f32) -> Bounds {
    Bounds { min: vec3(plane(0), plane(2), plane(4)), max: vec3(plane(1), plane(3), plane(5)) }
}
