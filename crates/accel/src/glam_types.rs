//! Conversions between vectors and maps of glam and those of this crate.

use eosphor_core::math::{Affine, Vec3};

/// Makes a vector or map of this crate from one of glam, number by number.
///
/// ```
/// use eosphor_accel::{Bvh8, FromGlam, Ray, ToGlam, Vec3};
///
/// let corners = [glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y];
/// let bvh = Bvh8::from_vertices(&corners, |corner| corner.to_array(), &[[0, 1, 2]])?;
/// let origin = glam::vec3(0.25, 0.25, 2.0);
/// let ray = Ray::new(Vec3::from_glam(origin), Vec3::from_glam(glam::Vec3::NEG_Z));
/// let hit = bvh.closest_hit(&ray).expect("the triangle is in the way");
/// assert_eq!(hit.point(&ray).to_glam(), glam::vec3(0.25, 0.25, 0.0));
/// # Ok::<(), eosphor_accel::SceneError>(())
/// ```
pub trait FromGlam<G> {
    /// The vector or map with the numbers of `value`.
    fn from_glam(value: G) -> Self;
}

/// Makes a vector or map of glam from one of this crate, number by number.
pub trait ToGlam {
    /// The type of glam: `glam::Vec3` for a vector, `glam::Affine3A` for a map.
    type Glam;
    /// The vector or map of glam with the same numbers.
    fn to_glam(self) -> Self::Glam;
}

impl FromGlam<glam::Vec3> for Vec3 {
    fn from_glam(value: glam::Vec3) -> Vec3 {
        value.to_array().into()
    }
}

impl FromGlam<glam::Vec3A> for Vec3 {
    fn from_glam(value: glam::Vec3A) -> Vec3 {
        value.to_array().into()
    }
}

impl FromGlam<glam::Affine3A> for Affine {
    fn from_glam(value: glam::Affine3A) -> Affine {
        let linear = value.matrix3;
        Affine {
            columns: [linear.x_axis, linear.y_axis, linear.z_axis].map(Vec3::from_glam),
            translation: Vec3::from_glam(value.translation),
        }
    }
}

impl ToGlam for Vec3 {
    type Glam = glam::Vec3;
    fn to_glam(self) -> glam::Vec3 {
        glam::Vec3::from_array(self.into())
    }
}

impl ToGlam for Affine {
    type Glam = glam::Affine3A;
    fn to_glam(self) -> glam::Affine3A {
        let [x, y, z] = self.columns.map(|column| glam::Vec3A::from_array(column.into()));
        let translation = glam::Vec3A::from_array(self.translation.into());
        glam::Affine3A { matrix3: glam::Mat3A::from_cols(x, y, z), translation }
    }
}
