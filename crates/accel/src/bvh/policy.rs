//! When to stop, and what a leaf costs.

use super::BuildOptions;
use super::reference::Reference;
use eosphor_core::hierarchy::MAX_BVH_DEPTH;

/// What entering a set of primitives costs a ray, whatever the set holds, in tests. Without it a cut through a room looks cheap: of
/// its walls there are few. But all rays that pass what is cut off visit nodes for it.
const ENTRY: f32 = 4.0;

/// Sets of so many primitives and of usual size are split by what they hold alone. Their leaves are fuller so, and rays through
/// scans wait for memory.
const FEW: usize = 64;

/// Sets with so many times the root's area, divided by the number of all primitives, are large.
const LARGE: f32 = 100.0;

/// What splitting a large set that fits into a leaf costs. Beside `ENTRY`, boxes of less than 0.94 of the area are worth it.
const LARGE_SPLIT: f32 = 0.3;

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
    /// Of both kinds.
    primitives: u32,
    /// Whether sets that fit into a leaf become one, unless they are large: nothing is cheaper than one block.
    pub(super) always_leaf: bool,
    /// Half the area of the smallest large sets.
    large_area: f32,
    /// What entering a set costs, in tests.
    entry: f32,
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
            primitives: (triangles + others) as u32,
            always_leaf: false,
            large_area: f32::INFINITY,
            entry: 0.0,
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

    /// With a cost of entering sets, and with leaves of large ones split where that is worth it. Takes half the root's area.
    pub(super) fn with_entry(self, root_area: f32) -> Policy {
        let large_area = root_area / self.primitives.max(1) as f32 * LARGE;
        Policy { entry: ENTRY, large_area, traversal_cost: LARGE_SPLIT, ..self }
    }

    /// For a set of so many primitives, by half the area of its box.
    #[inline(always)]
    pub(super) fn of_set(&self, count: usize, area: f32) -> Policy {
        let entry = if count > FEW || self.is_large(area) { self.entry } else { 0.0 };
        Policy { entry, ..*self }
    }

    #[inline(always)]
    fn is_large(&self, area: f32) -> bool {
        area >= self.large_area && area < f32::INFINITY
    }

    /// Cost of testing so many primitives, with that of entering them.
    #[inline(always)]
    pub(super) fn tests(&self, count: u32) -> f32 {
        ((count + self.block_mask) >> self.block_shift) as f32 + self.entry
    }

    /// Whether a set that fits into a leaf becomes one without a look at its splits. Takes half the area of its box.
    #[inline(always)]
    pub(super) fn is_leaf(&self, count: usize, depth: usize, area: f32) -> bool {
        let is_usual = !self.is_large(area) || self.must_halve(count, depth);
        count == 1 || (self.always_leaf && is_usual) || self.must_stop(depth)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Builder;

    #[test]
    fn large_sets_cost_more_and_may_be_split() {
        let options = BuildOptions::of(Builder::Spatial);
        let plain = Policy::new(&options, Purpose::Eight, 1000, 0);
        let policy = plain.with_entry(10.0);
        // From a tenth of the root's area on they are large: a hundred times a thousandth.
        for (count, area, entry) in [(FEW, 0.9, 0.0), (FEW, 1.1, ENTRY), (FEW + 1, 0.9, ENTRY)] {
            let tests = plain.tests(count as u32);
            assert_eq!(policy.of_set(count, area).tests(count as u32), tests + entry, "{count} in {area}");
        }
        assert!(policy.is_leaf(4, 0, 0.9) && !policy.is_leaf(4, 0, 1.1));
        // One triangle cannot be split, a set without bounds has no area, and deep down nothing but halving ends in time.
        assert!(
            policy.is_leaf(1, 0, 1.1)
                && policy.is_leaf(4, 0, f32::INFINITY)
                && policy.is_leaf(4, 0, f32::NAN)
        );
        assert!(policy.is_leaf(4, MAX_BVH_DEPTH - 4, 1.1));
        assert!(plain.is_leaf(4, 0, 1e30));
    }
}
