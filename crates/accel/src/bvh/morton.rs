//! Sorted along a Morton curve (Lauterbach et al. 2009): split where the highest bit of the code changes, boxes from
//! the leaves up.

use super::codes::{self, Key};
use super::lanes::Box4;
use super::policy::{Fit, Policy};
use super::reference::{Extent, Reference};
use super::tree::{PIECE_ITEMS, Piece, Tree};
use super::{AHEAD, prefetch};
use std::ops::Range;

/// Builds over references.
pub(super) fn build(references: &[Reference], extent: &Extent, policy: &Policy) -> Piece {
    let keys = codes::sorted(references.len(), &extent.centers2, |at| references[at].center2());
    Morton { references, keys: &keys, policy }.build(0..keys.len(), 0).0
}

struct Morton<'a> {
    references: &'a [Reference],
    keys: &'a [Key],
    policy: &'a Policy,
}

impl Morton<'_> {
    fn build(&self, range: Range<usize>, depth: usize) -> (Piece, Box4) {
        if range.len() <= PIECE_ITEMS {
            let mut tree = Tree::with_root(range.len());
            let bounds = self.build_piece(range, depth, &mut tree, 0);
            return (Piece::Whole(tree), bounds);
        }
        let middle = range.start + self.split(&self.keys[range.clone()]);
        let ((left, a), (right, b)) = rayon::join(
            || self.build(range.start..middle, depth + 1),
            || self.build(middle..range.end, depth + 1),
        );
        let bounds = a.union(b);
        (Piece::Split(bounds.bounds(), Box::new([left, right])), bounds)
    }

    /// Codes end the recursion after 30 levels, halving of equal ones after at most 29 more.
    fn build_piece(&self, range: Range<usize>, depth: usize, tree: &mut Tree, at: usize) -> Box4 {
        let most = self.policy.max_leaf[0].max(self.policy.max_leaf[1]) as usize;
        if range.len() <= most || self.policy.must_stop(depth) {
            return self.build_leaves(&self.keys[range.clone()], range.end, depth, tree, at);
        }
        let pair = tree.set_inner(at, Box4::empty());
        let middle = range.start + self.split(&self.keys[range.clone()]);
        let a = self.build_piece(range.start..middle, depth + 1, tree, pair);
        let b = self.build_piece(middle..range.end, depth + 1, tree, pair + 1);
        let bounds = a.union(b);
        tree.set_bounds(at, bounds);
        bounds
    }

    /// A leaf of few references, or several where these are of both kinds, or kinds with smaller leaves. `end` is where
    /// the next leaf begins.
    #[inline(always)]
    fn build_leaves(&self, keys: &[Key], end: usize, depth: usize, tree: &mut Tree, at: usize) -> Box4 {
        for next in self.keys.iter().skip(end + AHEAD).take(keys.len()) {
            prefetch(self.references, *next as u32 as usize);
        }
        if keys.len() <= 4 {
            let mut few = [Reference::NONE; 4];
            for (place, key) in few.iter_mut().zip(keys) {
                *place = self.at(*key);
            }
            return self.build_few(&mut few[..keys.len()], depth, tree, at);
        }
        let mut many: Vec<Reference> = keys.iter().map(|k| self.at(*k)).collect();
        self.build_few(&mut many, depth, tree, at)
    }

    fn build_few(&self, references: &mut [Reference], depth: usize, tree: &mut Tree, at: usize) -> Box4 {
        let fit = self.policy.fit(references, depth);
        if let Fit::Leaf { spheres } = fit {
            let bounds = references.iter().fold(Box4::empty(), |b, r| b.union(r.box4()));
            let held =
                if self.policy.has_parts { Reference::without_doubles(references) } else { references };
            tree.set_leaf(at, bounds, held, spheres);
            return bounds;
        }
        let (mut left, mut right): (Vec<Reference>, Vec<Reference>) = if fit == Fit::Mixed {
            references.iter().partition(|r| r.index() < self.policy.triangle_count)
        } else {
            let (left, right) = references.split_at(references.len() / 2);
            (left.to_vec(), right.to_vec())
        };
        let pair = tree.set_inner(at, Box4::empty());
        let a = self.build_few(&mut left, depth + 1, tree, pair);
        let b = self.build_few(&mut right, depth + 1, tree, pair + 1);
        let bounds = a.union(b);
        tree.set_bounds(at, bounds);
        bounds
    }

    #[inline(always)]
    fn split(&self, keys: &[Key]) -> usize {
        if self.policy.always_leaf {
            codes::split_for_blocks(keys, self.policy.max_leaf[0] as usize)
        } else {
            codes::split(keys)
        }
    }

    #[inline(always)]
    fn at(&self, key: Key) -> Reference {
        self.references[key as u32 as usize]
    }
}
