//! The camera: the scene's, or one that frames the whole scene; and the headlight beside it.

use super::note::Note;
use crate::error::{Problem, SceneError};
use crate::model::{Camera as ModelCamera, Scene};
use eosphor_core::camera::Camera;
use eosphor_core::geometry::Bounds;
use eosphor_core::light::Light;
use eosphor_core::math::{Vec3, elementary64, vec3};

/// From the middle of the scene to a camera that frames it: from the front, so that open boxes show their inside.
const TO_EYE: Vec3 = vec3(0.0, 0.0, 1.0);

/// The same for scenes as flat as a table, which the front would show as a line: from above, too.
const TO_EYE_OF_FLAT: Vec3 = vec3(0.0, 0.6, 0.8);

/// Scenes this much deeper than high are flat.
const FLAT: f32 = 4.0;

/// Room around a framed scene.
const MARGIN: f32 = 1.05;

/// The radiance of a white surface that faces the headlight, whatever the units of light.
const HEADLIGHT: f32 = 0.8;

/// The camera, and the headlight to be used where the scene has no light.
pub(super) fn build(
    scene: &Scene,
    world: &Bounds,
    notes: &mut Vec<Note>,
) -> Result<(Camera, Option<Light>), SceneError> {
    if world.is_empty() {
        notes.push(Note::Empty);
    }
    let [width, height] = scene.settings.size;
    let camera = match scene.camera_at(0) {
        Some(camera) => from_model(&camera, width, height)?,
        None => {
            let camera = framing(world, width, height)?;
            if !world.is_empty() {
                notes.push(Note::FramedCamera { position: scene.point_in_file(camera.eye) });
            }
            camera
        }
    };
    let headlight = (!world.is_empty()).then(|| headlight(&camera));
    Ok((camera, headlight))
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

/// A camera with 45 degrees that sees all eight corners of the scene's box.
fn framing(world: &Bounds, width: u32, height: u32) -> Result<Camera, SceneError> {
    let middle = if world.is_empty() { Vec3::ZERO } else { world.center() };
    let sides = world.max - world.min;
    let to_eye = if sides.z > sides.y * FLAT { TO_EYE_OF_FLAT } else { TO_EYE };
    let look =
        ModelCamera { position: middle, direction: -to_eye, fov_x_degrees: 45.0, ..ModelCamera::default() };
    let mut camera = from_model(&look, width, height)?;
    let mut distance = 0.0f32;
    if !world.is_empty() {
        let half = (world.max - world.min) * 0.5;
        for corner in 0..8 {
            let side = |bit: u32, x: f32| if corner & bit == 0 { -x } else { x };
            let p = vec3(side(1, half.x), side(2, half.y), side(4, half.z));
            // A point is inside where |x| <= half_width * depth, likewise y; depth is distance + p.forward.
            let need_x = p.dot(camera.right).abs() / camera.half_width;
            let need_y = p.dot(camera.up).abs() / camera.half_height;
            distance = distance.max(need_x.max(need_y) - p.dot(camera.forward));
        }
    }
    // A single point is looked at from some way off.
    if distance <= middle.abs().max_component() * 1e-6 {
        distance = middle.abs().max_component().max(1.0);
    }
    camera.eye = middle.along(camera.forward, -distance * MARGIN);
    Ok(camera)
}

/// A point light at the camera. It is the only light where it is used, and then there is no falloff: near and far are
/// equally bright, inside a room as well as before an object.
pub(super) fn headlight(camera: &Camera) -> Light {
    Light::Point { position: camera.eye, color: Vec3::splat(HEADLIGHT) }
}
