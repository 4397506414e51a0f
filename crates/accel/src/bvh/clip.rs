//! Boxes of parts of triangles.
//!
//! Why nothing is lost. Where a hit counts, the ray's line passes within 2^-39 of the magnitudes in the test of a point p of
//! the triangle (`eosphor_core::intersect::precise`), which the slack of each ray's slab test covers, from wherever it
//! comes. So it is enough that for each p some reference's box contains p, with slack for the rounding of the slab test.
//! This holds for whole triangles, and each cut keeps it: if box B has it for p, p lies in the part on its side of the plane;
//! the new box is the box around that part, grown by [`part_margin`], which covers the rounding of the cut and the slack, and
//! cut with B: both contain p with slack. Nothing here depends on the rest of the scene, nor on where rays come from.

use super::lanes::{Box4, Lanes};
use super::reference::Reference;
use eosphor_core::math::Vec3;

/// Cuts are rounded by less than this (32 · 2^-24) times the largest coordinate of the triangle.
pub(super) const PART_SLACK: f32 = 1.0 / 524_288.0;

/// What boxes of parts of a triangle are grown by.
#[inline(always)]
pub(super) fn part_margin(triangle: &[Vec3; 3]) -> f32 {
    let [a, b, c] = triangle.map(Vec3::abs);
    PART_SLACK * a.max(b.max(c)).max_component()
}

/// The margin of a reference's triangle; other primitives are not cut.
#[inline(always)]
pub(super) fn margin_of(reference: &Reference, triangles: &[[Vec3; 3]]) -> f32 {
    triangles.get(reference.index() as usize).map_or(0.0, part_margin)
}

/// Corners, fourth lanes 0.
#[inline(always)]
fn corners(triangle: &[Vec3; 3]) -> [Lanes; 3] {
    triangle.map(|v| Lanes::new(v.x, v.y, v.z, 0.0))
}

#[inline(always)]
fn grown(b: Box4, margin: f32) -> Box4 {
    let m = Lanes::splat(margin);
    Box4 { low: b.low.minus(m), high: b.high.plus(m) }
}

/// The outline of a triangle, to be cut across one axis. Free of branches: which corners lie where cannot be foreseen.
struct Outline {
    corners: [Lanes; 3],
    /// Each corner to the next.
    edges: [Lanes; 3],
    /// The axis' coordinates of the corners.
    at: [f32; 3],
    /// One over the edges' extents along the axis.
    inverse: Lanes,
}

impl Outline {
    #[inline(always)]
    fn new(triangle: &[Vec3; 3], axis: usize) -> Outline {
        let [a, b, c] = corners(triangle);
        let at = triangle.map(|v| v[axis]);
        let along = Lanes::new(at[1] - at[0], at[2] - at[1], at[0] - at[2], 1.0);
        Outline {
            corners: [a, b, c],
            edges: [b.minus(a), c.minus(b), a.minus(c)],
            at,
            inverse: Lanes::splat(1.0).over(along),
        }
    }

    /// The box around the points of the outline on a plane.
    #[inline(always)]
    fn crossing(&self, plane: f32) -> Box4 {
        let from = Lanes::new(plane - self.at[0], plane - self.at[1], plane - self.at[2], 0.0);
        // Rounding must not leave the edge.
        let f = from.times(self.inverse).max(Lanes::splat(0.0)).min(Lanes::splat(1.0)).array();
        let below = self.at.map(|x| x < plane);
        let mut b = Box4::empty();
        for i in 0..3 {
            let x = self.corners[i].plus(self.edges[i].times(Lanes::splat(f[i])));
            b = b.including(x.nan_if(below[i] == below[(i + 1) % 3]));
        }
        b
    }

    /// The box around the corners from one plane to another.
    #[inline(always)]
    fn corners_between(&self, low: f32, high: f32) -> Box4 {
        let mut b = Box4::empty();
        for i in 0..3 {
            b = b.including(self.corners[i].nan_if(!((self.at[i] >= low) & (self.at[i] <= high))));
        }
        b
    }
}

/// Boxes of what lies below and above a plane, out of a reference's box. A side with nothing is inside out.
#[inline(always)]
pub(super) fn cut(triangle: &[Vec3; 3], whole: &Reference, axis: usize, plane: f32) -> [Box4; 2] {
    let margin = part_margin(triangle);
    let outline = Outline::new(triangle, axis);
    let crossing = outline.crossing(plane);
    let sides =
        [outline.corners_between(f32::NEG_INFINITY, plane), outline.corners_between(plane, f32::INFINITY)];
    sides.map(|s| grown(s.union(crossing), margin).intersection(whole.box4()))
}

/// Equal slices of a range of one axis.
#[derive(Clone, Copy)]
pub(super) struct Slices {
    pub(super) axis: usize,
    pub(super) base: f32,
    pub(super) scale: f32,
    pub(super) width: f32,
}

impl Slices {
    #[inline(always)]
    pub(super) fn plane(&self, k: usize) -> f32 {
        self.base + self.width * k as f32
    }

    /// Adds the box of each part in slices `first..=last`, out of a reference's box, to those of the slices.
    #[inline(always)]
    pub(super) fn chop<const N: usize>(
        &self,
        triangle: &[Vec3; 3],
        whole: &Reference,
        (first, last): (usize, usize),
        slices: &mut [Box4; N],
    ) {
        let margin = part_margin(triangle);
        let outline = Outline::new(triangle, self.axis);
        // Corners beyond the first and last slice were cut off before, or reach out by less than the margin.
        let mut low = self.plane(first);
        let mut entry = outline.crossing(low);
        for k in first..=last {
            let high = self.plane(k + 1);
            let exit = outline.crossing(high);
            let part = outline.corners_between(low, high).union(entry).union(exit);
            let part = grown(part, margin).intersection(whole.box4());
            let slice = &mut slices[k % N];
            *slice = slice.union(part.nothing_if(!part.holds_something()));
            (low, entry) = (high, exit);
        }
    }
}
