//! The short way from scene to film.

use crate::Error;
use eosphor_render::{Backend, RenderControl, Rendered};
use eosphor_scene::{Scene, SceneData};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Renders a scene as its settings say: flattens it, builds the hierarchy, traces all rays.
///
/// The picture depends on the scene alone, not on the backend, its threads or its hierarchy.
///
/// # Errors
///
/// [`Error::Scene`] where the scene contradicts itself or a setting is out of range; [`Error::Backend`] where the
/// device fails.
pub fn render(scene: &Scene, backend: &dyn Backend) -> Result<Rendered, Error> {
    let (data, _notes) = SceneData::flatten(scene)?;
    let prepared = backend.prepare(Arc::new(data))?;
    let control = RenderControl {
        on_progress: &|_| {},
        cancel: &AtomicBool::new(false),
        count_work: false,
        frame: None,
    };
    Ok(prepared.render(&control)?)
}
