//! Hierarchies over scenes.

use crate::BackendError;
use eosphor_accel::{Accel, Builder, GeometryError, Hierarchy, HierarchyOptions, SceneGeometry};
use eosphor_core::settings::Integrator;
use eosphor_scene::SceneData;

/// A scene as builders read it.
///
/// # Errors
/// Where the scene's arrays do not hold together, or coordinates are out of range.
pub fn geometry_of(scene: &SceneData) -> Result<SceneGeometry<'_>, GeometryError> {
    SceneGeometry::new(&scene.triangles, &scene.spheres, &scene.geometries, &scene.instances)
}

/// A hierarchy over a scene, built on the threads of the current rayon pool. Options that the structure does not have change
/// nothing.
///
/// # Errors
/// As [`geometry_of`].
pub fn build_hierarchy(
    accel: Accel,
    options: &HierarchyOptions,
    scene: &SceneData,
) -> Result<Hierarchy, BackendError> {
    let geometry = geometry_of(scene).map_err(|error| does_not_hold_together(&error))?;
    Ok(Hierarchy::build(accel, options, &geometry))
}

/// The options, with a builder by how much is to be traced where none is asked for: from so many samples of path tracing a triangle
/// on, triangles are cut ([`Builder::Spatial`]).
pub fn options_by_work(
    options: HierarchyOptions,
    scene: &SceneData,
    samples_worth_cutting: u64,
) -> HierarchyOptions {
    let settings = &scene.settings;
    let samples = u64::from(settings.width) * u64::from(settings.height) * u64::from(settings.samples);
    let is_worth = settings.integrator == Integrator::Path
        && samples / samples_worth_cutting.max(1) >= scene.triangles.len() as u64;
    HierarchyOptions { builder: options.builder.or(is_worth.then_some(Builder::Spatial)), ..options }
}

/// What every backend asks before it builds: devices follow the scene's numbers without looking.
///
/// # Errors
/// Where the scene's arrays do not hold together.
pub fn check_scene(scene: &SceneData) -> Result<(), BackendError> {
    scene.check().map_err(|problem| does_not_hold_together(&problem))
}

pub(crate) fn does_not_hold_together(why: &dyn std::fmt::Display) -> BackendError {
    BackendError::Failed(format!("the scene does not hold together: {why}"))
}
