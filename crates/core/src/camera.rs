//! The pin-hole and thin-lens camera.

use crate::math::{Vec3, elementary64};

/// How a camera sees depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Projection {
    /// Rays run through the eye, or the lens.
    Perspective,
    /// Rays run along `forward`; half sides are lengths in the world, and the lens does not count.
    Orthographic,
}

/// A camera in the form that ray generation reads. The lens is a disk in the plane of `right` and `up`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    /// How it sees depth.
    pub projection: Projection,
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
        let sane = fov_x_radians > 0.0 && fov_x_radians < core::f64::consts::PI;
        let half_width = elementary64::tan(fov_x_radians * 0.5);
        if sane { Camera::perspective(eye, direction, up, half_width, width, height) } else { None }
    }

    /// The same by half the picture's width on the plane at distance 1.
    pub fn perspective(
        eye: Vec3,
        direction: Vec3,
        up: Vec3,
        half_width: f64,
        width: u32,
        height: u32,
    ) -> Option<Camera> {
        let half_height = half_width * (height as f64 / width as f64);
        let sane = half_width > 0.0 && half_width < 1e6 && half_height < 1e6;
        let camera = Camera::placed(eye, direction, up, Projection::Perspective)?;
        sane.then_some(Camera { half_width: half_width as f32, half_height: half_height as f32, ..camera })
    }

    /// The same with parallel rays; the picture is `world_height` world units high.
    pub fn orthographic(
        eye: Vec3,
        direction: Vec3,
        up: Vec3,
        world_height: f32,
        width: u32,
        height: u32,
    ) -> Option<Camera> {
        let half_height = world_height as f64 * 0.5;
        let half_width = half_height * (width as f64 / height as f64);
        let sane = half_height > 0.0 && half_width < 1e18 && half_height < 1e18;
        let camera = Camera::placed(eye, direction, up, Projection::Orthographic)?;
        sane.then_some(Camera { half_width: half_width as f32, half_height: half_height as f32, ..camera })
    }

    /// Where it is and how it is turned.
    fn placed(eye: Vec3, direction: Vec3, up: Vec3, projection: Projection) -> Option<Camera> {
        let forward = direction.normalize_or(Vec3::ZERO);
        let right = forward.cross(up.normalize_or(Vec3::ZERO)).normalize_or(Vec3::ZERO);
        (eye.is_finite() && right != Vec3::ZERO).then_some(Camera {
            eye,
            aperture_radius: 0.0,
            forward,
            focus_distance: 1.0,
            right,
            half_width: 1.0,
            up: right.cross(forward),
            half_height: 1.0,
            projection,
        })
    }
}
