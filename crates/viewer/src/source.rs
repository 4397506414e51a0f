//! Where a scene comes from, again and again.

use eosphor::{Backend, CpuOptions, Scene};
use serde::{Deserialize, Serialize};
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

    /// The backend that renders: one that was chosen on a page, or that of the start.
    ///
    /// # Errors
    ///
    /// Where there is none.
    fn backend(&self, choice: Option<&DeviceChoice>) -> Result<Box<dyn Backend>, SourceError>;

    /// The devices that pages may choose from; the first one is that of the start. Where there are none, pages cannot choose.
    fn devices(&self) -> Vec<Device> {
        Vec::new()
    }

    /// How the CPU traces what is shown instead of the picture: normals, depths, costs.
    fn cpu_options(&self, _choice: Option<&DeviceChoice>) -> CpuOptions {
        CpuOptions::default()
    }

    /// The command line that renders the scene as it was read, with these flags after its own, as a shell reads it:
    /// `eosphor render FILE FLAGS`.
    fn command(&self, flags: Vec<String>) -> String;

    /// The text of a scene file that shows what a page shows: the scene as it was read, with another camera and other settings.
    ///
    /// # Errors
    ///
    /// Where no file can say it, in a line for readers.
    fn scene_file(&self, _shown: &Scene) -> Result<String, SourceError> {
        Err(SourceError("this viewer saves no scenes".into()))
    }
}

/// A scene that was read.
pub struct SourceScene {
    /// The scene, with all that flags change.
    pub scene: Scene,
    /// The files that it was read from.
    pub files: Vec<PathBuf>,
}

/// A device, and the hierarchies that rays can be traced through on it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Device {
    /// Its name, as `--backend` has it.
    pub backend: String,
    /// Names of hierarchies, as `--accel` has them; the first one is that of the start.
    pub accels: Vec<String>,
}

/// One of the devices with one of its hierarchies.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct DeviceChoice {
    /// The name of the device.
    pub backend: String,
    /// The name of the hierarchy.
    pub accel: String,
}

/// Why there is nothing to show; the text is for readers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SourceError(pub String);
