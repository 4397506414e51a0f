//! Where a scene comes from, again and again.

use eosphor::{Backend, Scene};
use std::path::PathBuf;

/// What a viewer shows: reads the scene when it starts, and again whenever one of its files has changed.
pub trait SceneSource: Send + Sync {
    /// The name of the scene, for the page.
    fn name(&self) -> String;

    /// Reads the scene.
    ///
    /// # Errors
    ///
    /// What is wrong with its files, in lines for readers.
    fn read(&self) -> Result<SourceScene, SourceError>;

    /// The backend that renders.
    ///
    /// # Errors
    ///
    /// Where there is none.
    fn backend(&self) -> Result<Box<dyn Backend>, SourceError>;

    /// The command line that renders the scene as it was read, with these flags after its own, as a shell reads it:
    /// `eosphor render FILE FLAGS`.
    fn command(&self, flags: Vec<String>) -> String;
}

/// A scene that was read.
pub struct SourceScene {
    /// The scene, with all that flags change.
    pub scene: Scene,
    /// The files that it was read from.
    pub files: Vec<PathBuf>,
}

/// Why there is nothing to show; the text is for readers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SourceError(pub String);
