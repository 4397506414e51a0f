//! The pin-hole and thin-lens camera.

use crate::math::{Vec3, elementary64};

/// A camera in the form that ray generation reads. The lens is a disk in the plane of `right` and `up`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Camera {
    /// The pin-hole, or the middle of the lens, in world space.
    pub eye: Vec3,
    /// Radius of the lens in world units; 0 for a pin-hole.
    pub aperture_radius: f32,
    /// Unit vector along the view.
    pub forward: Vec3,
    /// Distance along `forward` of the plane that is sharp.
    pub focus_distance: f32,
    /// Unit vector to the right of the picture.
    pub right: Vec3,
    /// Half the picture's width on the plane at distance 1: tan(fov_x / 2).
    pub half_width: f32,
    /// Unit vector to the top of the picture.
    pub up: Vec3,
    /// Half the picture's height on the plane at distance 1.
    pub half_height: f32,
}

impl Camera {
    /// A pin-hole camera at `eye` that looks along `direction` (any length), with `up` (any length, not parallel
    /// to it) towards the top of the picture and a horizontal field of view in radians, over 0 and under pi. Pixels are
    /// square. Returns `None` where these do not span a view.
    pub fn looking_along(
        eye: Vec3,
        direction: Vec3,
        up: Vec3,
        fov_x_radians: f64,
        width: u32,
        height: u32,
    ) -> Option<Camera> {
        let forward = direction.normalize_or(Vec3::ZERO);
        let right = forward.cross(up.normalize_or(Vec3::ZERO)).normalize_or(Vec3::ZERO);
        let true_up = right.cross(forward);
        let half_width = elementary64::tan(fov_x_radians * 0.5);
        let half_height = half_width * (height as f64 / width as f64);
        let sane = eye.is_finite()
            && right != Vec3::ZERO
            && fov_x_radians > 0.0
            && fov_x_radians < core::f64::consts::PI
            && half_width < 1e6
            && half_height < 1e6;
        sane.then_some(Camera {
            eye,
            aperture_radius: 0.0,
            forward,
            focus_distance: 1.0,
            right,
            half_width: half_width as f32,
            up: true_up,
            half_height: half_height as f32,
        })
    }
}
