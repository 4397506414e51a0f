//! The camera, as people describe it.

use eosphor_core::math::{Vec3, vec3};
use serde::{Deserialize, Serialize};

/// A camera. `look_at` wins over `direction` when both are given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct Camera {
    /// The pin-hole, in world space.
    pub position: Vec3,
    /// A point in the middle of the picture.
    pub look_at: Option<Vec3>,
    /// The way the camera looks; any length.
    pub direction: Vec3,
    /// What is up; any length.
    pub up: Vec3,
    /// Horizontal field of view in degrees, over 0 and under 180.
    pub fov_x_degrees: f32,
    /// Vertical field of view in degrees, over 0 and under 180; where given it counts, and the horizontal one follows
    /// from the picture's sides.
    pub fov_y_degrees: Option<f32>,
    /// Height of the picture in world units: rays run parallel, and fields of view do not count.
    pub orthographic_height: Option<f32>,
    /// A lens of finite size; `None` is a pin-hole.
    pub lens: Option<Lens>,
}

/// A thin lens, for depth of field.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Lens {
    /// Radius in world units.
    pub aperture_radius: f32,
    /// Distance of the plane that is sharp; `None`: that of `look_at`.
    #[serde(default)]
    pub focus_distance: Option<f32>,
}

impl Default for Camera {
    fn default() -> Camera {
        Camera {
            position: vec3(0.0, 0.0, 5.0),
            look_at: None,
            direction: vec3(0.0, 0.0, -1.0),
            up: vec3(0.0, 1.0, 0.0),
            fov_x_degrees: 45.0,
            fov_y_degrees: None,
            orthographic_height: None,
            lens: None,
        }
    }
}
