//! Where a ray passes the planes between cells, on the safe side of rounding; and why no hit is lost between cells.
//!
//! Cells cut primitives apart, so it takes an argument that one of a primitive's cells is visited in time. A hit at t
//! lies in the primitive's bounds. Builders of cells pad these by more than the slab test can be wrong by, so by that test
//! a ray with a hit at t enters the padded bounds at s <= t. (It is s that is followed here.) A primitive is entered in
//! every cell that its padded bounds reach into. Follow a walk down to the cell that has s in its interval, at a plane m
//! between two cells of which the ray meets the first one first. Let n(m) <= N(m) and F(m) <= f(m), with N and F what the slab
//! test makes of the plane as a near and as a far side, and n and f what is computed here.
//!
//! - The primitive is in the second cell alone: its near side lies at m or beyond, and N is monotone, so
//!   n(m) <= N(m) <= s. The second cell is visited, from n(m) on.
//! - It is in the first cell alone: s <= F(m) <= f(m). The first cell is visited, up to f(m).
//! - It is in both: either s <= f(m), or s > f(m) >= n(m).
//!
//! So a cell with the primitive is entered at s or before, and s <= t: a walk may leave out cells that the ray enters
//! beyond the best hit. Nothing here depends on how large the errors are, as long as n and f are outside N and F.

use crate::geometry::Bounds;
use crate::intersect::LocalRay;
use crate::math::{Vec3, fma, max, min, vec3};

/// Planes count as nearer and farther by this times the largest coordinate of ray and geometry. The slab test is off
/// from exact values by less than 2^-20 of that (its own slack of 2^-21, and four roundings); what traversals compute by
/// adding up halves is off by one rounding, 2^-24, a level.
const SLACK: f32 = 1.0 / 262_144.0;

/// What planes between cells need of a ray.
#[derive(Clone, Copy)]
pub(super) struct CellRay {
    /// One over the direction, finite.
    pub(super) inverse: Vec3,
    /// Minus the origin over the direction.
    pub(super) offset: Vec3,
    /// How much earlier and later planes count as met.
    pub(super) slack: Vec3,
    near_offset: Vec3,
    far_offset: Vec3,
}

impl CellRay {
    /// For cells within the given bounds.
    #[inline(always)]
    pub(super) fn new(ray: &LocalRay, bounds: &Bounds) -> CellRay {
        let inverse = ray.slab.inverse;
        let extent = bounds.min.abs().max(bounds.max.abs()).max_component();
        let offset = -(ray.origin * inverse);
        let slack = inverse.abs() * (SLACK * (extent + ray.origin.abs().max_component()));
        let (near, far) = (offset - slack, offset + slack);
        // Where numbers overflow nothing is known: every cell is visited.
        let known = |n: f32, f: f32, value: f32, otherwise: f32| {
            if n.is_finite() & f.is_finite() { value } else { otherwise }
        };
        let each = |values: Vec3, otherwise: f32| {
            vec3(
                known(near.x, far.x, values.x, otherwise),
                known(near.y, far.y, values.y, otherwise),
                known(near.z, far.z, values.z, otherwise),
            )
        };
        CellRay {
            inverse,
            offset,
            slack: each(slack, f32::INFINITY),
            near_offset: each(near, f32::NEG_INFINITY),
            far_offset: each(far, f32::INFINITY),
        }
    }

    /// Where the ray passes a plane across an axis, at the earliest: n(m). NaN where nothing is known.
    #[inline(always)]
    pub(super) fn earliest(&self, axis: usize, plane: f32) -> f32 {
        fma(plane, self.inverse[axis], self.near_offset[axis])
    }

    /// The same, at the latest: f(m).
    #[inline(always)]
    pub(super) fn latest(&self, axis: usize, plane: f32) -> f32 {
        fma(plane, self.inverse[axis], self.far_offset[axis])
    }

    /// Bit 4 for x, 2 for y, 1 for z where the ray goes towards lower coordinates.
    #[inline(always)]
    pub(super) fn backwards(&self) -> u32 {
        let i = &self.inverse;
        ((i.x < 0.0) as u32) << 2 | ((i.y < 0.0) as u32) << 1 | (i.z < 0.0) as u32
    }

    /// The interval of the ray, from `t_min` on, within the box that holds all cells; `None` where it is empty or
    /// starts beyond `t_max`, or where a bound is NaN.
    #[inline(always)]
    pub(super) fn enter(&self, bounds: &Bounds, t_min: f32, t_max: f32) -> Option<(f32, f32)> {
        let (mut near, mut far) = (t_min, f32::INFINITY);
        let mut axis = 0;
        while axis < 3 {
            let (low, high) = (bounds.min[axis], bounds.max[axis]);
            let (first, last) = if self.inverse[axis] < 0.0 { (high, low) } else { (low, high) };
            // Unknown planes, NaN, change nothing.
            near = max(self.earliest(axis, first), near);
            far = min(self.latest(axis, last), far);
            axis += 1;
        }
        if (near <= far) & in_time(near, t_max) { Some((near, far)) } else { None }
    }
}

/// Whether a cell that the ray enters at `enter` can hold a hit up to `t_max`. At equality a tie may wait there.
#[inline(always)]
pub(super) fn in_time(enter: f32, t_max: f32) -> bool {
    crate::intersect::Slab::passes(enter, f32::INFINITY, t_max)
}
