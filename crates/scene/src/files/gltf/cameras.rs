//! Cameras of the scene, in the order of its nodes.

use super::accessors::Budget;
use super::document::{self, CameraType, Document};
use super::nodes::Nodes;
use super::{Part, quoted};
use crate::files::warnings::Warnings;
use crate::model::{Camera, Move, Scene};
use std::path::Path;
use std::sync::Arc;

/// A camera and what it is called.
pub(super) struct NamedCamera {
    /// The camera's own name and that of its node.
    names: [Option<String>; 2],
    /// Before it moves, in coordinates of the file.
    camera: Camera,
    position: [f64; 3],
    pub(super) moves: Vec<Arc<Move>>,
}

impl NamedCamera {
    /// The camera of a scene, before it moves; motions begin in coordinates of the file.
    pub(super) fn in_scene(&self, scene: &Scene) -> Camera {
        match self.moves.is_empty() {
            true => Camera { position: scene.point_of_file(self.position), ..self.camera },
            false => self.camera,
        }
    }
}

/// All cameras of the placed nodes. What cannot look has warned and is left out.
pub(super) fn placed(
    warnings: &mut Warnings,
    path: &Path,
    root: &Document,
    nodes: &Nodes,
    budget: &Budget,
) -> Result<Vec<NamedCamera>, String> {
    let mut cameras = Vec::new();
    for placed in &nodes.placed {
        let Some(index) = root.nodes[placed.node].camera else { continue };
        let number = index.value();
        let Some(file) = root.cameras.get(number) else {
            let message = format!("camera {number} does not exist; there are {}", root.cameras.len());
            warnings.add(path, None, message);
            continue;
        };
        // It looks along its own -z, and its up is +y.
        let axes = (placed.world.unit_axis(2), placed.world.unit_axis(1));
        let mut camera = Camera { position: placed.world.position(), ..Camera::default() };
        let is_right = match axes {
            (Some(backward), Some(up)) => {
                (camera.direction, camera.up) = (-backward, up);
                backward.cross(up).length() > 1e-3 && open(&mut camera, file)
            }
            _ => false,
        };
        if is_right {
            let names = [file.name.clone(), root.nodes[placed.node].name.clone()];
            let position = placed.world.0[3];
            cameras.push(NamedCamera { names, camera, position, moves: nodes.moves(placed, budget)? });
        } else {
            let name = Part::new("camera", number, file.name.as_deref());
            let message = format!(
                "{name} has no view: its node squashes it, or its angle or height is not over 0 \
                                   (an angle must be under 180 degrees); it is left out"
            );
            warnings.add(path, None, message);
        }
    }
    Ok(cameras)
}

/// The field of view; whether there is one.
fn open(camera: &mut Camera, file: &document::Camera) -> bool {
    match (file.camera_type, &file.perspective, &file.orthographic) {
        (Some(CameraType::Orthographic), _, Some(view)) => {
            // The magnification is half the height.
            let height = 2.0 * view.ymag.abs();
            camera.orthographic_height = Some(height);
            height > 0.0 && height <= 1e12
        }
        (Some(CameraType::Perspective), Some(view), _) => {
            let degrees = (f64::from(view.yfov) * (180.0 / std::f64::consts::PI)) as f32;
            camera.fov_y_degrees = Some(degrees);
            degrees > 0.0 && degrees < 180.0
        }
        _ => false,
    }
}

/// The camera of this name or number, the first without; several, of which none was chosen, warn.
pub(super) fn choose<'a>(
    warnings: &mut Warnings,
    path: &Path,
    cameras: &'a [NamedCamera],
    choice: Option<&str>,
) -> Result<Option<&'a NamedCamera>, String> {
    let Some(choice) = choice else {
        if cameras.len() > 1 {
            let message =
                format!("there are {} cameras: {}; the first is taken", cameras.len(), list(cameras));
            warnings.add(path, None, message);
        }
        return Ok(cameras.first());
    };
    // Names come first: a camera may be called "1".
    let named = (0..2).find_map(|k| cameras.iter().find(|c| c.names[k].as_deref() == Some(choice)));
    let numbered = || choice.parse::<usize>().ok().and_then(|number| cameras.get(number));
    match named.or_else(numbered) {
        Some(found) => Ok(Some(found)),
        None if cameras.is_empty() => {
            Err(format!("there is no camera {}; the file has none", quoted(choice)))
        }
        None => Err(format!("there is no camera {}; there are {}", quoted(choice), list(cameras))),
    }
}

/// The first ones, by number and name.
fn list(cameras: &[NamedCamera]) -> String {
    const LISTED: usize = 20;
    let entry = |(number, camera): (usize, &NamedCamera)| match camera.names.iter().flatten().next() {
        Some(name) => format!("{number} {}", quoted(name)),
        None => number.to_string(),
    };
    let more = if cameras.len() > LISTED { ", ..." } else { "" };
    cameras.iter().enumerate().take(LISTED).map(entry).collect::<Vec<_>>().join(", ") + more
}
