//! Sorted along a Morton curve (Lauterbach et al. 2009): split where the highest bit of the code changes, boxes from
//! the leaves up.

use super::lanes::{Box4, Lanes};
use super::policy::{Fit, Policy};
use super::reference::{CHUNK, Extent, Reference};
use super::tree::{PIECE_ITEMS, Piece, Tree};
use rayon::prelude::*;

/// Bits of a code on each axis; three times this in all.
const AXIS_BITS: u32 = 10;

/// Code and place of a reference: ordered by code, and then as they were.
type Key = u64;

/// Builds over references.
pub(super) fn build(references: &[Reference], extent: &Extent, policy: &Policy) -> Piece {
    let mut keys = codes(references, &extent.centers2);
    sort(&mut keys);
    Morton { references, policy }.build(&keys, 0).0
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
    let mut keys = vec![0; references.len()];
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

/// Radix sort: by the highest digit for all, then each of those groups by the two others, lowest first.
fn sort(keys: &mut Vec<Key>) {
    let mut other = vec![0; keys.len()];
    let starts = scatter(keys, &mut other, 32 + 2 * DIGIT);
    let (mut rest, mut room) = (&mut other[..], &mut keys[..]);
    let mut groups = Vec::new();
    for pair in starts.windows(2).filter(|p| p[1] > p[0]) {
        let (group, others) = rest.split_at_mut(pair[1] - pair[0]);
        let (group_room, other_room) = room.split_at_mut(pair[1] - pair[0]);
        (rest, room) = (others, other_room);
        groups.push((group, group_room));
    }
    groups.into_par_iter().for_each(|(group, room)| {
        if group.len() < 256 {
            group.sort_unstable();
            room.copy_from_slice(group);
        } else {
            scatter(group, room, 32);
            scatter(room, group, 32 + DIGIT);
            room.copy_from_slice(group);
        }
    });
}

/// Sorts by one digit, keeping the order of equal ones; returns where each digit's keys start, and the end.
fn scatter(from: &[Key], to: &mut [Key], shift: u32) -> Vec<usize> {
    const DIGITS: usize = 1 << DIGIT;
    let mut starts = vec![0usize; DIGITS + 1];
    let digit = |key: Key| (key >> shift) as usize % DIGITS;
    for key in from {
        starts[digit(*key) + 1] += 1;
    }
    for d in 0..DIGITS {
        starts[d + 1] += starts[d];
    }
    let mut next = [0usize; DIGITS];
    next.copy_from_slice(&starts[..DIGITS]);
    for key in from {
        let place = &mut next[digit(*key)];
        to[*place] = *key;
        *place += 1;
    }
    starts
}

struct Morton<'a> {
    references: &'a [Reference],
    policy: &'a Policy,
}

impl Morton<'_> {
    fn build(&self, keys: &[Key], depth: usize) -> (Piece, Box4) {
        if keys.len() <= PIECE_ITEMS {
            let mut tree = Tree::with_root(keys.len());
            let bounds = self.build_piece(keys, depth, &mut tree, 0);
            return (Piece::Whole(tree), bounds);
        }
        let (left, right) = keys.split_at(split(keys));
        let ((left, a), (right, b)) =
            rayon::join(|| self.build(left, depth + 1), || self.build(right, depth + 1));
        let bounds = a.union(b);
        (Piece::Split(bounds.bounds(0.0), Box::new([left, right])), bounds)
    }

    /// Codes end the recursion after 30 levels, halving of equal ones after at most 29 more.
    fn build_piece(&self, keys: &[Key], depth: usize, tree: &mut Tree, at: usize) -> Box4 {
        let count = keys.len();
        let most = self.policy.max_leaf[0].max(self.policy.max_leaf[1]) as usize;
        let mut parted = None;
        if count <= most || self.policy.must_stop(depth) {
            let leaf: Vec<Reference>;
            let mut few = [Reference::NONE; 4];
            let references = if count <= 4 {
                for (place, key) in few.iter_mut().zip(keys) {
                    *place = self.at(*key);
                }
                &few[..count]
            } else {
                leaf = keys.iter().map(|k| self.at(*k)).collect();
                &leaf[..]
            };
            match self.policy.fit(references, depth) {
                Fit::Leaf { spheres } => {
                    let bounds = references.iter().fold(Box4::empty(), |b, r| b.union(r.box4()));
                    tree.set_leaf(at, bounds, references, spheres);
                    return bounds;
                }
                Fit::Mixed => {
                    let (triangles, spheres): (Vec<Key>, Vec<Key>) =
                        keys.iter().partition(|k| self.at(**k).index() < self.policy.triangle_count);
                    parted = Some((triangles, spheres));
                }
                Fit::TooMany => {}
            }
        }
        let pair = tree.set_inner(at, Box4::empty());
        let (left, right) = match &parted {
            Some((triangles, spheres)) => (&triangles[..], &spheres[..]),
            None => keys.split_at(split(keys)),
        };
        let a = self.build_piece(left, depth + 1, tree, pair);
        let b = self.build_piece(right, depth + 1, tree, pair + 1);
        let bounds = a.union(b);
        tree.set_bounds(at, bounds);
        bounds
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
    if keys.len() <= 16 {
        return keys.iter().map(|k| usize::from(*k < limit)).sum();
    }
    keys.partition_point(|k| *k < limit)
}
