//! What the model allows and a scene file cannot mean: views of nothing, surfaces without extent.

use super::document::Document;
use super::tree::{Step, way};
use crate::error::SceneError;
use crate::model::{Camera, Parallelogram, RenderSettings};
use eosphor_core::math::Vec3;
use eosphor_core::settings::Integrator;

/// Edges that meet at a smaller angle (in radians, about) are parallel.
const PARALLEL: f32 = 1e-6;

fn unit(v: Vec3) -> Vec3 {
    v.normalize_or(Vec3::ZERO)
}

/// Whether the camera of the first frame looks somewhere, and knows which way is up. `is_moved`: by its motion and not by its own
/// keys.
pub(super) fn check_camera(document: &Document, camera: &Camera, is_moved: bool) -> Result<(), SceneError> {
    let wrong = |key: &str, message: &str| Err(document.error_in(&way!["camera", key], message));
    let forward = unit(camera.look_at.map_or(camera.direction, |p| p - camera.position));
    let up = unit(camera.up);
    if forward == Vec3::ZERO {
        return match camera.look_at {
            Some(_) if is_moved => {
                let message = "in the first frame the camera looks at its own position; give another point";
                Err(document.error_in(&way!["animation", "camera"], message))
            }
            Some(_) => wrong("look-at", "\"look-at\" is the camera's own position; give a point before it"),
            None => wrong("direction", "\"direction\" has no length; give the way the camera looks"),
        };
    }
    if up == Vec3::ZERO {
        return wrong("up", "\"up\" has no length; give the way to the top of the picture");
    }
    if unit(forward.cross(up)) == Vec3::ZERO {
        return wrong("up", "\"up\" is parallel to the way the camera looks; give another");
    }
    Ok(())
}

/// Whether the integrator reads all settings that the file states.
pub(super) fn check_settings(document: &Document, integrator: Integrator) -> Result<(), SceneError> {
    let Some(settings) = document.root.get("settings") else { return Ok(()) };
    let (name, other) = match integrator {
        Integrator::Whitted => ("whitted", "path"),
        Integrator::Path => ("path", "whitted"),
    };
    for key in RenderSettings::keys_not_read(integrator) {
        if settings.get(key).is_some() {
            let message = format!(
                "the integrator {name} does not read \"{key}\"; leave it out, or take \"integrator\": \"{other}\""
            );
            return Err(document.error_in(&way!["settings", *key], message));
        }
    }
    Ok(())
}

/// Whether four corners, counted from the first, span a surface.
pub(super) fn check_corners(
    document: &Document,
    number: usize,
    corners: &[Vec3; 4],
) -> Result<(), SceneError> {
    let [_, b, c, d] = corners.map(unit);
    if b.cross(c).length() < PARALLEL && c.cross(d).length() < PARALLEL {
        let message = "the corners lie on one line; they must span a surface";
        return Err(document.error_in(&way!["quadrilaterals", number, "corners"], message));
    }
    Ok(())
}

/// Whether the edges of a parallelogram span a surface.
pub(super) fn check_edges(document: &Document, number: usize, p: &Parallelogram) -> Result<(), SceneError> {
    let wrong = |key: &str, message: &str| {
        Err(document.error_in(&[Step::from("parallelograms"), number.into(), key.into()], message))
    };
    let (u, v) = (unit(p.edge_u), unit(p.edge_v));
    if u == Vec3::ZERO {
        return wrong("edge-u", "\"edge-u\" has no length; give the way from the corner to the next");
    }
    if v == Vec3::ZERO {
        return wrong("edge-v", "\"edge-v\" has no length; give the way from the corner to the next");
    }
    if u.cross(v).length() < PARALLEL {
        return wrong("edge-v", "\"edge-v\" is parallel to \"edge-u\"; the edges must span a surface");
    }
    Ok(())
}
