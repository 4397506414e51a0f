//! How objects are placed.

use super::matrix::{Matrix, about};
use super::schema_types::{Scale, Vector};
use eosphor_core::math::{Affine, Vec3, elementary64, vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// Scale, then rotation about x, y and z (degrees, in this order), then translation; or a whole 3 x 4 matrix.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
#[schemars(
    description = "Scale, then rotation about x, y and z, then translation, then the matrix.",
    extend("examples" = [{ "scale": 0.5, "rotate-degrees": [0, 90, 0], "translate": [1, 0, 0] }]),
)]
pub struct Transform {
    /// Scale along the axes.
    #[serde(deserialize_with = "one_or_three")]
    #[schemars(with = "Scale")]
    pub scale: Vec3,
    /// Degrees about x, then y, then z.
    #[schemars(with = "Vector")]
    pub rotate_degrees: Vec3,
    /// Moves the object.
    #[schemars(with = "Vector")]
    pub translate: Vec3,
    /// A row-major 3 x 4 matrix, applied after the above.
    pub matrix: Option<[[f32; 4]; 3]>,
    /// Moves the object last, in double precision: for what lies so far that single precision would lose its place.
    #[serde(skip)]
    #[schemars(skip)]
    pub offset: [f64; 3],
}

impl Default for Transform {
    fn default() -> Transform {
        Transform {
            scale: Vec3::ONE,
            rotate_degrees: Vec3::ZERO,
            translate: Vec3::ZERO,
            matrix: None,
            offset: [0.0; 3],
        }
    }
}

impl Transform {
    /// Moves by `offset`.
    pub fn translation(offset: Vec3) -> Transform {
        Transform { translate: offset, ..Transform::default() }
    }

    /// The transform that is this map.
    pub fn from_affine(map: &Affine) -> Transform {
        let [a, b, c] = map.columns;
        let row = |axis: usize| [a[axis], b[axis], c[axis], map.translation[axis]];
        Transform { matrix: Some([row(0), row(1), row(2)]), ..Transform::default() }
    }

    /// The transform with the linear part of this map, which takes the object's origin there.
    pub(crate) fn exactly(map: &Affine, offset: [f64; 3]) -> Transform {
        if map.columns == Affine::IDENTITY.columns {
            return Transform { offset, ..Transform::default() };
        }
        let linear = Affine { translation: Vec3::ZERO, ..*map };
        Transform { offset, ..Transform::from_affine(&linear) }
    }

    /// The map from object to world space.
    pub fn affine(&self) -> Affine {
        match self.offset == [0.0; 3] {
            true => self.without_offset(),
            false => self.to_double().affine(),
        }
    }

    /// The map in double precision, with its offset in full.
    pub(crate) fn to_double(self) -> Matrix {
        let mut map = Matrix::of_affine(&self.without_offset());
        if self.offset != [0.0; 3] {
            map.0[3] = add(map.0[3], self.offset);
        }
        map
    }

    /// The same map after the coordinates of both its spaces have been shifted by `by`. `exact` is this map in double precision.
    pub(crate) fn conjugated(&self, by: [f64; 3], exact: &Matrix) -> Transform {
        let [a, b, c, _] = exact.0;
        let turned = Matrix([a, b, c, [0.0; 3]]).point(by);
        // What cancels goes first: a translation stays as it is.
        let stays = [0, 1, 2].map(|axis| by[axis] - turned[axis]);
        Transform::exactly(&self.affine(), add(exact.0[3], stays))
    }

    fn without_offset(&self) -> Affine {
        let s = self.scale;
        let scale = Affine {
            columns: [vec3(s.x, 0.0, 0.0), vec3(0.0, s.y, 0.0), vec3(0.0, 0.0, s.z)],
            translation: Vec3::ZERO,
        };
        let rotate = (0..3).fold(Affine::IDENTITY, |before, axis| {
            rotation(axis, self.rotate_degrees[axis] as f64).after(&before)
        });
        let mut placed = rotate.after(&scale);
        placed.translation = self.translate;
        match self.matrix {
            None => placed,
            Some([x, y, z]) => {
                let column = |k: usize| vec3(x[k], y[k], z[k]);
                Affine { columns: [column(0), column(1), column(2)], translation: column(3) }.after(&placed)
            }
        }
    }
}

/// A transform as people write it, in double precision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExactTransform {
    pub(crate) scale: [f64; 3],
    pub(crate) rotate_degrees: [f64; 3],
    pub(crate) translate: [f64; 3],
    pub(crate) matrix: Option<[[f64; 4]; 3]>,
}

impl ExactTransform {
    pub(crate) fn map(&self) -> Matrix {
        let sized = Matrix::of_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], self.scale);
        let mut placed =
            (0..3).fold(sized, |before, axis| about(axis, self.rotate_degrees[axis]).after(&before));
        placed.0[3] = self.translate;
        match self.matrix {
            None => placed,
            Some(rows) => Matrix([0, 1, 2, 3].map(|column| rows.map(|row| row[column]))).after(&placed),
        }
    }
}

/// The sum of two vectors.
pub(crate) fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// In double precision.
pub(crate) fn double(v: Vec3) -> [f64; 3] {
    <[f32; 3]>::from(v).map(f64::from)
}

/// Rounded to single precision.
pub(crate) fn single(v: [f64; 3]) -> Vec3 {
    v.map(|x| x as f32).into()
}

/// Reads one number for all axes, or three.
pub(super) fn one_or_three<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec3, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum OneOrThree {
        One(f32),
        Three(Vec3),
    }
    Ok(match OneOrThree::deserialize(deserializer)? {
        OneOrThree::One(scale) => Vec3::splat(scale),
        OneOrThree::Three(scale) => scale,
    })
}

/// Rotation about a coordinate axis, counter-clockwise seen from its tip.
fn rotation(axis: usize, degrees: f64) -> Affine {
    if degrees == 0.0 {
        return Affine::IDENTITY;
    }
    let radians = degrees * (std::f64::consts::PI / 180.0);
    let (sin, cos) = (elementary64::sin(radians) as f32, elementary64::cos(radians) as f32);
    let columns = match axis {
        0 => [vec3(1.0, 0.0, 0.0), vec3(0.0, cos, sin), vec3(0.0, -sin, cos)],
        1 => [vec3(cos, 0.0, -sin), vec3(0.0, 1.0, 0.0), vec3(sin, 0.0, cos)],
        _ => [vec3(cos, sin, 0.0), vec3(-sin, cos, 0.0), vec3(0.0, 0.0, 1.0)],
    };
    Affine { columns, translation: Vec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turn_about_z_takes_x_to_y() {
        let turn = Transform { rotate_degrees: vec3(0.0, 0.0, 90.0), ..Transform::default() };
        let p = turn.affine().point(vec3(1.0, 0.0, 5.0));
        assert!((p - vec3(0.0, 1.0, 5.0)).length() < 1e-6);
    }

    #[test]
    fn scale_comes_before_rotation_and_translation_last() {
        let t = Transform {
            scale: vec3(2.0, 1.0, 1.0),
            rotate_degrees: vec3(0.0, 0.0, 90.0),
            translate: vec3(10.0, 0.0, 0.0),
            ..Transform::default()
        };
        let p = t.affine().point(vec3(1.0, 0.0, 0.0));
        assert!((p - vec3(10.0, 2.0, 0.0)).length() < 1e-5);
    }

    #[test]
    fn matrix_form_is_the_same_map() {
        let t = Transform { rotate_degrees: vec3(10.0, 20.0, 30.0), ..Transform::translation(Vec3::ONE) };
        assert_eq!(Transform::from_affine(&t.affine()).affine(), t.affine());
    }

    #[test]
    fn inverse_undoes_the_map() {
        let t = Transform {
            scale: vec3(2.0, -3.0, 0.5),
            rotate_degrees: vec3(10.0, 20.0, 30.0),
            translate: vec3(1.0, 2.0, 3.0),
            ..Transform::default()
        };
        let (to, from) = (t.affine(), t.affine().inverse().unwrap());
        let p = vec3(0.3, -0.7, 11.0);
        assert!((from.point(to.point(p)) - p).length() < 1e-5);
    }
}
