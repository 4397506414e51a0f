//! Cutting the few triangles that are large beside the whole before anything else is done ("early split clipping", Ernst
//! and Greiner 2007; planes as in Karras and Aila 2013, "Fast parallel construction of high-quality bounding volume
//! hierarchies").
//!
//! A wall or a floor of two triangles makes the box of every node above it as large as itself. Rays in a building enter
//! these boxes everywhere, which the surface area heuristic does not see: it has rays end nowhere.

use super::clip;
use super::lanes::Box4;
use super::reference::{Extent, Reference};
use eosphor_core::math::Vec3;
use std::ops::Range;

/// Boxes with more than this share of the area of the whole are cut.
pub(super) const LARGE: f32 = 0.004;

/// For so many triangles cutting may add one reference.
const BUDGET: usize = 16;

/// A triangle is not cut where its box is hardly larger than boxes of its parts can be together, nor where it lies in the plane of
/// two axes (2.0): a wall whose box is flat ends rays high up in the tree. (With such walls in parts, a colonnade's rays are up to
/// 1.3 times as fast, and those of a conference room 0.8 times.)
const WASTE: f32 = 2.1;

/// Most parts of a triangle.
const MOST_PARTS: usize = 64;

/// Room for references that cutting takes.
pub(super) fn room(triangles: usize) -> usize {
    triangles + triangles / BUDGET
}

/// Cuts references to triangles, of which only those in `ranges` can be large; parts are put at the end. Whether there
/// are any.
pub(super) fn cut_large(
    references: &mut Vec<Reference>,
    extent: &mut Extent,
    ranges: &[Range<usize>],
    triangles: &[[Vec3; 3]],
) -> bool {
    let root = extent.bounds.half_area();
    if !(root > 0.0 && root < f32::MAX) {
        return false;
    }
    let mut limit = (root * LARGE).max(f32::MIN_POSITIVE);
    let mut large: Vec<(usize, f32)> = Vec::new();
    for range in ranges {
        for at in range.clone() {
            let area = references[at].box4().half_area();
            if area > limit && area > WASTE * least_area(&triangles[at]) {
                large.push((at, area));
            }
        }
    }
    // No more parts than there is room for: where very many are large, none are.
    let budget = triangles.len() / BUDGET;
    while !large.is_empty()
        && large.iter().fold(0usize, |sum, (_, area)| sum.saturating_add((area / limit) as usize)) > budget
    {
        limit *= 2.0;
        large.retain(|(_, area)| *area > limit);
    }
    let grid = Grid { whole: extent.bounds };
    let (before, most) = (references.len(), references.len() + budget);
    let (mut pending, mut parts) = (Vec::new(), Vec::new());
    for (at, _) in large {
        let triangle = &triangles[at];
        let margin = clip::part_margin(triangle);
        pending.push(references[at]);
        while let Some(r) = pending.pop() {
            let room = parts.len() + pending.len() + 1 < MOST_PARTS.min(most - references.len() + 1);
            let b = r.box4();
            match grid.plane(&b, margin).filter(|_| room && b.half_area() > limit) {
                None => parts.push(r),
                Some((axis, plane)) => {
                    let sides = clip::cut(triangle, &r, axis, plane);
                    if sides.iter().all(Box4::holds_something) {
                        pending.extend(sides.map(|side| Reference::with_box(side, r.index())));
                    } else {
                        parts.push(r);
                    }
                }
            }
        }
        parts.iter().for_each(|part| extent.centers2 = extent.centers2.including(part.center2()));
        references[at] = parts[0];
        references.extend(parts.drain(..).skip(1));
    }
    references.len() > before
}

/// What the areas of the boxes of the smallest parts add up to.
fn least_area(triangle: &[Vec3; 3]) -> f32 {
    let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).abs();
    0.5 * (normal.x + normal.y + normal.z)
}

/// The whole, halved again and again.
struct Grid {
    whole: Box4,
}

impl Grid {
    /// The plane that cuts a box, of those that stand farthest apart: so neighbours are cut at the same ones.
    fn plane(&self, b: &Box4, margin: f32) -> Option<(usize, f32)> {
        const CELLS: f32 = 65536.0;
        let (low, high) = (b.low.array(), b.high.array());
        let (base, end) = (self.whole.low.array(), self.whole.high.array());
        let mut best: Option<(f32, usize, f32)> = None;
        for axis in 0..3 {
            let cell = (end[axis] - base[axis]) / CELLS;
            if high[axis] - low[axis] <= 8.0 * margin {
                continue;
            }
            let number = |x: f32| ((x - base[axis]) / cell).clamp(0.0, CELLS - 1.0) as u32;
            let (first, last) = (number(low[axis] + 2.0 * margin), number(high[axis] - 2.0 * margin));
            if first >= last {
                continue;
            }
            let bit = 31 - (first ^ last).leading_zeros();
            let apart = (1u32 << bit) as f32 * cell;
            if best.is_none_or(|(most, ..)| apart > most) {
                best = Some((apart, axis, base[axis] + (last >> bit << bit) as f32 * cell));
            }
        }
        best.map(|(_, axis, plane)| (axis, plane))
    }
}
