//! The camera, as people describe it.

use super::schema_types::Vector;
use eosphor_core::math::{Vec3, vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A camera. `look_at` wins over `direction` when both are given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
#[schemars(
    description = "Where the picture is taken from. Without a camera one is chosen: a closed room is seen from within, a room that is open to a side from there, \
        all else from above the front of its largest sides. Ground planes, backdrops and what is far from the rest are not framed.",
    // Of two keys that exclude each other the first is the one to drop.
    extend("allOf" = [
        { "not": { "required": ["direction", "look-at"] } },
        { "not": { "required": ["fov-x-degrees", "orthographic-height"] } },
        { "not": { "required": ["fov-y-degrees", "orthographic-height"] } },
        { "not": { "required": ["fov-x-degrees", "fov-y-degrees"] } },
    ]),
    extend("examples" = [
        { "position": [0, 2, 7], "look-at": [0, 1, 0], "fov-y-degrees": 35 },
        { "position": [0, 0, 5], "direction": [0, 0, -1], "orthographic-height": 3 },
    ]),
)]
pub struct Camera {
    /// The pin-hole, in world space.
    #[schemars(with = "Vector")]
    pub position: Vec3,
    /// A point in the middle of the picture.
    #[schemars(with = "Option<Vector>")]
    pub look_at: Option<Vec3>,
    /// The way the camera looks; any length.
    #[schemars(with = "Vector")]
    pub direction: Vec3,
    /// What is up; any length.
    #[schemars(with = "Vector")]
    pub up: Vec3,
    /// Horizontal field of view in degrees, over 0 and under 180.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub fov_x_degrees: f32,
    /// Vertical field of view in degrees, over 0 and under 180; where given it counts, and the horizontal one follows
    /// from the picture's sides.
    #[schemars(description = "Vertical field of view in degrees, instead of the horizontal one.")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub fov_y_degrees: Option<f32>,
    /// Height of the picture in world units: rays run parallel, and fields of view do not count.
    #[schemars(
        description = "Height of the picture in world units, instead of a field of view: rays run parallel."
    )]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub orthographic_height: Option<f32>,
    /// A lens of finite size, for depth of field; a pin-hole where there is none.
    pub lens: Option<Lens>,
}

/// A thin lens, for depth of field.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(extend("examples" = [{ "aperture-radius": 0.05, "focus-distance": 4 }]))]
pub struct Lens {
    /// Radius in world units.
    #[schemars(range(min = 0))]
    pub aperture_radius: f32,
    /// Distance of the plane that is sharp; where not given, that of [`Camera::look_at`].
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
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
