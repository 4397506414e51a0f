//! Ray against box: the slab test (Kay and Kajiya 1986) with one fused multiply-add a plane.

use super::LARGEST_NUMBER;
use crate::geometry::Bounds;
use crate::math::{Vec3, fma, max, min, vec3};

/// What the slab test needs of a ray.
#[derive(Clone, Copy, Debug)]
pub struct Slab {
    /// One over the direction, finite.
    pub inverse: Vec3,
    /// Minus the origin over the direction, less the slack: for the planes that the ray meets first.
    pub near_offset: Vec3,
    /// The same plus the slack: for the planes on the far side.
    pub far_offset: Vec3,
}

/// Directions smaller than this in a component are taken as this, so that no infinity meets a zero.
pub const SMALLEST_DIRECTION: f32 = 1e-20;

/// Shorter rays meet every box: beside them [`SMALLEST_DIRECTION`] would be a tilt.
pub const SHORT: f32 = 1e-8;

/// Boxes count as larger along an axis by this times the origin's coordinate: over the rounding errors that it brings into
/// the test, 3 · 2^-24. It is taken into the offsets, so it costs nothing in the test.
pub const ORIGIN_SLACK: f32 = 1.0 / 2_097_152.0;

/// And by this (2^-36) times all coordinates of box and origin, along every axis: over the tolerance of hits in double
/// precision, and what [`SMALLEST_DIRECTION`] tilts.
pub const EXTENT_SLACK: f32 = 1.0 / (1u64 << 36) as f32;

impl Slab {
    /// For a ray from `origin` along `direction` (any length), and boxes with coordinates up to `extent`.
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3, extent: f32) -> Slab {
        let safe = |d: f32| if d.abs() > SMALLEST_DIRECTION { d } else { SMALLEST_DIRECTION.copysign(d) };
        let inverse = vec3(1.0 / safe(direction.x), 1.0 / safe(direction.y), 1.0 / safe(direction.z));
        let offset = -(origin * inverse);
        let (o, d) = (origin.abs(), direction.abs());
        let everywhere = EXTENT_SLACK * (extent + o.max_component());
        let everywhere = if d.max_component() >= SHORT { everywhere } else { LARGEST_NUMBER };
        let slack = inverse.abs() * (o * ORIGIN_SLACK + Vec3::splat(everywhere));
        Slab { inverse, near_offset: offset - slack, far_offset: offset + slack }
    }

    /// Where the ray, from `t_min` on, enters and leaves the box. The entry grows and the exit shrinks with a smaller
    /// box, for every ray and whatever the rounding: the product and sum are rounded once, which is monotone.
    #[inline(always)]
    pub fn interval(&self, bounds: &Bounds, t_min: f32) -> (f32, f32) {
        let (i, n, f) = (self.inverse, self.near_offset, self.far_offset);
        let (b, e) = (bounds.min, bounds.max);
        let (x0, x1) = if i.x < 0.0 { (e.x, b.x) } else { (b.x, e.x) };
        let (y0, y1) = if i.y < 0.0 { (e.y, b.y) } else { (b.y, e.y) };
        let (z0, z1) = if i.z < 0.0 { (e.z, b.z) } else { (b.z, e.z) };
        let near = max(max(fma(x0, i.x, n.x), fma(y0, i.y, n.y)), max(fma(z0, i.z, n.z), t_min));
        let far = min(min(fma(x1, i.x, f.x), fma(y1, i.y, f.y)), fma(z1, i.z, f.z));
        (near, far)
    }

    /// Whether an interval is open and starts no later than `t_max`.
    #[inline(always)]
    pub fn passes(near: f32, far: f32, t_max: f32) -> bool {
        near <= min(far, t_max)
    }
}
