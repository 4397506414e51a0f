//! How a hierarchy is built.

use super::Accel;
use crate::{BuildOptions, Builder, KdTreeOptions, OctreeOptions};
use eosphor_core::hierarchy::{MAX_BVH_DEPTH, MAX_KD_DEPTH, MAX_OCTREE_DEPTH};

/// How a hierarchy is built. It changes the time that a picture takes, and no pixel. What is `None` is the structure's
/// default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HierarchyOptions {
    /// What chooses the splits of bounding volume hierarchies.
    pub builder: Option<Builder>,
    /// Primitives that a leaf may hold: of a bvh, 1 to 255; of octrees, whose cells with more are divided where that pays.
    pub leaf_size: Option<u32>,
    /// Depth of the deepest leaves; a root has depth 0. Leaves that lie as deep hold whatever is left.
    pub tree_depth: Option<u32>,
    /// The costs by which the surface area heuristic chooses splits.
    pub sah_costs: Option<SahCosts>,
}

/// The costs by which the surface area heuristic chooses splits; only their ratio matters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SahCosts {
    /// The cost of visiting a node, 0 or more.
    pub node: f32,
    /// The cost of testing a primitive, over 0.
    pub primitive: f32,
}

impl SahCosts {
    /// What visiting a node costs, in tests of a primitive.
    fn ratio(self) -> f32 {
        self.node / self.primitive
    }
}

/// An option that a structure does not have, or has in another range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OptionMisfit {
    /// Which option it is.
    pub option: HierarchyOption,
    /// What is wrong with it.
    pub kind: MisfitKind,
}

/// What is wrong with an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MisfitKind {
    /// The option would do nothing but with the structures named here.
    Structure(&'static str),
    /// The value must be what is said here.
    Range(&'static str),
}

/// The name of a field of [`HierarchyOptions`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HierarchyOption {
    /// [`HierarchyOptions::builder`]
    Builder,
    /// [`HierarchyOptions::leaf_size`]
    LeafSize,
    /// [`HierarchyOptions::tree_depth`]
    TreeDepth,
    /// [`HierarchyOptions::sah_costs`]
    SahCosts,
}

/// A fixed text of the depth's bounds, which the tests hold against the constants.
const DEPTHS: [(&[Accel], usize, &str); 3] = [
    (&[Accel::Bvh], MAX_BVH_DEPTH, "a number from 1 to 64 with a bvh"),
    (&[Accel::Octree, Accel::OctreeParametric], MAX_OCTREE_DEPTH, "a number from 1 to 16 with an octree"),
    (&[Accel::KdTree], MAX_KD_DEPTH - 2, "a number from 1 to 46 with a kd-tree"),
];

impl HierarchyOptions {
    /// Options with this builder, and the structure's defaults for everything else.
    pub fn with_builder(builder: Builder) -> HierarchyOptions {
        HierarchyOptions { builder: Some(builder), ..HierarchyOptions::default() }
    }

    /// Fails with the first option that would do nothing with a structure, or is out of its range. `None` is the program's
    /// choice of a structure, which is a bvh or a bvh8.
    ///
    /// # Errors
    ///
    /// [`OptionMisfit`] names the option and says what is wrong with it.
    pub fn check(&self, accel: Option<Accel>) -> Result<(), OptionMisfit> {
        use HierarchyOption as O;
        let alone =
            |option, structures| Err(OptionMisfit { option, kind: MisfitKind::Structure(structures) });
        let range = |option, range| Err(OptionMisfit { option, kind: MisfitKind::Range(range) });
        let is_octree = matches!(accel, Some(Accel::Octree | Accel::OctreeParametric));
        let (is_bvh, is_kdtree) = (accel == Some(Accel::Bvh), accel == Some(Accel::KdTree));
        if self.builder.is_some() && !matches!(accel, None | Some(Accel::Bvh | Accel::Bvh8)) {
            return alone(O::Builder, "bvh or bvh8");
        }
        if let Some(size) = self.leaf_size {
            if !(is_bvh || is_octree) {
                return alone(O::LeafSize, "bvh, octree or octree-parametric");
            }
            if size == 0 || (is_bvh && size > 255) {
                return range(O::LeafSize, "a number from 1, with a bvh to 255");
            }
        }
        if let Some(depth) = self.tree_depth {
            let depths =
                DEPTHS.iter().find(|(accels, ..)| accel.is_some_and(|accel| accels.contains(&accel)));
            match depths {
                None => return alone(O::TreeDepth, "bvh, octree, octree-parametric or kdtree"),
                Some(&(_, most, text)) if depth == 0 || depth as usize > most => {
                    return range(O::TreeDepth, text);
                }
                _ => {}
            }
        }
        if let Some(costs) = self.sah_costs {
            let chooses_by_cost = self.builder != Some(Builder::Morton);
            if !(is_bvh && chooses_by_cost || is_octree || is_kdtree) {
                return alone(
                    O::SahCosts,
                    "bvh (by another builder than morton), octree, octree-parametric or kdtree",
                );
            }
            if !(costs.node >= 0.0 && costs.primitive > 0.0 && costs.ratio().is_finite()) {
                return range(
                    O::SahCosts,
                    "the cost of a node, 0 or more, and the cost of a primitive's test, over 0",
                );
            }
        }
        Ok(())
    }

    /// For bounding volume hierarchies.
    pub(crate) fn bvh(&self) -> BuildOptions {
        let mut options = BuildOptions::of(self.builder.unwrap_or(BuildOptions::default().builder));
        options.max_leaf_primitives = self.leaf_size.unwrap_or(options.max_leaf_primitives);
        options.max_depth = self.tree_depth.unwrap_or(options.max_depth);
        options.traversal_cost = self.sah_costs.map_or(options.traversal_cost, SahCosts::ratio);
        options
    }

    /// For octrees whose defaults these are.
    pub(crate) fn octree(&self, default: OctreeOptions) -> OctreeOptions {
        OctreeOptions {
            max_leaf_primitives: self.leaf_size.unwrap_or(default.max_leaf_primitives),
            max_depth: self.tree_depth.unwrap_or(default.max_depth),
            // Beyond the one test that an inner node is taken for anyway.
            visit_cost: self.sah_costs.map_or(default.visit_cost, |costs| costs.ratio() - 1.0),
            ..default
        }
    }

    /// For kd-trees.
    pub(crate) fn kdtree(&self) -> KdTreeOptions {
        let default = KdTreeOptions::default();
        KdTreeOptions {
            traversal_cost: self.sah_costs.map_or(default.traversal_cost, SahCosts::ratio),
            max_depth: self.tree_depth.unwrap_or(default.max_depth),
            ..default
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_fit_their_structures_alone() {
        let leaf_size = HierarchyOptions { leaf_size: Some(4), ..Default::default() };
        let tree_depth = HierarchyOptions { tree_depth: Some(8), ..Default::default() };
        let costs = SahCosts { node: 1.0, primitive: 2.0 };
        let sah_costs = HierarchyOptions { sah_costs: Some(costs), ..Default::default() };
        let builder = HierarchyOptions::with_builder(Builder::Morton);
        let fitting = |options: HierarchyOptions| {
            Accel::ALL.iter().filter(|&&a| options.check(Some(a)).is_ok()).copied().collect::<Vec<_>>()
        };
        let octrees = [Accel::Octree, Accel::OctreeParametric];
        assert_eq!(fitting(builder), [Accel::Bvh, Accel::Bvh8]);
        assert_eq!(fitting(leaf_size), [&[Accel::Bvh], &octrees[..]].concat());
        assert_eq!(fitting(tree_depth), [&[Accel::Bvh], &octrees[..], &[Accel::KdTree]].concat());
        assert_eq!(fitting(sah_costs), [&[Accel::Bvh], &octrees[..], &[Accel::KdTree]].concat());
        assert!(
            builder.check(None).is_ok() && leaf_size.check(None).is_err() && sah_costs.check(None).is_err()
        );
        let morton = HierarchyOptions { sah_costs: Some(costs), ..builder };
        assert_eq!(morton.check(Some(Accel::Bvh)).unwrap_err().option, HierarchyOption::SahCosts);
    }

    #[test]
    fn ranges_are_those_of_the_structures() {
        for (accels, most, text) in DEPTHS {
            let options = |depth| HierarchyOptions { tree_depth: Some(depth), ..Default::default() };
            for &accel in accels {
                assert!(
                    options(1).check(Some(accel)).is_ok() && options(most as u32).check(Some(accel)).is_ok()
                );
                for bad in [0, most as u32 + 1, u32::MAX] {
                    assert_eq!(options(bad).check(Some(accel)).unwrap_err().kind, MisfitKind::Range(text));
                }
            }
            assert!(text.contains(&format!("to {most} ")), "{text}");
        }
        for (size, fits) in [(0, false), (1, true), (255, true), (256, false)] {
            let options = HierarchyOptions { leaf_size: Some(size), ..Default::default() };
            assert_eq!(options.check(Some(Accel::Bvh)).is_ok(), fits);
        }
        for (node, primitive) in [(f32::NAN, 1.0), (-1.0, 1.0), (1.0, 0.0), (f32::INFINITY, 1.0), (1.0, -1.0)]
        {
            let sah_costs = Some(SahCosts { node, primitive });
            assert!(HierarchyOptions { sah_costs, ..Default::default() }.check(Some(Accel::Bvh)).is_err());
        }
    }
}
