//! Two children out of one set of references.

use super::lanes::Box4;
use super::reference::{CHUNK, Extent, Reference};
use rayon::prelude::*;

/// Which references go left, and how many these are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    pub(super) rule: Rule,
    pub(super) left_count: usize,
    /// Cost of both sides: half area times tests. Not known of every rule.
    pub(super) cost: f32,
}

/// Most references that [`Rule::Ranks`] parts.
pub(super) const MOST_RANKED: usize = 8;

#[derive(Clone, Copy, Debug)]
pub(super) enum Rule {
    /// Left is where (twice the centre − base) × scale is below the limit.
    Below { axis: usize, base: f32, scale: f32, limit: f32 },
    /// Left is where (twice the centre, number) comes no later than this.
    UpTo { axis: usize, center2: f32, index: u32 },
    /// By the reference's place in order: left are those of rank below `left_count`.
    Ranks([u8; MOST_RANKED]),
    /// The first ones, as they stand.
    First,
    /// Triangles left, spheres right.
    Triangles { count: u32 },
}

impl Split {
    /// Any halves.
    pub(super) fn halves(count: usize) -> Split {
        Split { rule: Rule::First, left_count: count / 2, cost: f32::INFINITY }
    }

    /// Moves references from `from` to `to`, the left ones first, and otherwise in their order. Returns what is known
    /// about the two sets.
    #[inline(always)]
    pub(super) fn apply(&self, from: &[Reference], to: &mut [Reference]) -> [Extent; 2] {
        let left_count = self.left_count;
        match self.rule {
            Rule::Below { axis, base, scale, limit } => {
                distribute(from, to, left_count, |_, r| (r.center2_on(axis) - base) * scale < limit)
            }
            Rule::UpTo { axis, center2, index } => distribute(from, to, left_count, |_, r| {
                let c = r.center2_on(axis);
                (c < center2) | ((c == center2) & (r.index() <= index))
            }),
            Rule::Ranks(ranks) => {
                distribute(from, to, left_count, |k, _| usize::from(ranks[k % MOST_RANKED]) < left_count)
            }
            Rule::First => distribute(from, to, left_count, |k, _| k < left_count),
            Rule::Triangles { count } => distribute(from, to, left_count, |_, r| r.index() < count),
        }
    }
}

#[inline(always)]
fn distribute(
    from: &[Reference],
    to: &mut [Reference],
    left_count: usize,
    goes_left: impl Fn(usize, &Reference) -> bool + Sync,
) -> [Extent; 2] {
    let (left, right) = to.split_at_mut(left_count);
    if from.len() <= 4 * CHUNK {
        return move_chunk(from, 0, left, right, goes_left);
    }
    // Each chunk's share of both sides is counted first.
    let counts: Vec<usize> = from
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(c, chunk)| (c * CHUNK..).zip(chunk).filter(|(k, r)| goes_left(*k, r)).count())
        .collect();
    let (mut left, mut right) = (left, right);
    let mut places = Vec::with_capacity(counts.len());
    for (chunk, left_share) in from.chunks(CHUNK).zip(counts) {
        let (l, rest) = left.split_at_mut(left_share);
        left = rest;
        let (r, rest) = right.split_at_mut(chunk.len() - left_share);
        right = rest;
        places.push((chunk, l, r));
    }
    let extents: Vec<[Extent; 2]> = places
        .into_par_iter()
        .enumerate()
        .map(|(c, (chunk, left, right))| move_chunk(chunk, c * CHUNK, left, right, &goes_left))
        .collect();
    extents.into_iter().fold([Extent::empty(); 2], |[l, r], [el, er]| [l.union(el), r.union(er)])
}

/// The sides have exactly the room that is needed.
#[inline(always)]
fn move_chunk(
    from: &[Reference],
    first: usize,
    left: &mut [Reference],
    right: &mut [Reference],
    goes_left: impl Fn(usize, &Reference) -> bool,
) -> [Extent; 2] {
    let mut extents = [Extent::empty(); 2];
    let sides = [left, right];
    let mut filled = [0usize; 2];
    let [l, r] = &mut extents;
    for (k, reference) in (first..).zip(from) {
        // No branches: which side it is cannot be foreseen.
        let is_left = goes_left(k, reference);
        let side = usize::from(!is_left);
        sides[side][filled[side]] = *reference;
        filled[side] += 1;
        let (b, c) = (reference.box4(), reference.center2());
        let take = |e: &mut Box4, low: super::lanes::Lanes, high: super::lanes::Lanes, not: bool| {
            e.low = low.nan_if(not).min(e.low);
            e.high = high.nan_if(not).max(e.high);
        };
        take(&mut l.bounds, b.low, b.high, !is_left);
        take(&mut r.bounds, b.low, b.high, is_left);
        take(&mut l.centers2, c, c, !is_left);
        take(&mut r.centers2, c, c, is_left);
    }
    extents
}
