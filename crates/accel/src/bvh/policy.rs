//! When to stop, and what a leaf costs.

use super::BuildOptions;
use super::reference::Reference;
use eosphor_core::hierarchy::MAX_BVH_DEPTH;

/// What a tree is built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// To be traversed as it is.
    Two,
    /// To be collapsed to eight children a node: leaves are blocks of four triangles, or one sphere, or one instance.
    Eight,
}

/// When to stop, and what a leaf costs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Policy {
    /// Primitives with smaller numbers are triangles (or instances), the others spheres.
    pub(super) triangle_count: u32,
    /// Whether there are both.
    pub(super) mixed: bool,
    /// Most triangles, and most spheres, of a leaf.
    pub(super) max_leaf: [u32; 2],
    /// Whether leaves that could be are always made: nothing is cheaper than one block.
    pub(super) always_leaf: bool,
    /// Whether several references may be parts of one triangle.
    pub(super) has_parts: bool,
    /// Primitives that are tested together at the cost of one, less one.
    block_mask: u32,
    /// The binary logarithm of the same.
    block_shift: u32,
    pub(super) traversal_cost: f32,
    /// Leaves lie no deeper.
    pub(super) max_depth: usize,
    stop_at_max_depth: bool,
}

/// What may become of a set of references.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fit {
    /// Too many for a leaf.
    TooMany,
    /// They could be a leaf.
    Leaf { spheres: bool },
    /// There are few enough, but of both kinds.
    Mixed,
}

impl Policy {
    pub(super) fn new(options: &BuildOptions, purpose: Purpose, triangles: usize, others: usize) -> Policy {
        let leaf = options.max_leaf_primitives.clamp(1, 255);
        let usual = Policy {
            triangle_count: triangles as u32,
            mixed: triangles > 0 && others > 0,
            max_leaf: [leaf, leaf],
            always_leaf: false,
            has_parts: false,
            block_mask: 0,
            block_shift: 0,
            traversal_cost: options.traversal_cost,
            max_depth: (options.max_depth as usize).min(MAX_BVH_DEPTH),
            stop_at_max_depth: (options.max_depth as usize) < MAX_BVH_DEPTH,
        };
        match purpose {
            Purpose::Two => usual,
            Purpose::Eight => Policy {
                max_leaf: [4, 1],
                always_leaf: true,
                block_mask: 3,
                block_shift: 2,
                max_depth: MAX_BVH_DEPTH,
                stop_at_max_depth: false,
                ..usual
            },
        }
    }

    /// Cost of testing so many primitives.
    #[inline(always)]
    pub(super) fn tests(&self, count: u32) -> f32 {
        ((count + self.block_mask) >> self.block_shift) as f32
    }

    #[inline(always)]
    fn is_sphere(&self, r: &Reference) -> bool {
        r.index() >= self.triangle_count
    }

    /// Whether the references could be a leaf.
    #[inline(always)]
    pub(super) fn fit(&self, references: &[Reference], depth: usize) -> Fit {
        let count = references.len() as u32;
        let forced = self.stop_at_max_depth && depth >= self.max_depth;
        if count > self.max_leaf[0].max(self.max_leaf[1]) && !forced {
            return Fit::TooMany;
        }
        let spheres = self.is_sphere(&references[0]);
        if self.mixed && count > 1 && references.iter().any(|r| self.is_sphere(r) != spheres) {
            return Fit::Mixed;
        }
        if count > self.max_leaf[usize::from(spheres)] && !forced {
            return Fit::TooMany;
        }
        Fit::Leaf { spheres }
    }

    /// Whether only halving from here on reaches leaves within the depth that traversals have a stack for.
    #[inline(always)]
    pub(super) fn must_halve(&self, count: usize, depth: usize) -> bool {
        let halvings = usize::BITS - (count - 1).leading_zeros();
        depth + halvings as usize + 2 >= MAX_BVH_DEPTH
    }

    /// Whether leaves must be made here, whatever they cost.
    #[inline(always)]
    pub(super) fn must_stop(&self, depth: usize) -> bool {
        self.stop_at_max_depth && depth >= self.max_depth
    }
}
