//! Boxes of parts of triangles.
//!
//! Why nothing is lost. A hit counts for a ray and a triangle, and its point lies within [`HIT_TOLERANCE`] × extent of a
//! point p of the triangle. So it is enough that for each p some reference's box contains everything within [`PADDING`]
//! × extent of p (twice that tolerance; the other half is room for rounding). This holds for whole triangles, and each
//! cut keeps it: if box B has it for p, p lies in B, hence in the part on its side of the plane; the new box is the box
//! around that part, grown by [`PART_PADDING`] × [`PADDING`] × extent (which covers the rounding of the cut as well), and
//! cut with B: both contain the neighbourhood of p.
//!
//! Hits may also count a little outside the triangle, by `EDGE_TOLERANCE` × (extent + distance of the origin), where two
//! triangles meet. Parts are padded eight times as much as whole triangles so that these lie inside as well, with origins
//! up to 128 extents away and down to incidence at 1/256 radian.
//!
//! [`HIT_TOLERANCE`]: eosphor_core::intersect::HIT_TOLERANCE
//! [`PADDING`]: eosphor_core::intersect::PADDING

use super::lanes::{Box4, Lanes};
use super::reference::Reference;
use eosphor_core::math::Vec3;

/// Bounds of parts are padded by this times what bounds of whole triangles are padded by.
pub(super) const PART_PADDING: f32 = 8.0;

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

/// Point on an edge from p to q where a coordinate runs from `p_at` to `q_at` and is `plane`.
#[inline(always)]
fn between(p: Lanes, q: Lanes, p_at: f32, inverse: f32, plane: f32) -> Lanes {
    // Rounding must not leave the edge.
    let f = ((plane - p_at) * inverse).max(0.0).min(1.0);
    p.plus(q.minus(p).times(Lanes::splat(f)))
}

/// Boxes of what lies below and above a plane, out of a reference's box. A side with nothing is inside out.
#[inline(always)]
pub(super) fn cut(
    triangle: &[Vec3; 3],
    whole: &Reference,
    axis: usize,
    plane: f32,
    margin: f32,
) -> [Box4; 2] {
    let points = corners(triangle);
    let mut sides = [Box4::empty(); 2];
    for i in 0..3 {
        let (p, q) = (points[i], points[(i + 1) % 3]);
        let (p_at, q_at) = (triangle[i][axis], triangle[(i + 1) % 3][axis]);
        if p_at <= plane {
            sides[0] = sides[0].including(p);
        }
        if p_at >= plane {
            sides[1] = sides[1].including(p);
        }
        if (p_at < plane) != (q_at < plane) {
            let x = between(p, q, p_at, 1.0 / (q_at - p_at), plane);
            sides = sides.map(|s| s.including(x));
        }
    }
    sides.map(|s| grown(s, margin).intersection(whole.box4()))
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
        margin: f32,
        slices: &mut [Box4; N],
    ) {
        let points = corners(triangle);
        let mut parts = [Box4::empty(); N];
        let at = triangle.map(|v| v[self.axis]);
        // Slices of the corners, one more than their number; 0 is below all.
        let slice = at.map(|x| (((x - self.base) * self.scale + 1.0).max(0.0) as usize).min(N + 1));
        for i in 0..3 {
            let j = (i + 1) % 3;
            if slice[i] > first && slice[i] <= last + 1 {
                let part = &mut parts[(slice[i] - 1) % N];
                *part = part.including(points[i]);
            }
            let (low, high) = if slice[i] <= slice[j] { (i, j) } else { (j, i) };
            if slice[low] == slice[high] {
                continue;
            }
            let inverse = 1.0 / (at[high] - at[low]);
            // Plane k lies between slices k - 1 and k.
            for k in slice[low].max(first)..=(slice[high] - 1).min(last + 1) {
                let x = between(points[low], points[high], at[low], inverse, self.plane(k));
                if k > first {
                    parts[(k - 1) % N] = parts[(k - 1) % N].including(x);
                }
                if k <= last {
                    parts[k % N] = parts[k % N].including(x);
                }
            }
        }
        for k in first..=last {
            let part = grown(parts[k % N], margin).intersection(whole.box4());
            if part.holds_something() {
                slices[k % N] = slices[k % N].union(part);
            }
        }
    }
}
