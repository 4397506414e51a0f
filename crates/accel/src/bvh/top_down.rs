//! Building from the root down: what the builders that split sets of references have in common.

use super::binned::Bins;
use super::policy::{Fit, Policy};
use super::reference::{Extent, Reference};
use super::split::{MOST_RANKED, Rule, Split};
use super::tree::{PIECE_ITEMS, Piece, Tree};
use super::{Builder, binned, sweep};

/// Above this many primitives EOS's preset takes the spatial median.
const HYBRID_SWEEP: usize = 3000;

/// Builds over references by median, sweep or bins.
pub(super) struct TopDown<'a> {
    pub(super) builder: Builder,
    pub(super) policy: &'a Policy,
}

/// What becomes of a set of references.
enum Choice {
    Leaf { spheres: bool },
    Inner(Split),
}

impl TopDown<'_> {
    /// Builds over `from`; `to` is room of the same size. Large sets are split by all threads together, what they fall
    /// into by one thread each. Recursion is bounded with the depth of the tree.
    pub(super) fn build(
        &self,
        from: &mut [Reference],
        to: &mut [Reference],
        extent: &Extent,
        depth: usize,
    ) -> Piece {
        if from.len() <= PIECE_ITEMS {
            let mut tree = Tree::with_root(from.len());
            self.build_piece(from, to, extent, depth, &mut tree, 0, &mut Bins::empty());
            return Piece::Whole(tree);
        }
        match self.choose(from, extent, depth, &mut Bins::empty()) {
            Choice::Leaf { spheres } => {
                let mut tree = Tree::with_root(from.len());
                tree.set_leaf(0, extent.bounds, from, spheres);
                Piece::Whole(tree)
            }
            Choice::Inner(split) => {
                let (left_from, right_from) = to.split_at_mut(split.left_count);
                let extents = split.apply(from, left_from, right_from);
                let (left_to, right_to) = from.split_at_mut(split.left_count);
                let (left, right) = rayon::join(
                    || self.build(left_from, left_to, &extents[0], depth + 1),
                    || self.build(right_from, right_to, &extents[1], depth + 1),
                );
                Piece::Split(extent.bounds.bounds(), Box::new([left, right]))
            }
        }
    }

    #[allow(clippy::too_many_arguments, reason = "what a level of the recursion needs")]
    fn build_piece(
        &self,
        from: &mut [Reference],
        to: &mut [Reference],
        extent: &Extent,
        depth: usize,
        tree: &mut Tree,
        at: usize,
        bins: &mut Bins,
    ) {
        match self.choose(from, extent, depth, bins) {
            Choice::Leaf { spheres } => {
                let held = if self.policy.has_parts { Reference::without_doubles(from) } else { from };
                tree.set_leaf(at, extent.bounds, held, spheres);
            }
            Choice::Inner(split) => {
                let pair = tree.set_inner(at, extent.bounds);
                let (left_from, right_from) = to.split_at_mut(split.left_count);
                let extents = split.apply(from, left_from, right_from);
                let (left_to, right_to) = from.split_at_mut(split.left_count);
                self.build_piece(left_from, left_to, &extents[0], depth + 1, tree, pair, bins);
                self.build_piece(right_from, right_to, &extents[1], depth + 1, tree, pair + 1, bins);
            }
        }
    }

    #[inline(always)]
    fn choose(&self, references: &[Reference], extent: &Extent, depth: usize, bins: &mut Bins) -> Choice {
        let policy = self.policy;
        let count = references.len();
        let fit = policy.fit(references, depth);
        if let Fit::Leaf { spheres } = fit
            && (count == 1 || policy.always_leaf || policy.must_stop(depth))
        {
            return Choice::Leaf { spheres };
        }
        if fit == Fit::Mixed && policy.must_stop(depth) {
            return Choice::Inner(Split::by_kind(references, policy));
        }
        let split =
            if policy.must_halve(count, depth) { None } else { self.best_split(references, extent, bins) };
        if fit != Fit::TooMany {
            let area = extent.bounds.half_area();
            let split_cost = split.map_or(f32::INFINITY, |s| policy.traversal_cost * area + s.cost);
            if split_cost >= area * policy.tests(count as u32) {
                return match fit {
                    Fit::Leaf { spheres } => Choice::Leaf { spheres },
                    _ => Choice::Inner(Split::by_kind(references, policy)),
                };
            }
        }
        Choice::Inner(split.unwrap_or_else(|| Split::halves(count)))
    }

    #[inline(always)]
    fn best_split(&self, references: &[Reference], extent: &Extent, bins: &mut Bins) -> Option<Split> {
        let count = references.len();
        match self.builder {
            Builder::Median => median(references, extent),
            Builder::Hybrid if count > HYBRID_SWEEP => median(references, extent),
            Builder::Hybrid | Builder::Sweep => sweep::best_split(references, self.policy),
            _ if count <= MOST_RANKED => binned::best_of_few(references, self.policy),
            _ => binned::best_split(references, extent, self.policy, bins),
        }
    }
}

/// At the middle of the longest side of the box around the centres; `None` where that is a point.
fn median(references: &[Reference], extent: &Extent) -> Option<Split> {
    let (low, high) = (extent.centers2.low.array(), extent.centers2.high.array());
    let size = [0, 1, 2].map(|a| high[a] - low[a]);
    let axis = (0..3).fold(0, |best, a| if size[a] > size[best] { a } else { best });
    let limit = low[axis] * 0.5 + high[axis] * 0.5;
    let rule = Rule::Below { axis, base: 0.0, scale: 1.0, limit };
    let left_count = references.iter().filter(|r| r.center2_on(axis) < limit).count();
    (left_count > 0 && left_count < references.len()).then_some(Split {
        rule,
        left_count,
        cost: f32::INFINITY,
    })
}
