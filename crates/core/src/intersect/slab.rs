//! Ray against box: the slab test (Kay and Kajiya 1986) with one fused multiply-add a plane.

use crate::geometry::Bounds;
use crate::math::{Vec3, fma, max, min, vec3};

/// What the slab test needs of a ray.
#[derive(Clone, Copy, Debug)]
pub struct Slab {
    /// One over the direction, finite.
    pub inverse: Vec3,
    /// Minus the origin over the direction.
    pub offset: Vec3,
}

/// Directions smaller than this in a component are taken as this, so that no infinity meets a zero.
const SMALLEST_DIRECTION: f32 = 1e-18;

/// Distances come out of the slab test with errors of a few units in the last place: the far side is moved out by 8.
const WIDEN: f32 = 1.0 + 8.0 / 16_777_216.0;

impl Slab {
    /// For a ray from `origin` along `direction` (any length).
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3) -> Slab {
        let safe = |d: f32| if d.abs() > SMALLEST_DIRECTION { d } else { SMALLEST_DIRECTION.copysign(d) };
        let inverse = vec3(1.0 / safe(direction.x), 1.0 / safe(direction.y), 1.0 / safe(direction.z));
        Slab { inverse, offset: -(origin * inverse) }
    }

    /// Where the ray, from `t_min` on, enters and leaves the box. The entry grows and the exit shrinks with a smaller
    /// box, for every ray and whatever the rounding: the product and sum are rounded once, which is monotone.
    #[inline(always)]
    pub fn interval(&self, bounds: &Bounds, t_min: f32) -> (f32, f32) {
        let (i, o) = (self.inverse, self.offset);
        let (x0, x1) = (fma(bounds.min.x, i.x, o.x), fma(bounds.max.x, i.x, o.x));
        let (y0, y1) = (fma(bounds.min.y, i.y, o.y), fma(bounds.max.y, i.y, o.y));
        let (z0, z1) = (fma(bounds.min.z, i.z, o.z), fma(bounds.max.z, i.z, o.z));
        let near = max(max(min(x0, x1), min(y0, y1)), max(min(z0, z1), t_min));
        let far = min(min(max(x0, x1), max(y0, y1)), max(z0, z1));
        (near, far)
    }

    /// Whether an interval is open and starts no later than `t_max`.
    #[inline(always)]
    pub fn passes(near: f32, far: f32, t_max: f32) -> bool {
        near <= min(far, t_max) * WIDEN
    }
}
