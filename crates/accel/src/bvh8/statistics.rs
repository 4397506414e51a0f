//! The 8-wide hierarchy in numbers.

use super::{Bvh8, Child, EMPTY, INSTANCE, LEAF, PLACE, SPHERE};
use crate::HierarchyStatistics;

impl Bvh8 {
    /// All trees together. Depths count wide nodes; a leaf holds one block of up to four triangles, one sphere or one
    /// instance.
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
        for (number, &root) in roots.enumerate().filter(|(_, root)| **root != EMPTY) {
            let root_area = if root & LEAF == 0 { self.area_of_children(root) } else { 0.0 };
            // Children, their depths and the areas of their boxes.
            let mut pending: Vec<(Child, u32, f64)> = vec![(root, 0, root_area)];
            while let Some((child, depth, area)) = pending.pop() {
                s.nodes += 1;
                let share = if number == 0 && root_area > 0.0 { area / root_area } else { 0.0 };
                if child & LEAF == 0 {
                    s.sah_cost += share;
                    let node = &self.nodes[child as usize];
                    let children = (0..8).filter(|&k| node.children[k] != EMPTY);
                    pending.extend(children.map(|k| (node.children[k], depth + 1, self.area(child, k))));
                    continue;
                }
                let held = self.held(child);
                s.leaves += 1;
                s.primitives += held as u64;
                s.sah_cost += share * held as f64;
                depth_sum += depth as u64;
                s.max_leaf_depth = s.max_leaf_depth.max(depth);
                s.max_leaf_primitives = s.max_leaf_primitives.max(held);
            }
        }
        s.mean_leaf_depth = depth_sum as f64 / s.leaves.max(1) as f64;
        s.mean_leaf_primitives = s.primitives as f64 / s.leaves.max(1) as f64;
        s
    }

    /// Primitives of a leaf.
    fn held(&self, leaf: Child) -> u32 {
        if leaf & (SPHERE | INSTANCE) != 0 {
            return 1;
        }
        let block = &self.blocks[(leaf & PLACE) as usize];
        block.primitive.iter().filter(|&&primitive| primitive != u32::MAX).count() as u32
    }

    /// Half the surface of a child's box.
    fn area(&self, node: Child, child: usize) -> f64 {
        let planes = &self.nodes[node as usize].planes;
        half_area(|plane| planes[plane][child])
    }

    /// Half the surface of the box around all children.
    fn area_of_children(&self, node: Child) -> f64 {
        let planes = &self.nodes[node as usize].planes;
        half_area(|plane| {
            let values = planes[plane].iter().copied();
            if plane % 2 == 0 {
                values.fold(f32::INFINITY, f32::min)
            } else {
                values.fold(f32::NEG_INFINITY, f32::max)
            }
        })
    }
}

fn half_area(plane: impl Fn(usize) -> f32) -> f64 {
    let side = |axis: usize| (plane(2 * axis + 1) as f64 - plane(2 * axis) as f64).max(0.0);
    let (x, y, z) = (side(0), side(1), side(2));
    x * y + y * z + z * x
}
