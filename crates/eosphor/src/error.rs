//! Whatever can fail between a scene and a picture file.

use crate::job::JobError;
use eosphor_picture::compare::CompareError;
use eosphor_picture::output::OutputError;
use eosphor_render::BackendError;
use eosphor_scene::SceneError;

/// Whatever can fail between a scene and a picture file. Its text is one line: what, where, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene could not be read or prepared.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The device failed.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// A picture could not be written or read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Two pictures cannot be compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// A job has failed.
    #[error(transparent)]
    Job(#[from] JobError),
}
