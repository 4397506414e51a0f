//! The binary hierarchy in numbers.

use super::Bvh;
use crate::HierarchyStatistics;
use eosphor_core::hierarchy::BvhNode;

impl Bvh {
    /// Of the trees with these roots.
    pub(super) fn count_trees(&self, roots: &[u32]) -> HierarchyStatistics {
        let p = &self.primitives;
        let mut s = HierarchyStatistics {
            structure: "bvh",
            builder: self.builder.name(),
            build_seconds: self.build_seconds,
            bytes: (size_of_val(&self.nodes[..])
                + size_of_val(&p.triangles[..])
                + size_of_val(&p.spheres[..])
                + size_of_val(&p.sphere_primitives[..])) as u64,
            ..HierarchyStatistics::default()
        };
        let mut depth_sum = 0u64;
        for &root in roots {
            let mut pending = vec![(root, 0u32)];
            while let Some((at, depth)) = pending.pop() {
                let node = &self.nodes[at as usize];
                s.nodes += 1;
                let count = node.count & !BvhNode::SPHERES;
                if node.is_inner() {
                    pending.extend([(node.first, depth + 1), (node.first + 1, depth + 1)]);
                    continue;
                }
                s.leaves += 1;
                s.primitives += count as u64;
                s.empty_leaves += (count == 0) as u64;
                depth_sum += depth as u64;
                s.max_leaf_depth = s.max_leaf_depth.max(depth);
                s.max_leaf_primitives = s.max_leaf_primitives.max(count);
            }
        }
        s.references = s.primitives;
        s.mean_leaf_depth = depth_sum as f64 / s.leaves.max(1) as f64;
        s.mean_leaf_primitives = s.primitives as f64 / s.leaves.max(1) as f64;
        s
    }
}
