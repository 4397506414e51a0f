//! A hierarchy in numbers (PG1's table T4).

/// A hierarchy in numbers.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct HierarchyStatistics {
    /// Name of the structure, as [`crate::Accel::name`] has it.
    pub structure: &'static str,
    /// Name of the builder, as [`crate::Builder::name`] has it, or what the structure is built by.
    pub builder: &'static str,
    /// Primitives inside; instances count as one each in their tree.
    pub primitives: u64,
    /// How often leaves name primitives: more than there are where cells share them.
    pub references: u64,
    /// Number of nodes, leaves included.
    pub nodes: u64,
    /// Number of leaves.
    pub leaves: u64,
    /// Number of leaves that hold nothing.
    pub empty_leaves: u64,
    /// Mean depth of the leaves; a root has depth 0.
    pub mean_leaf_depth: f64,
    /// Largest depth of a leaf.
    pub max_leaf_depth: u32,
    /// Number of primitives in the fullest leaf.
    pub max_leaf_primitives: u32,
    /// Mean number of primitives in a leaf.
    pub mean_leaf_primitives: f64,
    /// Expected cost of a ray that meets the box around the whole scene, by the surface area heuristic: a visit to an inner
    /// node and a test of a primitive count 1 each. The world's own tree counts by its share of that box's surface, and so does
    /// the tree over the instances. Each of its leaves, an instance, costs what the own tree of its mesh does, times the share of
    /// its placed box. Without a hierarchy a test of an instance's box counts 1, too. 0 where the box has no surface.
    pub sah_cost: f64,
    /// Bytes of nodes and packed primitives.
    pub bytes: u64,
    /// Wall time of the build, in seconds.
    pub build_seconds: f64,
}
