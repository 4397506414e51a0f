//! Spatial splits: where the boxes of two sets of primitives overlap, primitives are cut instead (Stich et al. 2009).

use super::binned::{self, Bins};
use super::clip;
use super::cuts::{Cut, Cutter, SliceBins};
use super::lanes::Box4;
use super::memory::filled;
use super::policy::{Fit, Policy};
use super::reference::{Extent, Reference};
use super::split::{MOST_RANKED, Split};
use super::tree::{PIECE_ITEMS, Piece, Tree};
use eosphor_core::math::Vec3;
use std::ops::Range;

/// Cuts are tried where the two sides of the best split without cuts overlap in more than this share of the root's
/// area. (Stich et al. take 1e-5; ten times that changes the costs of bunny and sponza by less than 0.1 % and saves a
/// fourth of the time.)
const LEAST_OVERLAP: f32 = 1e-4;

/// The same, as a share of the node's own area.
const LEAST_SHARE: f32 = 0.05;

/// A cut must be better than the best split without by this factor, since it costs memory.
const WORTH: f32 = 0.99;

/// Room for references, as a multiple of the primitives.
const BUDGET: f64 = 1.3;

pub(super) struct Spatial<'a> {
    policy: &'a Policy,
    triangles: &'a [[Vec3; 3]],
    root_area: f32,
}

/// Scratch memory of a thread.
struct Scratch {
    bins: Bins,
    slices: SliceBins,
}

/// References in the middle of room for more.
struct Room<'a> {
    from: &'a mut [Reference],
    used: Range<usize>,
    /// Where a split moves the references to. As large as `from`.
    to: &'a mut [Reference],
}

/// Room that building over so many primitives takes.
pub(super) fn room(primitives: usize) -> usize {
    (primitives as f64 * BUDGET) as usize
}

/// Builds over references to triangles, and maybe other primitives after them, which are not cut.
pub(super) fn build(
    references: Vec<Reference>,
    extent: &Extent,
    policy: &Policy,
    triangles: &[[Vec3; 3]],
) -> Piece {
    let spatial = Spatial { policy, triangles, root_area: extent.bounds.half_area() };
    let used = references.len();
    let room = room(used);
    let mut from = references;
    from.resize(room, Reference::NONE);
    let mut to = filled(Reference::NONE, room);
    spatial.build(Room { from: &mut from, used: 0..used, to: &mut to }, extent, 0)
}

enum Choice {
    Leaf { spheres: bool },
    Split(Split),
    Cut(Cut),
}

impl Spatial<'_> {
    fn build(&self, room: Room, extent: &Extent, depth: usize) -> Piece {
        let mut scratch = Scratch::new();
        if room.used.len() <= PIECE_ITEMS {
            let mut tree = Tree::with_root(room.from.len());
            self.build_piece(room, extent, depth, &mut tree, 0, &mut scratch);
            return Piece::Whole(tree);
        }
        let choice = self.choose(&room, extent, depth, &mut scratch);
        if let Choice::Leaf { spheres } = choice {
            let mut tree = Tree::with_root(room.used.len());
            tree.set_leaf(0, extent.bounds, &room.from[room.used.clone()], spheres);
            return Piece::Whole(tree);
        }
        let bounds = extent.bounds.bounds();
        let [(left, l), (right, r)] = self.apply(room, &choice);
        let (left, right) =
            rayon::join(|| self.build(left, &l, depth + 1), || self.build(right, &r, depth + 1));
        Piece::Split(bounds, Box::new([left, right]))
    }

    fn build_piece(
        &self,
        room: Room,
        extent: &Extent,
        depth: usize,
        tree: &mut Tree,
        at: usize,
        scratch: &mut Scratch,
    ) {
        let choice = self.choose(&room, extent, depth, scratch);
        if let Choice::Leaf { spheres } = choice {
            let used = Reference::without_doubles(&mut room.from[room.used]);
            tree.set_leaf(at, extent.bounds, used, spheres);
            return;
        }
        let pair = tree.set_inner(at, extent.bounds);
        let [(left, l), (right, r)] = self.apply(room, &choice);
        self.build_piece(left, &l, depth + 1, tree, pair, scratch);
        self.build_piece(right, &r, depth + 1, tree, pair + 1, scratch);
    }

    fn choose(&self, room: &Room, extent: &Extent, depth: usize, scratch: &mut Scratch) -> Choice {
        let references = &room.from[room.used.clone()];
        let count = references.len();
        let area = extent.bounds.half_area();
        let policy = &self.policy.of_set(count, area);
        let fit = policy.fit(references, depth);
        if let Fit::Leaf { spheres } = fit
            && policy.is_leaf(count, depth, area)
        {
            return Choice::Leaf { spheres };
        }
        if fit == Fit::Mixed && policy.must_stop(depth) {
            return Choice::Split(Split::by_kind(references, policy));
        }
        if policy.must_halve(count, depth) && fit == Fit::TooMany {
            return Choice::Split(Split::halves(count));
        }
        let few = count <= MOST_RANKED;
        let split = if few {
            binned::best_of_few(references, policy)
        } else {
            binned::best_split(references, extent, policy, &mut scratch.bins)
        };
        let mut cost = split.map_or(f32::INFINITY, |s| s.cost);
        let spare = room.from.len() - count;
        let mut cut = None;
        if spare > 0 && !few && split.is_none_or(|s| self.overlaps(&s, &scratch.bins)) {
            let cutter = Cutter { policy, triangles: self.triangles };
            cut =
                cutter.best(references, extent, spare, &mut scratch.slices).filter(|c| c.cost < cost * WORTH);
            cost = cut.map_or(cost, |c| c.cost);
        }
        if fit != Fit::TooMany && policy.traversal_cost * area + cost >= area * policy.tests(count as u32) {
            return match fit {
                Fit::Leaf { spheres } => Choice::Leaf { spheres },
                _ => Choice::Split(Split::by_kind(references, policy)),
            };
        }
        match (cut, split) {
            (Some(cut), _) => Choice::Cut(cut),
            (None, Some(split)) => Choice::Split(split),
            (None, None) => Choice::Split(Split::halves(count)),
        }
    }

    /// Whether the two sides of a split between bins share enough.
    fn overlaps(&self, split: &Split, bins: &Bins) -> bool {
        let [left, right] = bins.sides(split);
        let area = left.intersection(right).half_area_or_zero();
        area > self.root_area * LEAST_OVERLAP && area > left.union(right).half_area() * LEAST_SHARE
    }

    /// Moves references to `to`: left ones to its front, right ones to its end. Spare room goes to both sides by their
    /// numbers.
    fn apply<'r>(&self, room: Room<'r>, choice: &Choice) -> [(Room<'r>, Extent); 2] {
        let Room { from, used, to } = room;
        let size = from.len();
        let (extents, left, right);
        match choice {
            Choice::Cut(cut) => {
                (extents, left, right) = self.apply_cut(&from[used], to, cut);
            }
            Choice::Split(split) => {
                let count = used.len();
                left = split.left_count;
                right = count - left;
                let (front, rest) = to.split_at_mut(left);
                let back = &mut rest[size - count..];
                extents = split.apply(&from[used], front, back);
            }
            Choice::Leaf { .. } => unreachable!("leaves are not split"),
        }
        let spare = size - left - right;
        let left_room = left + (spare as u64 * left as u64 / (left + right) as u64) as usize;
        let (left_from, right_from) = to.split_at_mut(left_room);
        let (left_to, right_to) = from.split_at_mut(left_room);
        let right_used = right_from.len() - right..right_from.len();
        let [l, r] = extents;
        [
            (Room { from: left_from, used: 0..left, to: left_to }, l),
            (Room { from: right_from, used: right_used, to: right_to }, r),
        ]
    }

    fn apply_cut(&self, from: &[Reference], to: &mut [Reference], cut: &Cut) -> ([Extent; 2], usize, usize) {
        let s = &cut.slices;
        let (limit, plane) = (cut.plane as f32, s.plane(cut.plane));
        let mut extents = [Extent::empty(); 2];
        let (mut left, mut right) = (0, to.len());
        let mut put = |side: usize, reference: Reference| {
            extents[side].add(&reference);
            if side == 0 {
                to[left] = reference;
                left += 1;
            } else {
                right -= 1;
                to[right] = reference;
            }
        };
        for r in from {
            let margin = clip::margin_of(r, self.triangles);
            let low = (r.low_on(s.axis) + margin - s.base) * s.scale;
            let high = (r.high_on(s.axis) - margin - s.base) * s.scale;
            if high < limit {
                put(0, *r);
            } else if low >= limit {
                put(1, *r);
            } else {
                let parts = match self.triangles.get(r.index() as usize) {
                    Some(triangle) => clip::cut(triangle, r, s.axis, plane),
                    None => [r.box4(); 2],
                };
                match self.side(r, &parts, cut) {
                    Some(side) => put(side, *r),
                    None => {
                        for (side, part) in parts.into_iter().enumerate() {
                            put(side, Reference::with_box(part, r.index()));
                        }
                    }
                }
            }
        }
        let right_count = to.len() - right;
        (extents, left, right_count)
    }

    /// The side that takes a reference whole, where that is cheaper than cutting it (Stich et al., section 4.4).
    fn side(&self, r: &Reference, parts: &[Box4; 2], cut: &Cut) -> Option<usize> {
        if !parts[0].holds_something() {
            return Some(1);
        }
        if !parts[1].holds_something() {
            return Some(0);
        }
        let [l, r_side] = cut.sides;
        let [n, m] = cut.counts.map(|c| c as f32);
        let (area_l, area_r) = (l.half_area(), r_side.half_area());
        let both = area_l * n + area_r * m;
        let only_left = l.union(r.box4()).half_area() * n + area_r * (m - 1.0);
        let only_right = area_l * (n - 1.0) + r_side.union(r.box4()).half_area() * m;
        if only_left < both && only_left <= only_right {
            Some(0)
        } else if only_right < both {
            Some(1)
        } else {
            None
        }
    }
}

impl Scratch {
    fn new() -> Scratch {
        Scratch { bins: Bins::empty(), slices: SliceBins::empty() }
    }
}
