//! Placement in double precision and a fixed order: the same bits on every machine.

use eosphor_core::math::{Affine, Vec3, elementary64, sqrt64, vec3};

/// An affine map: the images of the three axes, then that of the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Matrix(pub(crate) [[f64; 3]; 4]);

impl Matrix {
    pub(crate) const IDENTITY: Matrix =
        Matrix([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]);

    /// Of a matrix column after column, whose fourth row is (0, 0, 0, 1).
    pub(crate) fn of_columns(m: [f32; 16]) -> Matrix {
        Matrix([0, 4, 8, 12].map(|c| [m[c], m[c + 1], m[c + 2]].map(f64::from)))
    }

    /// Scale, then rotation by a quaternion (x, y, z, w) of any length, then translation.
    pub(crate) fn of_parts(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> Matrix {
        let q = rotation;
        let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
        let length = sqrt64(square);
        // One of no length turns nothing.
        let [x, y, z, w] = if length > 0.0 { q.map(|part| part / length) } else { [0.0, 0.0, 0.0, 1.0] };
        let axes = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
            [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
            [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        let [a, b, c] = axes;
        let [i, j, k] = scale;
        Matrix([a.map(|p| p * i), b.map(|p| p * j), c.map(|p| p * k), translation])
    }

    /// `self` after `first`.
    pub(crate) fn after(&self, first: &Matrix) -> Matrix {
        let [a, b, c, origin] = &self.0;
        let linear = |v: &[f64; 3], axis: usize| a[axis] * v[0] + b[axis] * v[1] + c[axis] * v[2];
        let column = |k: usize| [0, 1, 2].map(|axis| linear(&first.0[k], axis));
        let moved = [0, 1, 2].map(|axis| linear(&first.0[3], axis) + origin[axis]);
        Matrix([column(0), column(1), column(2), moved])
    }

    /// The affine map as a matrix in double precision.
    pub(crate) fn of_affine(map: &Affine) -> Matrix {
        let [a, b, c] = map.columns;
        Matrix([a, b, c, map.translation].map(|v| <[f32; 3]>::from(v).map(f64::from)))
    }

    pub(crate) fn affine(&self) -> Affine {
        let [a, b, c, origin] = self.0.map(|v| vec3(v[0] as f32, v[1] as f32, v[2] as f32));
        Affine { columns: [a, b, c], translation: origin }
    }

    /// Where it takes a point.
    pub(crate) fn point(&self, p: [f64; 3]) -> [f64; 3] {
        let [a, b, c, origin] = &self.0;
        [0, 1, 2].map(|axis| a[axis] * p[0] + b[axis] * p[1] + c[axis] * p[2] + origin[axis])
    }

    pub(crate) fn position(&self) -> Vec3 {
        self.affine().translation
    }

    /// The unit image of an axis (0 x, 1 y, 2 z); `None` where it has no length.
    pub(crate) fn unit_axis(&self, axis: usize) -> Option<Vec3> {
        let [x, y, z] = self.0[axis];
        let length = sqrt64(x * x + y * y + z * z);
        let unit = vec3((x / length) as f32, (y / length) as f32, (z / length) as f32);
        (length > 0.0 && unit.is_finite()).then_some(unit)
    }
}

/// Rotation about a coordinate axis, counter-clockwise seen from its tip.
pub(crate) fn about(axis: usize, degrees: f64) -> Matrix {
    let radians = degrees * (std::f64::consts::PI / 180.0);
    let (sin, cos) = (elementary64::sin(radians), elementary64::cos(radians));
    let (next, after) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut columns = Matrix::IDENTITY;
    columns.0[next][next] = cos;
    columns.0[next][after] = sin;
    columns.0[after][next] = -sin;
    columns.0[after][after] = cos;
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_y_takes_z_to_x() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        // Twice the length: quaternions are normalised.
        let turn = Matrix::of_parts([0.0, 0.0, 5.0], [0.0, 2.0 * half, 0.0, 2.0 * half], [1.0, 1.0, 3.0]);
        let p = turn.affine().point(vec3(0.0, 0.0, 1.0));
        assert!((p - vec3(3.0, 0.0, 5.0)).length() < 1e-6, "{p:?}");
        assert!((turn.unit_axis(2).unwrap() - vec3(1.0, 0.0, 0.0)).length() < 1e-6);
        assert_eq!(Matrix::of_parts([0.0; 3], [0.0; 4], [1.0; 3]), Matrix::IDENTITY);
        assert_eq!(Matrix::of_parts([0.0; 3], [0.0; 4], [0.0; 3]).unit_axis(0), None);
    }

    #[test]
    fn products_apply_the_right_one_first() {
        let moved = Matrix::of_parts([1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], [1.0; 3]);
        let doubled = Matrix::of_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [2.0; 3]);
        assert_eq!(doubled.after(&moved).position(), vec3(2.0, 0.0, 0.0));
        assert_eq!(moved.after(&doubled).position(), vec3(1.0, 0.0, 0.0));
    }
}
