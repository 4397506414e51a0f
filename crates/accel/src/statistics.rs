//! A hierarchy in numbers (PG1's table T4).

use crate::Bvh;
use eosphor_core::hierarchy::BvhNode;

/// A hierarchy in numbers.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct HierarchyStatistics {
    /// Name of the structure.
    pub structure: &'static str,
    /// Name of the builder.
    pub builder: &'static str,
    /// Primitives inside; instances count as one each in their tree.
    pub primitives: u64,
    /// How often leaves name primitives: more than there are where cells share them.
    pub references: u64,
    /// Nodes, leaves included.
    pub nodes: u64,
    /// Leaves.
    pub leaves: u64,
    /// Leaves that hold nothing.
    pub empty_leaves: u64,
    /// Mean depth of the leaves; a root has depth 0.
    pub mean_leaf_depth: f64,
    /// Largest depth of a leaf.
    pub max_leaf_depth: u32,
    /// Primitives in the fullest leaf.
    pub max_leaf_primitives: u32,
    /// Mean primitives a leaf.
    pub mean_leaf_primitives: f64,
    /// Expected cost of a ray that meets the box around the whole scene, by the surface area heuristic: a visit to an inner
    /// node and a test of a primitive count 1 each. The world's own tree counts by its share of that box's surface, and so does
    /// the tree over the instances. Each of its leaves, an instance, costs what the own tree of its mesh does, times the share of
    /// its placed box. Without a hierarchy a test of an instance's box counts 1, too. 0 where the box has no surface.
    pub sah_cost: f64,
    /// Bytes of nodes and packed primitives.
    pub bytes: u64,
    /// Wall time of the build.
    pub build_seconds: f64,
}

impl HierarchyStatistics {
    /// Of the trees with these roots.
    pub(crate) fn of_bvh(bvh: &Bvh, roots: &[u32]) -> HierarchyStatistics {
        let p = &bvh.primitives;
        let mut s = HierarchyStatistics {
            structure: "bvh",
            builder: bvh.builder.name(),
            build_seconds: bvh.build_seconds,
            bytes: (size_of_val(&bvh.nodes[..])
                + size_of_val(&p.triangles[..])
                + size_of_val(&p.spheres[..])
                + size_of_val(&p.sphere_primitives[..])) as u64,
            ..HierarchyStatistics::default()
        };
        let mut depth_sum = 0u64;
        for &root in roots {
            let mut pending = vec![(root, 0u32)];
            while let Some((at, depth)) = pending.pop() {
                let node = &bvh.nodes[at as usize];
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
