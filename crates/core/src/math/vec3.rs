//! Three-component vectors: points, directions and linear RGB colours.

use super::float::{difference_of_products, fma, max, min, sqrt};
use core::ops::{Add, AddAssign, Index, Mul, MulAssign, Neg, Sub};

/// A point, a direction or a linear RGB colour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "[f32; 3]", into = "[f32; 3]"))]
#[repr(C)]
pub struct Vec3 {
    /// First component, or red.
    pub x: f32,
    /// Second component, or green.
    pub y: f32,
    /// Third component, or blue.
    pub z: f32,
}

/// Shorthand for a [`Vec3`] from its components.
#[inline(always)]
pub const fn vec3(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3 { x, y, z }
}

impl Vec3 {
    /// The origin, the null direction, black.
    pub const ZERO: Vec3 = vec3(0.0, 0.0, 0.0);
    /// One in every component, white.
    pub const ONE: Vec3 = vec3(1.0, 1.0, 1.0);

    /// The same number in every component.
    #[inline(always)]
    pub const fn splat(s: f32) -> Vec3 {
        vec3(s, s, s)
    }

    /// Dot product, fused.
    #[inline(always)]
    pub fn dot(self, o: Vec3) -> f32 {
        fma(self.z, o.z, fma(self.y, o.y, self.x * o.x))
    }

    /// Cross product, fused.
    #[inline(always)]
    pub fn cross(self, o: Vec3) -> Vec3 {
        vec3(
            difference_of_products(self.y, o.z, self.z, o.y),
            difference_of_products(self.z, o.x, self.x, o.z),
            difference_of_products(self.x, o.y, self.y, o.x),
        )
    }

    /// `self + direction * t`, fused.
    #[inline(always)]
    pub fn plus_scaled(self, direction: Vec3, t: f32) -> Vec3 {
        vec3(fma(direction.x, t, self.x), fma(direction.y, t, self.y), fma(direction.z, t, self.z))
    }

    /// Squared length.
    #[inline(always)]
    pub fn length_squared(self) -> f32 {
        self.dot(self)
    }

    /// Length.
    #[inline(always)]
    pub fn length(self) -> f32 {
        sqrt(self.dot(self))
    }

    /// The unit vector of the same direction; not finite for the null vector.
    #[inline(always)]
    pub fn normalize(self) -> Vec3 {
        self * (1.0 / sqrt(self.dot(self)))
    }

    /// The unit vector of the same direction, or `fallback` where the length is zero or not finite.
    #[inline(always)]
    pub fn normalize_or(self, fallback: Vec3) -> Vec3 {
        let q = self.dot(self);
        // Subnormal squares have lost their digits: they count as zero.
        if q > f32::MIN_POSITIVE && q < f32::INFINITY { self * (1.0 / sqrt(q)) } else { fallback }
    }

    /// The largest component.
    #[inline(always)]
    pub fn max_component(self) -> f32 {
        max(self.x, max(self.y, self.z))
    }

    /// The smallest component.
    #[inline(always)]
    pub fn min_component(self) -> f32 {
        min(self.x, min(self.y, self.z))
    }

    /// Component-wise absolute value.
    #[inline(always)]
    pub fn abs(self) -> Vec3 {
        vec3(self.x.abs(), self.y.abs(), self.z.abs())
    }

    /// Component-wise minimum.
    #[inline(always)]
    pub fn min(self, o: Vec3) -> Vec3 {
        vec3(min(self.x, o.x), min(self.y, o.y), min(self.z, o.z))
    }

    /// Component-wise maximum.
    #[inline(always)]
    pub fn max(self, o: Vec3) -> Vec3 {
        vec3(max(self.x, o.x), max(self.y, o.y), max(self.z, o.z))
    }

    /// Whether every component is a finite number.
    #[inline(always)]
    pub fn is_finite(self) -> bool {
        self.x.is_finite() & self.y.is_finite() & self.z.is_finite()
    }
}

impl From<[f32; 3]> for Vec3 {
    #[inline(always)]
    fn from([x, y, z]: [f32; 3]) -> Vec3 {
        vec3(x, y, z)
    }
}

impl From<Vec3> for [f32; 3] {
    #[inline(always)]
    fn from(v: Vec3) -> [f32; 3] {
        [v.x, v.y, v.z]
    }
}

impl Index<usize> for Vec3 {
    type Output = f32;
    #[inline(always)]
    fn index(&self, axis: usize) -> &f32 {
        match axis {
            0 => &self.x,
            1 => &self.y,
            _ => &self.z,
        }
    }
}

impl Add for Vec3 {
    type Output = Vec3;
    #[inline(always)]
    fn add(self, o: Vec3) -> Vec3 {
        vec3(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl AddAssign for Vec3 {
    #[inline(always)]
    fn add_assign(&mut self, o: Vec3) {
        *self = *self + o;
    }
}

impl Sub for Vec3 {
    type Output = Vec3;
    #[inline(always)]
    fn sub(self, o: Vec3) -> Vec3 {
        vec3(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

/// Component-wise product: a colour filtered by a colour.
impl Mul for Vec3 {
    type Output = Vec3;
    #[inline(always)]
    fn mul(self, o: Vec3) -> Vec3 {
        vec3(self.x * o.x, self.y * o.y, self.z * o.z)
    }
}

impl MulAssign for Vec3 {
    #[inline(always)]
    fn mul_assign(&mut self, o: Vec3) {
        *self = *self * o;
    }
}

impl Mul<f32> for Vec3 {
    type Output = Vec3;
    #[inline(always)]
    fn mul(self, s: f32) -> Vec3 {
        vec3(self.x * s, self.y * s, self.z * s)
    }
}

impl Neg for Vec3 {
    type Output = Vec3;
    #[inline(always)]
    fn neg(self) -> Vec3 {
        vec3(-self.x, -self.y, -self.z)
    }
}
