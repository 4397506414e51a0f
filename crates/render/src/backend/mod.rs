//! Backends: who turns a scene into a film. All give the same bits.

pub(crate) mod cpu;

use crate::{Film, HierarchyStatistics, RayStatistics};
use eosphor_scene::SceneData;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A device, or all cores of the CPU.
pub trait Backend: Send + Sync {
    /// For messages: what it runs on.
    fn describe(&self) -> String;

    /// Builds the hierarchy and whatever else the device needs.
    fn prepare(&self, scene: Arc<SceneData>) -> Result<Box<dyn PreparedScene>, BackendError>;
}

/// A scene that is ready to be rendered.
pub trait PreparedScene: Send + Sync {
    /// The hierarchy in numbers.
    fn hierarchy_statistics(&self) -> HierarchyStatistics;

    /// Renders the picture. Where [`RenderControl::cancel`] is raised, returns soon with what is done.
    fn render(&self, control: &RenderControl) -> Result<Rendered, BackendError>;
}

/// What every backend asks before it builds: devices follow the scene's numbers without looking.
pub fn check_scene(scene: &SceneData) -> Result<(), BackendError> {
    scene
        .check()
        .map_err(|problem| BackendError::Failed(format!("the scene does not hold together: {problem}")))
}

/// How far a render is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Pixels finished.
    pub pixels_done: u64,
    /// Pixels in all.
    pub pixels_total: u64,
    /// Rays traced so far.
    pub rays: u64,
}

/// How a render is watched and stopped.
pub struct RenderControl<'a> {
    /// Called now and then, from any thread.
    pub on_progress: &'a (dyn Fn(Progress) + Sync),
    /// When raised, the render ends early.
    pub cancel: &'a AtomicBool,
    /// Count nodes and primitive tests of each ray. Rays are then traced one by one: up to four times slower.
    pub count_work: bool,
}

/// What a render gives back.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The picture; pixels that were not reached are black.
    pub film: Film,
    /// False where the render was cancelled before its end.
    pub complete: bool,
    /// Rays and work.
    pub statistics: RayStatistics,
}

/// Why a backend failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BackendError {
    /// The device is not there, or its driver.
    #[error("{0}")]
    Unavailable(String),
    /// The scene or the film does not fit.
    #[error("{0}")]
    OutOfMemory(String),
    /// Anything else.
    #[error("{0}")]
    Failed(String),
}
