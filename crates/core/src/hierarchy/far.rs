//! Rays from far away. Single precision at their origin is coarser than what they pass, so that they would visit all of it.
//! A walk for them measures from where the ray enters the box of the whole tree. Hits are still those of the ray itself.

use crate::geometry::Bounds;
use crate::intersect::precise::{PreciseRay, along64, sum64};
use crate::intersect::{EXTENT_SLACK, LocalRay, Slab, USUAL_LENGTH, WORLD_FROM_OBJECT_ROUNDING};
use crate::math::{Affine, Vec3, vec3};
use crate::out_of_line::out_of_line;
use crate::ray::Ray;

/// From this many extents of a tree on, an origin is far away.
pub const FAR: f32 = 64.0;

/// What is added to the box, over its extent.
const MARGIN: f64 = 1.0 / 1_048_576.0;

/// The least way from where the ray begins to the box, over its extent, for hits to be certain.
const GAP: f64 = 1.0 / 1024.0;

/// More than what rounding may change a `t` of double precision by, over it: what enters the box has to be where the ray does,
/// however far away it starts. (The point at such a `t` is on the ray all the same: it is rounded once.)
const T_ROUNDING: f64 = 1.0 / (1u64 << 50) as f64;

/// More than rounding to single precision.
const ROUNDING: f64 = 1.0 / 4_194_304.0;

/// Whether a ray starts far from everything within the extent.
#[inline(always)]
pub fn is_far(origin: Vec3, extent: f32) -> bool {
    // Nothing is inside where the extent is 0.
    (origin.abs().max_component() > FAR * extent) & (extent > 0.0)
}

/// A ray that starts where it enters a box.
pub struct FarRay {
    /// What it looks like from there. Hits that are certain by it are hits; none is clear.
    pub ray: LocalRay,
    /// The point where it enters the box, as a `t` of the world ray.
    pub from: f64,
    /// What boxes are too small by: how far from this ray an instance may see it.
    pub slack: f32,
}

impl FarRay {
    /// `None` where the ray passes the box by.
    #[inline(always)]
    pub fn new(ray: &Ray, map: Option<&Affine>, bounds: &Bounds) -> Option<FarRay> {
        far_ray(ray, map, bounds, 0.0)
    }

    /// In the world, for the boxes of instances. Each is met by the ray as its map takes it into the instance's space: from far
    /// away, the rounding of that moves it.
    #[inline(always)]
    pub fn to_instances(ray: &Ray, bounds: &Bounds) -> Option<FarRay> {
        far_ray(ray, None, bounds, moved_at(ray))
    }
}

/// A coordinate as whose [`EXTENT_SLACK`] a ray from far away is moved when instances see it: maps take its origin there in
/// double precision, which moves it by less than 2^-42 of its own coordinates.
#[inline(always)]
pub fn moved_at(ray: &Ray) -> f32 {
    ray.origin.abs().max_component() * (1.0 / 64.0)
}

/// Where a ray enters a box, and what it looks like from there: all of a [`FarRay`] but its slab.
pub struct BoxEntry {
    /// The point.
    pub origin: Vec3,
    /// In the space of the box.
    pub direction: Vec3,
    /// From the point, and lowered: what is not beyond it does not count for certain.
    pub t_min: f32,
    /// From the point, and lowered: what is over before it counts for certain.
    pub t_max: f32,
    /// At least the direction's length: [`LocalRay::length`].
    pub length: f32,
    /// The original ray's `t` of the point where the moved ray starts: [`FarRay::from`].
    pub from: f64,
    /// What boxes are grown by for this ray: [`FarRay::slack`].
    pub slack: f32,
}

impl BoxEntry {
    /// Into this box, by a ray that instances see moved by the slack of this coordinate. `None` where it passes by.
    #[inline(always)]
    pub fn new(ray: &Ray, map: Option<&Affine>, bounds: &Bounds, moved_at: f32) -> Option<BoxEntry> {
        let extent = bounds.extent();
        let PreciseRay { origin: o, direction: d } = PreciseRay::of(ray, map);
        let slack = EXTENT_SLACK * moved_at;
        let margin = MARGIN * extent as f64 + slack as f64;
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut axis = 0;
        while axis < 3 {
            let low = bounds.min[axis] as f64 - margin - o[axis];
            let high = bounds.max[axis] as f64 + margin - o[axis];
            if d[axis] != 0.0 {
                // One division, which takes long: what its rounding adds is within `T_ROUNDING`.
                let inverse = 1.0 / d[axis];
                let (a, b) = (low * inverse, high * inverse);
                let (first, last) = if a < b { (a, b) } else { (b, a) };
                near = if first > near { first } else { near };
                far = if last < far { last } else { far };
            } else if (low > 0.0) | (high < 0.0) {
                return None;
            }
            axis += 1;
        }
        (near, far) = (near - near.abs() * T_ROUNDING, far + far.abs() * T_ROUNDING);
        // NaN is no way through.
        if !((near <= far) & (far >= ray.t_min as f64) & near.is_finite()) {
            return None;
        }
        let p = along64(o, d, near);
        let sum = sum64(d);
        let length = sum as f32 * WORLD_FROM_OBJECT_ROUNDING;
        let [shortest, longest] = USUAL_LENGTH;
        let is_usual = (shortest..=longest).contains(&length);
        let (t_min, t_max) = (ray.t_min as f64, ray.t_max as f64);
        // Nothing is certain where the ray may begin within the box: `t` is rounded to single precision, and compared then.
        let rounding = ROUNDING * (t_min.abs() + near.abs());
        let begins_before = (near - t_min - rounding) * sum > GAP * extent as f64;
        let end = if begins_before { t_max - near } else { f64::NEG_INFINITY };
        let rounding = if end.is_finite() { ROUNDING * (t_max.abs() + near.abs()) } else { 0.0 };
        let t_min = (t_min - near) as f32;
        Some(BoxEntry {
            origin: vec3(p[0] as f32, p[1] as f32, p[2] as f32),
            direction: vec3(d[0] as f32, d[1] as f32, d[2] as f32),
            t_min: t_min - t_min.abs() * (1.0 / 4_194_304.0),
            t_max: (end - rounding) as f32,
            length: if is_usual { length } else { f32::INFINITY },
            from: near,
            slack,
        })
    }

    /// The ray, for boxes and primitives within this extent.
    #[inline(always)]
    pub fn ray(&self, extent: f32) -> LocalRay {
        let (origin, direction) = (self.origin, self.direction);
        let size = origin.abs();
        LocalRay {
            origin,
            direction,
            t_min: self.t_min,
            t_max: self.t_max,
            slab: Slab::new(origin, direction, extent),
            length: self.length,
            reach: size.x + size.y + size.z,
            scale: 0.0,
        }
    }
}

out_of_line! {
    /// [`FarRay::new`]; instances move the ray by the slack of this coordinate.
    fn far_ray(ray: &Ray, map: Option<&Affine>, bounds: &Bounds, moved_at: f32) -> Option<FarRay> {
        let entry = BoxEntry::new(ray, map, bounds, moved_at)?;
        Some(FarRay { ray: entry.ray(bounds.extent() + moved_at), from: entry.from, slack: entry.slack })
    }
}
