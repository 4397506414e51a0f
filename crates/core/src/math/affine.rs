//! Affine transforms: placing instances and taking rays into object space.

use super::{Vec3, fma64, vec3};

/// An affine map `p -> linear * p + translation`, as three columns and a translation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Affine {
    /// Images of the three axes.
    pub columns: [Vec3; 3],
    /// Image of the origin.
    pub translation: Vec3,
}

impl Affine {
    /// The map that changes nothing.
    pub const IDENTITY: Affine = Affine {
        columns: [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)],
        translation: Vec3::ZERO,
    };

    /// Maps a point.
    #[inline(always)]
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.translation
            .plus_scaled(self.columns[0], p.x)
            .plus_scaled(self.columns[1], p.y)
            .plus_scaled(self.columns[2], p.z)
    }

    /// Maps a direction. Its length is scaled along, so a ray's `t` means the same before and after.
    #[inline(always)]
    pub fn direction(&self, d: Vec3) -> Vec3 {
        (self.columns[0] * d.x).plus_scaled(self.columns[1], d.y).plus_scaled(self.columns[2], d.z)
    }

    /// Multiplies by the transpose of the linear part. With the inverse map this takes normals forward; the
    /// result is not of unit length.
    #[inline(always)]
    pub fn transposed_direction(&self, n: Vec3) -> Vec3 {
        vec3(self.columns[0].dot(n), self.columns[1].dot(n), self.columns[2].dot(n))
    }

    /// The map with the absolute values of all numbers. Applied to a point's absolute coordinates it bounds the terms in the
    /// sums for the point's image, which bounds rounding errors.
    #[inline(always)]
    pub fn abs(&self) -> Affine {
        let [a, b, c] = self.columns;
        Affine { columns: [a.abs(), b.abs(), c.abs()], translation: self.translation.abs() }
    }

    /// Maps a point in double precision.
    #[inline(always)]
    pub fn point64(&self, p: [f64; 3]) -> [f64; 3] {
        let t = [self.translation.x as f64, self.translation.y as f64, self.translation.z as f64];
        self.add64(t, p)
    }

    /// Maps a direction in double precision.
    #[inline(always)]
    pub fn direction64(&self, d: [f64; 3]) -> [f64; 3] {
        self.add64([0.0; 3], d)
    }

    #[inline(always)]
    fn add64(&self, sum: [f64; 3], v: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = &self.columns;
        [
            add_products64(sum[0], [a.x, b.x, c.x], v),
            add_products64(sum[1], [a.y, b.y, c.y], v),
            add_products64(sum[2], [a.z, b.z, c.z], v),
        ]
    }

    /// `self` after `first`: maps `p` to `self(first(p))`.
    pub fn after(&self, first: &Affine) -> Affine {
        Affine {
            columns: [
                self.direction(first.columns[0]),
                self.direction(first.columns[1]),
                self.direction(first.columns[2]),
            ],
            translation: self.point(first.translation),
        }
    }

    /// Determinant of the linear part, in double precision.
    pub fn determinant(&self) -> f64 {
        let [a, b, c] = self.columns_f64();
        let n = cross64(b, c);
        fma64(a[2], n[2], fma64(a[1], n[1], a[0] * n[0]))
    }

    /// The inverse map by cofactors in double precision, or `None` where the linear part is singular or not finite.
    pub fn inverse(&self) -> Option<Affine> {
        let [a, b, c] = self.columns_f64();
        let determinant = self.determinant();
        let scale = 1.0 / determinant;
        if !scale.is_finite() || !determinant.is_finite() {
            return None;
        }
        // Rows of the inverse are the cross products of the columns over the determinant.
        let rows = [cross64(b, c), cross64(c, a), cross64(a, b)].map(|r| r.map(|x| x * scale));
        let t = [self.translation.x as f64, self.translation.y as f64, self.translation.z as f64];
        let column = |k: usize| vec3(rows[0][k] as f32, rows[1][k] as f32, rows[2][k] as f32);
        let moved = rows.map(|r| -fma64(r[2], t[2], fma64(r[1], t[1], r[0] * t[0])));
        let inverse = Affine {
            columns: [column(0), column(1), column(2)],
            translation: vec3(moved[0] as f32, moved[1] as f32, moved[2] as f32),
        };
        inverse.is_finite().then_some(inverse)
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.columns.iter().all(|c| c.is_finite()) && self.translation.is_finite()
    }

    /// The largest absolute row sum of the linear part: how much a box can grow.
    #[inline(always)]
    pub fn growth(&self) -> f32 {
        let [a, b, c] = self.columns;
        let row = |x: f32, y: f32, z: f32| x.abs() + y.abs() + z.abs();
        row(a.x, b.x, c.x).max(row(a.y, b.y, c.y)).max(row(a.z, b.z, c.z))
    }

    fn columns_f64(&self) -> [[f64; 3]; 3] {
        self.columns.map(|c| [c.x as f64, c.y as f64, c.z as f64])
    }
}

#[inline(always)]
fn add_products64(sum: f64, a: [f32; 3], b: [f64; 3]) -> f64 {
    fma64(a[2] as f64, b[2], fma64(a[1] as f64, b[1], fma64(a[0] as f64, b[0], sum)))
}

fn cross64(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let part = |i: usize, j: usize| fma64(a[i], b[j], -(a[j] * b[i]));
    [part(1, 2), part(2, 0), part(0, 1)]
}
