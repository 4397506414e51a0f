//! The shape of a tree over triangles alone, by Morton codes, before there are boxes: for the 8-wide hierarchy, which
//! packs blocks and finds their boxes while it has the triangles at hand.

use super::codes::{self, Key};
use super::lanes::{Box4, Lanes};
use super::reference::{CHUNK, triangle_box};
use super::tree::{PIECE_ITEMS, Piece, Tree};
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::BvhNode;
use eosphor_core::math::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// Most triangles of a leaf.
const BLOCK: usize = 4;

/// Of a tree's nodes, what is below them but not where: leaves name ranges of the keys.
pub(crate) struct Shape {
    /// Numbers of triangles in their lower halves, in the order of the leaves.
    pub(crate) keys: Vec<Key>,
    pub(crate) piece: Piece,
}

impl Shape {
    /// Over at least one triangle.
    pub(crate) fn new(triangles: &[[Vec3; 3]]) -> Shape {
        // Of corners within 10^12; of any others it is some number, or NaN, and the tree is not a good one.
        let center2 = |triangle: &[Vec3; 3]| {
            let [a, b, c] = Lanes::corners(triangle);
            a.min(b).min(c).plus(a.max(b).max(c))
        };
        let around = |chunk: &[[Vec3; 3]]| {
            chunk.iter().fold(Box4::empty(), |b, triangle| b.including(center2(triangle)))
        };
        let chunks: Vec<Box4> = triangles.par_chunks(CHUNK).map(around).collect();
        let centers2 = chunks.into_iter().fold(Box4::empty(), Box4::union);
        let keys = codes::sorted(triangles.len(), &centers2, |at| center2(&triangles[at]));
        let piece = build(&keys, 0..keys.len());
        Shape { keys, piece }
    }
}

fn build(keys: &[Key], range: Range<usize>) -> Piece {
    if range.len() <= PIECE_ITEMS {
        let mut tree = Tree::with_leaves(range.len() / 3);
        build_piece(keys, range, &mut tree, 0);
        return Piece::Whole(tree);
    }
    let middle = range.start + codes::split_for_blocks(&keys[range.clone()], BLOCK);
    let (left, right) = rayon::join(|| build(keys, range.start..middle), || build(keys, middle..range.end));
    Piece::Split(Bounds::EMPTY, Box::new([left, right]))
}

#[inline(always)]
fn build_piece(keys: &[Key], range: Range<usize>, tree: &mut Tree, at: usize) {
    if range.len() <= BLOCK {
        (tree.nodes[at].first, tree.nodes[at].count) = (range.start as u32, range.len() as u32);
    } else {
        build_inner(keys, range, tree, at);
    }
}

/// Codes end the recursion after 30 levels, halving of equal ones after at most 29 more.
fn build_inner(keys: &[Key], range: Range<usize>, tree: &mut Tree, at: usize) {
    let middle = range.start + codes::split_for_blocks(&keys[range.clone()], BLOCK);
    let pair = tree.nodes.len();
    (tree.nodes[at].first, tree.nodes[at].count) = (pair as u32, 0);
    tree.nodes.extend([BvhNode::EMPTY; 2]);
    build_piece(keys, range.start..middle, tree, pair);
    build_piece(keys, middle..range.end, tree, pair + 1);
}

/// The box around triangles, finite whatever their coordinates.
#[cold]
pub(crate) fn finite_box<'a>(triangles: impl Iterator<Item = &'a [Vec3; 3]>) -> Bounds {
    triangles.map(triangle_box).fold(Box4::empty(), Box4::union).bounds()
}

impl Piece {
    /// Its parts, from left to right.
    pub(crate) fn wholes(&mut self) -> Vec<&mut Tree> {
        match self {
            Piece::Whole(tree) => vec![tree],
            Piece::Split(_, pieces) => pieces.iter_mut().flat_map(Piece::wholes).collect(),
        }
    }

    /// Finds the boxes above the parts, whose own are known; returns its own.
    pub(crate) fn find_bounds(&mut self) -> Bounds {
        match self {
            Piece::Whole(tree) => Bounds { min: tree.nodes[0].min, max: tree.nodes[0].max },
            Piece::Split(bounds, pieces) => {
                let [left, right] = &mut **pieces;
                *bounds = left.find_bounds().union(&right.find_bounds());
                *bounds
            }
        }
    }
}
