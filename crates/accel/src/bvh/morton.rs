//! Sorted along a Morton curve (Lauterbach et al. 2009): split where the highest bit of the code changes, boxes from
//! the leaves up.

use super::lanes::{Box4, Lanes};
use super::policy::{Fit, Policy};
use super::reference::{CHUNK, Extent, Reference};
use super::tree::{PIECE_ITEMS, Piece, Tree};
use super::{AHEAD, filled, prefetch};
use rayon::prelude::*;
use std::ops::Range;

/// Bits of a code on each axis; three times this in all.
const AXIS_BITS: u32 = 10;

/// Sets of at most so many are split so that blocks of four are full: a sixth less memory and a tenth less time, for
/// 4 % more cost.
const FEW: usize = 16;

/// Code and place of a reference: ordered by code, and then as they were.
type Key = u64;

/// Builds over references.
pub(super) fn build(references: &[Reference], extent: &Extent, policy: &Policy) -> Piece {
    let mut keys = codes(references, &extent.centers2);
    sort(&mut keys);
    Morton { references, keys: &keys, policy }.build(0..keys.len(), 0).0
}

/// Spreads ten bits three places apart.
#[inline(always)]
fn spread(x: u32) -> u32 {
    let x = (x | (x << 16)) & 0x0300_00ff;
    let x = (x | (x << 8)) & 0x0300_f00f;
    let x = (x | (x << 4)) & 0x030c_30c3;
    (x | (x << 2)) & 0x0924_9249
}

fn codes(references: &[Reference], centers2: &Box4) -> Vec<Key> {
    let size = centers2.high.minus(centers2.low).array();
    let cells = (1 << AXIS_BITS) as f32;
    let scale = |e: f32| if e > 1e-30 { cells * 0.99999 / e } else { 0.0 };
    let (base, scale) =
        (centers2.low.xyz0(), Lanes::new(scale(size[0]), scale(size[1]), scale(size[2]), 0.0));
    let last = Lanes::splat(cells - 1.0);
    let mut keys = filled(0, references.len());
    keys.par_chunks_mut(CHUNK).zip(references.par_chunks(CHUNK)).enumerate().for_each(
        |(chunk, (keys, references))| {
            for ((key, r), at) in keys.iter_mut().zip(references).zip((chunk * CHUNK) as u64..) {
                let cell = r.center2().minus(base).times(scale).min(last).max(Lanes::splat(0.0)).whole();
                let code = spread(cell[0]) << 2 | spread(cell[1]) << 1 | spread(cell[2]);
                *key = u64::from(code) << 32 | at;
            }
        },
    );
    keys
}

/// Bits that are sorted at once.
const DIGIT: u32 = 10;

/// At most so many keys are sorted by one thread, all digits over all of them: two such arrays lie in its cache.
const FEW_KEYS: usize = 1 << 17;

/// Radix sort, by the highest digit for all and then each of those groups by the two others, lowest first.
fn sort(keys: &mut Vec<Key>) {
    let mut other = filled(0, keys.len());
    let mut starts = [0u32; DIGITS + 1];
    if keys.len() <= FEW_KEYS {
        for digit in 0..3 {
            scatter(keys, &mut other, 32 + digit * DIGIT, &mut starts);
            std::mem::swap(keys, &mut other);
        }
        return;
    }
    scatter(keys, &mut other, 32 + 2 * DIGIT, &mut starts);
    let (mut rest, mut room) = (&mut other[..], &mut keys[..]);
    let mut groups = Vec::new();
    for pair in starts.windows(2).filter(|p| p[1] > p[0]) {
        let size = (pair[1] - pair[0]) as usize;
        let (group, others) = rest.split_at_mut(size);
        let (group_room, other_room) = room.split_at_mut(size);
        (rest, room) = (others, other_room);
        groups.push((group, group_room));
    }
    groups.into_par_iter().for_each(|(group, room)| {
        if group.len() < 256 {
            group.sort_unstable();
        } else {
            let mut starts = [0u32; DIGITS + 1];
            scatter(group, room, 32, &mut starts);
            scatter(room, group, 32 + DIGIT, &mut starts);
        }
    });
    std::mem::swap(keys, &mut other);
}

const DIGITS: usize = 1 << DIGIT;

/// Sorts by one digit, keeping the order of equal ones; tells where each digit's keys start, and the end.
fn scatter(from: &[Key], to: &mut [Key], shift: u32, starts: &mut [u32; DIGITS + 1]) {
    starts.fill(0);
    let digit = |key: Key| (key >> shift) as usize % DIGITS;
    for key in from {
        starts[digit(*key) + 1] += 1;
    }
    for d in 0..DIGITS {
        starts[d + 1] += starts[d];
    }
    let mut next = [0u32; DIGITS];
    next.copy_from_slice(&starts[..DIGITS]);
    for key in from {
        let place = &mut next[digit(*key)];
        to[*place as usize] = *key;
        *place += 1;
    }
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
        (Piece::Split(bounds.bounds(0.0), Box::new([left, right])), bounds)
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

    /// Where to split. Few references are split so that blocks are full, as near to where the code changes as that
    /// allows.
    #[inline(always)]
    fn split(&self, keys: &[Key]) -> usize {
        let place = split(keys);
        if !self.policy.always_leaf || keys.len() > FEW {
            return place;
        }
        let block = self.policy.max_leaf[0] as usize;
        let whole = (place + block / 2) / block * block;
        whole.clamp(block, (keys.len() - 1) / block * block)
    }

    #[inline(always)]
    fn at(&self, key: Key) -> Reference {
        self.references[key as u32 as usize]
    }
}

/// Where the highest bit changes that differs among the codes; the middle where none does.
#[inline(always)]
fn split(keys: &[Key]) -> usize {
    let (first, last) = ((keys[0] >> 32) as u32, (keys[keys.len() - 1] >> 32) as u32);
    if first == last {
        return keys.len() / 2;
    }
    let bit = 31 - (first ^ last).leading_zeros();
    // All codes share the bits above: those with the bit set come last.
    let limit = u64::from(last >> bit << bit) << 32;
    if keys.len() <= FEW {
        // Counting needs no branches.
        return keys.iter().map(|k| usize::from(*k < limit)).sum();
    }
    keys.partition_point(|k| *k < limit)
}
