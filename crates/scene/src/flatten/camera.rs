//! The camera: the scene's, or the automatic one; and the headlight beside it.

use super::framing::{self, Framing, HalfSides, Motion};
use super::geometry::{self, Flat};
use super::note::Note;
use crate::error::{Problem, SceneError};
use crate::model::{Camera as ModelCamera, Scene};
use eosphor_core::camera::Camera;
use eosphor_core::geometry::Bounds;
use eosphor_core::light::Light;
use eosphor_core::math::{Vec3, elementary64};

/// The radiance of a white surface that faces the headlight, whatever the units of light.
const HEADLIGHT: f32 = 0.8;

/// The camera, and the headlight to be used where the scene has no light.
pub(super) fn build(
    scene: &Scene,
    flat: &Flat,
    world: &Bounds,
    notes: &mut Vec<Note>,
) -> Result<(Camera, Option<Light>), SceneError> {
    if world.is_empty() {
        notes.push(Note::Empty);
    }
    let [width, height] = scene.settings.size;
    let camera = match scene.camera_at(scene.frame) {
        Some(camera) => from_model(&camera, width, height)?,
        None => {
            let framing = framed(scene, flat)?;
            if !world.is_empty() {
                let position = scene.point_in_file(framing.camera.position);
                let Framing { camera, view, left_out, frames } = framing;
                notes.push(Note::FramedCamera { position, camera, view, left_out, frames });
            }
            from_model(&framing.camera, width, height)?
        }
    };
    let headlight = (!world.is_empty()).then(|| headlight(&camera));
    Ok((camera, headlight))
}

/// The camera of all frames, which is chosen by the first one. `flat` is the scene's geometry in its own frame.
pub(super) fn framed(scene: &Scene, flat: &Flat) -> Result<Framing, SceneError> {
    let [width, height] = scene.settings.size;
    let width_at_1 = half_width(&ModelCamera::default(), width, height);
    let height_at_1 = width_at_1 * (f64::from(height) / f64::from(width));
    let half = HalfSides { width: width_at_1, height: height_at_1 };
    let first = (scene.frame > 0).then(|| geometry::build(scene, 0)).transpose()?;
    let flat = first.as_ref().unwrap_or(flat);
    let surfaces = flat.surfaces();
    let motion = Motion::new(scene, &surfaces, flat.first_deforming());
    Ok(framing::frame(&surfaces, &motion, half))
}

impl Scene {
    /// Whether its camera spans a view, as flattening will ask.
    ///
    /// # Errors
    /// What is wrong with the camera.
    pub fn check_view(&self) -> Result<(), SceneError> {
        let [width, height] = self.settings.size;
        self.camera_at(self.frame).map_or(Ok(()), |camera| from_model(&camera, width, height).map(|_| ()))
    }
}

pub(super) fn from_model(camera: &ModelCamera, width: u32, height: u32) -> Result<Camera, SceneError> {
    let direction = camera.look_at.map_or(camera.direction, |p| p - camera.position);
    if direction.normalize_or(Vec3::ZERO) == Vec3::ZERO {
        let message = "it looks nowhere: direction has no length, or look-at is the camera's own position";
        return Err(Problem::new("camera", message).into());
    }
    let (eye, up) = (camera.position, camera.up);
    let built = match camera.orthographic_height {
        Some(world_height) => Camera::orthographic(eye, direction, up, world_height, width, height),
        None => Camera::perspective(eye, direction, up, half_width(camera, width, height), width, height),
    };
    let mut built = built.ok_or_else(|| {
        let message = "it spans no view: up must have a length and not be parallel to the way it looks, and the \
                       field of view must not be too near 180 degrees for this size";
        Problem::new("camera", message)
    })?;
    if let Some(lens) = camera.lens {
        built.aperture_radius = lens.aperture_radius;
        // Scene::validate has seen to it that one of both is there.
        built.focus_distance = lens.focus_distance.unwrap_or_else(|| direction.length());
    }
    Ok(built)
}

/// Half the picture's width on the plane at distance 1.
fn half_width(camera: &ModelCamera, width: u32, height: u32) -> f64 {
    let tan_half =
        |degrees: f32| elementary64::tan(f64::from(degrees) * (std::f64::consts::PI / 180.0) * 0.5);
    match camera.fov_y_degrees {
        Some(fov_y) => tan_half(fov_y) * (f64::from(width) / f64::from(height)),
        None => tan_half(camera.fov_x_degrees),
    }
}

/// A point light at the camera. It is the only light where it is used, and then there is no falloff: near and far are
/// equally bright, inside a room as well as before an object.
pub(super) fn headlight(camera: &Camera) -> Light {
    Light::Point { position: camera.eye, color: Vec3::splat(HEADLIGHT) }
}
